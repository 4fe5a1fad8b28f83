#include "polhode/motion/motion.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/body/inertia.hpp"

namespace polhode {

const FreeBody& checked(const FreeBody& body) {
  check_principal_moments(body.principal_moments);
  const Quaternion& q = body.q_inertial_from_body;
  if (!q.coeffs().allFinite() || q.coeffs().isZero(0.0)) {
    throw InputError(fmt::format("the attitude is {}, {}, {}, {}; a finite quaternion other than 0 is wanted", q.w(),
                                 q.x(), q.y(), q.z()));
  }
  check_angular_momentum(body.momentum_body);
  return body;
}

State nan_state() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  return {Quaternion(nan, nan, nan, nan), Vector3::Constant(nan)};
}

void check_span(double first_s, double last_s) {
  if (!(first_s <= 0.0 && last_s >= 0.0 && std::isfinite(last_s - first_s))) {
    throw InputError(fmt::format("the span is {} s to {} s, a finite one that holds 0 is wanted", first_s, last_s));
  }
}

void check_within(double t_s, double first_s, double last_s) {
  const double room_s = end_room_s(last_s - first_s);
  if (!(t_s >= first_s - room_s && t_s <= last_s + room_s)) {
    throw InputError(
        fmt::format("the motion was propagated from {} s to {} s, it was asked for at {} s", first_s, last_s, t_s));
  }
}

void check_lengths(const TimeArrays& times) {
  if (!times.low.empty() && times.low.size() != times.high.size()) {
    throw InputError(
        fmt::format("{} times have {} low parts; as many are wanted, or none", times.high.size(), times.low.size()));
  }
}

TimeArrays part_of(const TimeArrays& times, std::size_t begin, std::size_t end) {
  return {times.high.subspan(begin, end - begin),
          times.low.empty() ? times.low : times.low.subspan(begin, end - begin)};
}

StateArrays part_of(const StateArrays& out, std::size_t begin) {
  const auto row = static_cast<std::ptrdiff_t>(begin);
  StateArrays part = out;
  for (double*& q : part.q) q += row * out.q_stride;
  for (double*& m : part.m) m = m == nullptr ? nullptr : m + row * out.m_stride;
  return part;
}

void Motion::batch(const TimeArrays& times, const StateArrays& out) const {
  check_lengths(times);
  for (std::size_t i = 0; i < times.high.size(); ++i) {
    out.put(i, at(times.high[i], times.low.empty() ? 0.0 : times.low[i]));
  }
}

void batch_threads(const Motion& motion, const TimeArrays& times, const StateArrays& out, unsigned thread_count) {
  check_lengths(times);
  constexpr std::size_t kGrain = 512;  // batches work in blocks of a divisor of this
  parallel_chunks(times.high.size(), kGrain, thread_count, [&](std::size_t begin, std::size_t end) {
    motion.batch(part_of(times, begin, end), part_of(out, begin));
  });
}

}  // namespace polhode
