#pragma once

#include <algorithm>
#include <cmath>

#include "rivals/state.hpp"

namespace polhode::rivals {

/// Taylor's method of high order with the step of Jorba & Zou, Exp. Math. 14, 99 (2005): order 1 - ln(tolerance) / 2,
/// steps of the radius of convergence over e^2. The equations are quadratic, so the coefficients follow by Cauchy
/// products.
///
/// The turning about the momentum at the rate x_2 |m| commutes with the rest and is left out here (the state holds the
/// attitude without it; `with_common_turn` puts it back): steps are as long as the nutation allows, and for a
/// near-sphere that is very long. Keeps everything to the tolerance only.
template <class Real>
class Taylor {
 public:
  static constexpr int max_order = 64;

  Taylor(const InverseMoments<Real>& body, double tolerance)
      : y1_(body.x[0] - body.x[1]),
        y3_(body.x[2] - body.x[1]),
        order_(std::clamp(static_cast<int>(std::ceil(1.0 - 0.5 * std::log(tolerance))), 4, max_order)) {}

  int order() const { return order_; }

  /// The series about `start`; returns the length of a step, infinite for a constant state.
  double expand(const ScaledState<Real>& start) {
    rate_ = fastest_rate(start);
    if (rate_ == 0.0) rate_ = 1.0;
    const Real half = Real(1) / Real(2), y1 = y1_ / Real(rate_), y3 = y3_ / Real(rate_);
    for (int i = 0; i < 4; ++i) q_[0].v[i] = start.q[i];
    for (int i = 0; i < 3; ++i) m_[0].v[i] = start.m[i];
    for (int n = 0; n < order_; ++n) {
      Four a{}, b{}, c{};  // sums of q m1, q m3, and (m2 m3, m3 m1, m1 m2)
      for (int k = 0; k <= n; ++k) {
        const Four& q = q_[k];
        const Four& m = m_[k];
        const Four& p = m_[n - k];
        for (int i = 0; i < 4; ++i) a.v[i] += q.v[i] * p.v[0];
        for (int i = 0; i < 4; ++i) b.v[i] += q.v[i] * p.v[2];
        c.v[0] += m.v[1] * p.v[2];
        c.v[1] += m.v[2] * p.v[0];
        c.v[2] += m.v[0] * p.v[1];
      }
      const Real f = Real(1) / Real(n + 1);
      const Real f1 = f * half * y1, f3 = f * half * y3;
      q_[n + 1].v[0] = -(f1 * a.v[1] + f3 * b.v[3]);
      q_[n + 1].v[1] = f1 * a.v[0] + f3 * b.v[2];
      q_[n + 1].v[2] = f1 * a.v[3] - f3 * b.v[1];
      q_[n + 1].v[3] = f3 * b.v[0] - f1 * a.v[2];
      m_[n + 1].v[0] = f * y3 * c.v[0];
      m_[n + 1].v[1] = f * (y1 - y3) * c.v[1];
      m_[n + 1].v[2] = -f * y1 * c.v[2];
    }
    evaluations += order_;
    const double radius = std::min(radius_of(order_ - 1), radius_of(order_));
    return radius * std::exp(-2.0 - 0.7 / (order_ - 1)) / rate_;
  }

  /// The state `t` after the start of the series.
  ScaledState<Real> at(Real t) const {
    t *= Real(rate_);
    Four q = q_[order_], m = m_[order_];
    for (int n = order_ - 1; n >= 0; --n) {
      for (int i = 0; i < 4; ++i) q.v[i] = q.v[i] * t + q_[n].v[i];
      for (int i = 0; i < 3; ++i) m.v[i] = m.v[i] * t + m_[n].v[i];
    }
    return {{q.v[0], q.v[1], q.v[2], q.v[3]}, {m.v[0], m.v[1], m.v[2]}};
  }

  /// The momentum alone (v[i]) and its rate (second), for finding events.
  Real momentum_at(int i, Real t, Real& rate) const {
    t *= Real(rate_);
    Real value = m_[order_].v[i];
    rate = Real(0);
    for (int n = order_ - 1; n >= 0; --n) {
      rate = rate * t + value;
      value = value * t + m_[n].v[i];
    }
    rate *= Real(rate_);
    return value;
  }

  std::int64_t evaluations = 0;  ///< coefficients of the series, each the work of one derivative

 private:
  struct Four {
    Real v[4];
  };

  /// A bound of the rates at which momentum and attitude change: the series' unit of time, without which the
  /// coefficients of a near-sphere, or of a nutation of 1e-160, would underflow.
  double fastest_rate(const ScaledState<Real>& s) const {
    const double y1 = magnitude(y1_), y3 = magnitude(y3_), y13 = std::sqrt(y1 + y3);
    const double least = std::sqrt(y1), greatest = std::sqrt(y3);
    return std::max(
        {magnitude(s.m[0]) * least * y13, magnitude(s.m[1]) * least * greatest, magnitude(s.m[2]) * greatest * y13});
  }

  /// Root test on coefficient n of every component, each against its own size, so that a component of 1e-160 keeps its
  /// digits as well.
  double radius_of(int n) const {
    double ratio = 0.0;
    const auto test = [&](const Real& c0, const Real& c1, const Real& c2, const Real& cn) {
      const double size = std::max({magnitude(c0), magnitude(c1), magnitude(c2)});
      if (size > 0.0) ratio = std::max(ratio, magnitude(cn) / size);
    };
    for (int i = 0; i < 4; ++i) test(q_[0].v[i], q_[1].v[i], q_[2].v[i], q_[n].v[i]);
    for (int i = 0; i < 3; ++i) test(m_[0].v[i], m_[1].v[i], m_[2].v[i], m_[n].v[i]);
    return ratio == 0.0 ? HUGE_VAL : std::exp(-std::log(ratio) / n);
  }

  static double magnitude(const Real& a) { return std::abs(static_cast<double>(a)); }

  Real y1_, y3_;  // x_1 - x_2, x_3 - x_2
  double rate_ = 1.0;
  int order_;
  Four q_[max_order + 1];
  Four m_[max_order + 1] = {};
};

/// The attitude with the turn about the momentum that Taylor leaves out: by x_2 |m| t, the momentum of length 1.
template <class Real>
inline ScaledState<Real> with_common_turn(ScaledState<Real> y, Real angle) {
  const auto [s, c] = sine_cosine(angle / Real(2));
  multiply_quaternion(y.q, c, s * y.m[0], s * y.m[1], s * y.m[2]);
  return y;
}

}  // namespace polhode::rivals
