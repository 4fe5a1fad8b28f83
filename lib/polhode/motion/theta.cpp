#include "polhode/motion/theta.hpp"

#include <cstdlib>
#include <string_view>

namespace polhode {
namespace theta {

extern const Target k_target_baseline;
#ifdef POLHODE_X86_TARGETS
extern const Target k_target_avx2;
extern const Target k_target_avx512;
#endif

std::size_t targets(const Target* out[3]) {
  std::size_t count = 0;
  out[count++] = &k_target_baseline;
#ifdef POLHODE_X86_TARGETS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) out[count++] = &k_target_avx2;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) out[count++] = &k_target_avx512;
#endif
  return count;
}

}  // namespace theta

theta::Input theta_input(const FreeBody& body) {
  theta::Input in;
  const Eigen::Vector4d q = scalar_first(body.q_inertial_from_body);
  for (int k = 0; k < 3; ++k) {
    in.moments[k] = body.principal_moments[k];
    in.momentum[k] = body.momentum_body[k];
  }
  for (int k = 0; k < 4; ++k) in.q[k] = q[k];
  return in;
}

theta::BatchArguments theta_batch(const TimeArrays& times, const StateArrays& out) {
  return {times.high.data(), times.low.empty() ? nullptr : times.low.data(),
          times.high.size(), {out.q[0], out.q[1], out.q[2], out.q[3]},
          out.q_stride,      {out.m[0], out.m[1], out.m[2]},
          out.m_stride};
}

const theta::Target& ThetaMotion::best_target() {
  static const theta::Target* const best = [] {
    const theta::Target* available[3];
    const std::size_t count = theta::targets(available);
    if (const char* wanted = std::getenv("POLHODE_TARGET")) {
      for (std::size_t i = 0; i < count; ++i) {
        if (std::string_view(wanted) == available[i]->name) return available[i];
      }
    }
    return available[count - 1];
  }();
  return *best;
}

ThetaMotion::ThetaMotion(Unchecked /*unused*/, const FreeBody& body, Span span, const theta::Target& target)
    : target_(&target) {
  (span == Span::any ? target_->build : target_->build_short)(theta_input(body), solution_);
}

State ThetaMotion::at(double t_high_s, double t_low_s) const {
  State state;
  target_->at(solution_, t_high_s, t_low_s, state.q_inertial_from_body.coeffs().data(), state.momentum_body.data());
  return state;
}

void ThetaMotion::batch(const TimeArrays& times, const StateArrays& out) const {
  check_lengths(times);
  target_->batch(solution_, theta_batch(times, out));
}

}  // namespace polhode
