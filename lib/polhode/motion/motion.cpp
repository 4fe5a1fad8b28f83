#include "polhode/motion/motion.hpp"

namespace polhode {

void FreeMotion::batch(const TimeArrays& times, const StateArrays& out) const {
  for (std::size_t i = 0; i < times.high.size(); ++i) {
    const FreeState s = at(times.high[i], times.low.empty() ? 0.0 : times.low[i]);
    const Eigen::Vector4d q = scalar_first(s.q_inertial_from_body);
    const auto row = static_cast<std::ptrdiff_t>(i);
    for (int k = 0; k < 4; ++k) out.q[k][row * out.q_stride] = q[k];
    if (out.m[0] != nullptr) {
      for (int k = 0; k < 3; ++k) out.m[k][row * out.m_stride] = s.momentum_body[k];
    }
  }
}

}  // namespace polhode
