#define POLHODE_TARGET avx2
#include "polhode/motion/variation/kernel.hpp"

namespace polhode::variation {
extern const Kernel k_kernel_avx2;
const Kernel k_kernel_avx2 = kernel("avx2");
}  // namespace polhode::variation
