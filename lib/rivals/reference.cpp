#include "rivals/reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "polhode/base/error.hpp"

namespace polhode::rivals {

namespace {

double as_double(Quadruple a) { return static_cast<double>(a); }

/// Euclidean length; powers of two bring the squares into the range of a double's square root.
Quadruple length(const Quadruple* v, int n) {
  double largest = 0.0;
  for (int i = 0; i < n; ++i) largest = std::max(largest, std::abs(as_double(v[i])));
  if (largest == 0.0) return Quadruple(0);
  const Quadruple scale = std::ldexp(1.0, std::clamp(std::ilogb(largest), -1000, 1000));
  Quadruple sum = 0;
  for (int i = 0; i < n; ++i) sum += (v[i] / scale) * (v[i] / scale);
  return scale * square_root(sum);
}

void multiply(const Quadruple a[4], const Quadruple b[4], Quadruple out[4]) {
  Quadruple c[4] = {a[0], a[1], a[2], a[3]};
  multiply_quaternion(c, b[0], b[1], b[2], b[3]);
  std::copy_n(c, 4, out);
}

bool is_negative(Quadruple a) { return a < Quadruple(0); }

/// Where m2 passes 0 within a step: Newton's method, kept in its bracket by bisection.
Quadruple zero_of_m2(const Taylor<Quadruple>& series, Quadruple step) {
  Quadruple rate;
  const bool negative_first = is_negative(series.momentum_at(1, Quadruple(0), rate));
  Quadruple low = 0, high = step, root = step / Quadruple(2);
  for (int i = 0; i < 200; ++i) {
    const Quadruple value = series.momentum_at(1, root, rate);
    (is_negative(value) == negative_first ? low : high) = root;
    Quadruple better = root - value / rate;
    if (!((better > low && better < high) || (better < low && better > high))) better = (low + high) / Quadruple(2);
    const double change = std::abs(as_double((better - root) / step));
    root = better;
    if (!(change > quadruple_epsilon)) break;
  }
  return root;
}

/// a^n for a unit quaternion.
void power(const Quadruple a[4], double n, Quadruple out[4]) {
  Quadruple base[4] = {a[0], a[1], a[2], a[3]};
  if (n < 0.0) {
    for (int i = 1; i < 4; ++i) base[i] = -base[i];
    n = -n;
  }
  Quadruple result[4] = {1, 0, 0, 0};
  while (n >= 1.0) {
    if (std::fmod(n, 2.0) == 1.0) multiply(result, base, result);
    multiply(base, base, base);
    n = std::floor(n / 2.0);
  }
  std::copy_n(result, 4, out);
}

}  // namespace

QuadrupleBody in_quadruple(const FreeBody& body) {
  QuadrupleBody e;
  const Eigen::Vector4d q = scalar_first(body.q_inertial_from_body);
  for (int i = 0; i < 3; ++i) e.moments[i] = body.principal_moments[i];
  for (int i = 0; i < 4; ++i) e.q[i] = q[i];
  for (int i = 0; i < 3; ++i) e.m[i] = body.momentum_body[i];
  return e;
}

QuadrupleReference::QuadrupleReference(const QuadrupleBody& body, double t_min_s, double t_max_s, double tolerance) {
  check_span(t_min_s, t_max_s);
  if (!(tolerance > 0.0)) throw InputError(fmt::format("the tolerance is {}, a positive one is wanted", tolerance));
  const auto vector = [](const Quadruple* v) { return Vector3(as_double(v[0]), as_double(v[1]), as_double(v[2])); };
  checked({vector(body.moments),
           {as_double(body.q[0]), as_double(body.q[1]), as_double(body.q[2]), as_double(body.q[3])},
           vector(body.m)});
  const Quadruple q_length = length(body.q, 4), momentum = length(body.m, 3);
  ScaledState<Quadruple> y;
  for (int i = 0; i < 4; ++i) y.q[i] = body.q[i] / q_length;
  const bool at_rest = momentum == Quadruple(0);
  InverseMoments<Quadruple> x;
  for (int i = 0; i < 3; ++i) {
    y.m[i] = at_rest ? Quadruple(0) : body.m[i] / momentum;
    x.x[i] = body.moments[1] / body.moments[i];
    rotation_[i] = x.x[i] * y.m[i];
  }
  start_ = y;
  time_unit_ = at_rest ? Quadruple(1) : body.moments[1] / momentum;
  constant_momentum_ = y.m[1] * y.m[2] * (body.moments[1] - body.moments[2]) == Quadruple(0) &&
                       y.m[2] * y.m[0] * (body.moments[2] - body.moments[0]) == Quadruple(0) &&
                       y.m[0] * y.m[1] * (body.moments[0] - body.moments[1]) == Quadruple(0);
  if (constant_momentum_) return;

  // Both ways to the nearest zero of m2, or to the end of the span. From a start beside the middle axis both ways lead
  // away from it, so that a component of 1e-160 keeps its digits; on the way back to the axis they would be lost.
  const Quadruple least = y.m[0] * y.m[0] * (x.x[0] - x.x[1]), greatest = y.m[2] * y.m[2] * (x.x[1] - x.x[2]);
  const Quadruple excess = least - greatest;  // 2 T - |m|^2 / I2
  const bool on_separatrix = !((excess < Quadruple(0) ? -excess : excess) > Quadruple(1e-30) * (least + greatest));
  Taylor<Quadruple> series(x, tolerance);
  const Quadruple t_min = Quadruple(t_min_s) / time_unit_, t_max = Quadruple(t_max_s) / time_unit_;
  const Quadruple reach = t_max > -t_min ? t_max : -t_min;
  // On the separatrix itself the momentum never returns: the answer ends where rounding has grown to a turn.
  constexpr std::size_t most_segments = 500;
  const double longest_step = 1.0 + 2.0 * as_double(reach);  // a series may converge for ever
  bool ends = false, begins = false;
  for (Quadruple t = 0; !ends && t <= (on_separatrix ? t_max : reach) && segments_.size() < most_segments;) {
    const Quadruple step = std::min(series.expand(y), longest_step);
    segments_.push_back({t, series});
    const ScaledState<Quadruple> next = series.at(step);
    if (!on_separatrix && is_negative(y.m[1]) != is_negative(next.m[1])) {
      ends = true;
      end_ = t + zero_of_m2(series, step);
    }
    t += step;
    y = next;
    covered_to_ = t;
  }
  y = start_;
  std::vector<Segment> past;
  for (Quadruple t = 0; !begins && t >= (on_separatrix ? t_min : -reach) && past.size() < most_segments;) {
    const Quadruple step = std::min(series.expand(y), longest_step);
    const ScaledState<Quadruple> next = series.at(-step);
    if (!on_separatrix && is_negative(y.m[1]) != is_negative(next.m[1])) {
      begins = true;
      begin_ = t + zero_of_m2(series, -step);
    }
    t -= step;
    y = next;
    Taylor<Quadruple> from_there = series;
    from_there.expand(y);
    past.push_back({t, from_there});
    covered_from_ = t;
  }
  segments_.insert(segments_.begin(), past.rbegin(), past.rend());
  periodic_ = begins && ends;
  if (!periodic_) return;
  // Half a period later the body is turned by pi about the axis whose component kept its sign, and by a fixed turn in
  // inertial axes: q(t + half) = turn q(t) flip.
  axis_ = is_negative(excess) ? 3 : 1;
  const ScaledState<Quadruple> first = without_common_turn(begin_), last = without_common_turn(end_);
  Quadruple back[4] = {first.q[0], -first.q[1], -first.q[2], -first.q[3]};
  Quadruple unflip[4] = {0, 0, 0, 0};
  unflip[axis_] = -1;
  multiply(last.q, unflip, turn_);
  multiply(turn_, back, turn_);
  const Quadruple norm = length(turn_, 4);
  for (Quadruple& a : turn_) a /= norm;
}

ScaledState<Quadruple> QuadrupleReference::without_common_turn(Quadruple tau) const {
  auto after = std::upper_bound(segments_.begin(), segments_.end(), tau,
                                [](const Quadruple& t, const Segment& s) { return t < s.start; });
  if (after == segments_.begin()) ++after;
  const Segment& segment = *std::prev(after);
  return segment.series.at(tau - segment.start);
}

ScaledState<Quadruple> QuadrupleReference::at(double t_s) const {
  const Quadruple tau = Quadruple(t_s) / time_unit_;
  ScaledState<Quadruple> y = start_;
  if (constant_momentum_) {
    const Quadruple rate = length(rotation_, 3);
    if (rate == Quadruple(0)) return y;
    const auto [s, c] = sine_cosine(rate * tau / Quadruple(2));
    const Quadruple f = s / rate;
    multiply_quaternion(y.q, c, f * rotation_[0], f * rotation_[1], f * rotation_[2]);
    return y;
  }
  if (periodic_ && (tau > end_ || tau < begin_)) {
    const Quadruple half = end_ - begin_;
    const double n = std::floor(as_double((tau - begin_) / half));
    y = without_common_turn(tau - Quadruple(n) * half);
    Quadruple turns[4], flips[4], flip[4] = {0, 0, 0, 0};
    flip[axis_] = 1;
    power(turn_, n, turns);
    power(flip, std::fmod(n, 4.0), flips);
    multiply(turns, y.q, y.q);
    multiply(y.q, flips, y.q);
    if (std::fmod(n, 2.0) != 0.0) {
      for (int i = 0; i < 3; ++i) {
        if (i + 1 != axis_) y.m[i] = -y.m[i];
      }
    }
  } else if (tau >= covered_from_ && tau <= covered_to_) {
    y = without_common_turn(tau);
  } else {
    for (Quadruple& a : y.q) a = Quadruple(std::nan(""));
    for (Quadruple& a : y.m) a = Quadruple(std::nan(""));
    return y;
  }
  return with_common_turn(y, tau);
}

std::vector<double> condition_numbers(const FreeBody& body, const std::vector<double>& times_s) {
  constexpr double relative = 0x1p-60, tolerance = 1e-26;
  if (times_s.empty()) return {};
  const auto [first, last] = std::minmax_element(times_s.begin(), times_s.end());
  const double t_min = std::min(0.0, *first), t_max = std::max(0.0, *last);
  const QuadrupleBody exact = in_quadruple(body);
  const QuadrupleReference plain(exact, t_min, t_max, tolerance);
  std::vector<double> sum(times_s.size(), 0.0);
  for (int input = 0; input < 10; ++input) {
    QuadrupleBody changed = exact;
    Quadruple& value = input < 3 ? changed.moments[input] : input < 7 ? changed.q[input - 3] : changed.m[input - 7];
    if (value == Quadruple(0)) continue;
    value += value * Quadruple(relative);
    const QuadrupleReference other(changed, t_min, t_max, tolerance);
    for (std::size_t i = 0; i < times_s.size(); ++i) {
      const ScaledState<Quadruple> a = plain.at(times_s[i]), b = other.at(times_s[i]);
      const Quadruple back[4] = {a.q[0], -a.q[1], -a.q[2], -a.q[3]};
      Quadruple difference[4];
      multiply(back, b.q, difference);
      double turn = 0.0, change = 0.0;
      for (int k = 0; k < 3; ++k) {
        turn = std::hypot(turn, 2.0 * as_double(difference[k + 1]) / relative);
        change = std::hypot(change, as_double(b.m[k] - a.m[k]) / relative);
      }
      sum[i] += turn + change;
    }
  }
  return sum;
}

}  // namespace polhode::rivals
