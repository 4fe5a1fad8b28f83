#define POLHODE_TARGET baseline
#include "polhode/motion/theta/target.hpp"

namespace polhode::theta {
extern const Target k_target_baseline;
const Target k_target_baseline = {"baseline",       kLanes,   build_any_span,          build_short_span,
                                  at_one,           batch_of, build_partials_any_span, partials_at_one,
                                  partials_batch_of};
}  // namespace polhode::theta
