#define POLHODE_TARGET avx2
#include "polhode/motion/taylor/run.hpp"

namespace polhode::taylor {
extern const Kernel k_kernel_avx2;
const Kernel k_kernel_avx2 = {"avx2", advance_entry, coefficients_entry, vary_entry, evaluate};
}  // namespace polhode::taylor
