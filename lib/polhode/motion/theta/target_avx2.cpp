#define POLHODE_TARGET avx2
#include "polhode/motion/theta/target.hpp"

namespace polhode::theta {
extern const Target k_target_avx2;
const Target k_target_avx2 = {"avx2",           kLanes,   build_any_span,          build_short_span,
                              at_one,           batch_of, build_partials_any_span, partials_at_one,
                              partials_batch_of};
}  // namespace polhode::theta
