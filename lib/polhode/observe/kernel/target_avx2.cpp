#define POLHODE_TARGET avx2
#include "polhode/observe/kernel/kernel.hpp"

namespace polhode::brightness {
extern const Kernels k_kernels_avx2;
const Kernels k_kernels_avx2 = {"avx2", kLanes, turn, ellipsoid_area, ellipsoid_lommel_seeliger, facets_at};
}  // namespace polhode::brightness
