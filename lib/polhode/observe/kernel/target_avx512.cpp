#define POLHODE_TARGET avx512
#include "polhode/observe/kernel/kernel.hpp"

namespace polhode::brightness {
extern const Kernels k_kernels_avx512;
const Kernels k_kernels_avx512 = {"avx512", kLanes, turn, ellipsoid_area, ellipsoid_lommel_seeliger, facets_at};
}  // namespace polhode::brightness
