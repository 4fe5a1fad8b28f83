#define POLHODE_TARGET avx512
#include "polhode/motion/taylor/run.hpp"

namespace polhode::taylor {
extern const Kernel k_kernel_avx512;
const Kernel k_kernel_avx512 = {"avx512", advance_entry, coefficients_entry, vary_entry, evaluate};
}  // namespace polhode::taylor
