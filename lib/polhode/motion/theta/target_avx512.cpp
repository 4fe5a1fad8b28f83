#define POLHODE_TARGET avx512
#include "polhode/motion/theta/target.hpp"

namespace polhode::theta {
extern const Target k_target_avx512;
const Target k_target_avx512 = target_named("avx512");
}  // namespace polhode::theta
