#define POLHODE_TARGET baseline
#include "polhode/motion/theta/target.hpp"

namespace polhode::theta {
extern const Target k_target_baseline;
const Target k_target_baseline = target_named("baseline");
}  // namespace polhode::theta
