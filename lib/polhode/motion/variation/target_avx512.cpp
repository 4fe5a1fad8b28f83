#define POLHODE_TARGET avx512
#include "polhode/motion/variation/kernel.hpp"

namespace polhode::variation {
extern const Kernel k_kernel_avx512;
const Kernel k_kernel_avx512 = kernel("avx512");
}  // namespace polhode::variation
