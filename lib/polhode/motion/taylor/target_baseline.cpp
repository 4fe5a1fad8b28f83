#define POLHODE_TARGET baseline
#include "polhode/motion/taylor/run.hpp"

namespace polhode::taylor {
extern const Kernel k_kernel_baseline;
const Kernel k_kernel_baseline = {"baseline", advance_entry, coefficients_entry, vary_entry, evaluate};
}  // namespace polhode::taylor
