#define POLHODE_TARGET baseline
#include "polhode/motion/variation/kernel.hpp"

namespace polhode::variation {
extern const Kernel k_kernel_baseline;
const Kernel k_kernel_baseline = kernel("baseline");
}  // namespace polhode::variation
