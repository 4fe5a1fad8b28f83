#include "polhode/motion/motion.hpp"

#include "polhode/base/parallel.hpp"

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

void batch_threads(const FreeMotion& motion, const TimeArrays& times, const StateArrays& out, unsigned thread_count) {
  constexpr std::size_t kGrain = 512;  // batches work in blocks of a divisor of this
  parallel_chunks(times.high.size(), kGrain, thread_count, [&](std::size_t begin, std::size_t end) {
    const TimeArrays part{times.high.subspan(begin, end - begin),
                          times.low.empty() ? times.low : times.low.subspan(begin, end - begin)};
    const auto row = static_cast<std::ptrdiff_t>(begin);
    StateArrays part_out = out;
    for (double*& q : part_out.q) q += row * out.q_stride;
    for (double*& m : part_out.m) m = m == nullptr ? nullptr : m + row * out.m_stride;
    motion.batch(part, part_out);
  });
}

}  // namespace polhode
