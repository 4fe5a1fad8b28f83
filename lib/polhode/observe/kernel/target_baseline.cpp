#include "polhode/observe/kernel/kernel.hpp"

namespace polhode::brightness {
extern const Kernels k_kernels_baseline;
const Kernels k_kernels_baseline = {"baseline", kLanes, turn, ellipsoid_area, ellipsoid_lommel_seeliger, facets_at};
}  // namespace polhode::brightness
