#define POLHODE_TARGET avx2
#include "polhode/motion/theta/target.hpp"

namespace polhode::theta {
extern const Target k_target_avx2;
const Target k_target_avx2 = target_named("avx2");
}  // namespace polhode::theta
