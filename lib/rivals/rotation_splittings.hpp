#pragma once

#include <array>
#include <cstddef>

#include "rivals/state.hpp"

namespace polhode::rivals {

/// The three-rotation splitting: H = sum x_i m_i^2 / 2 as three turns about the principal axes, composed
/// symmetrically: A(h/2) B(h/2) C(h) B(h/2) A(h/2), neighbouring halves of A merged between outputs.
/// McLachlan, Phys. Rev. Lett. 71, 3043 (1993); Touma & Wisdom, AJ 107, 1189 (1994); Reich, Physica D 76, 375 (1994).
/// Order 2. Keeps |m| and the inertial momentum; energy without drift.
template <class Real>
class ThreeRotations {
 public:
  static constexpr int order = 2;

  ThreeRotations(const InverseMoments<Real>& body, const ScaledState<Real>&, Real step) {
    for (int i = 0; i < 3; ++i) half_[i] = body.x[i] * step / Real(2);
  }

  void advance(ScaledState<Real>& y, std::int64_t steps) {
    if (steps <= 0) return;
    const Real a = half_[0] / Real(2), b = half_[1] / Real(2);
    turn_about_axis<0>(y, a * y.m[0]);
    for (std::int64_t n = 1;; ++n) {
      turn_about_axis<1>(y, b * y.m[1]);
      turn_about_axis<2>(y, half_[2] * y.m[2]);
      turn_about_axis<1>(y, b * y.m[1]);
      if (n == steps) break;
      turn_about_axis<0>(y, half_[0] * y.m[0]);
    }
    turn_about_axis<0>(y, a * y.m[0]);
    evaluations += 4 * steps + 1;
  }

  std::int64_t evaluations = 0;  ///< turns about an axis

 private:
  Real half_[3];
};

/// Coefficients of a symmetric splitting A(a_0 h) B(b_0 h) A(a_1 h) ... B(b_{n-1} h) A(a_n h).
template <std::size_t Stages>
struct SplittingCoefficients {
  std::array<double, Stages + 1> a;
  std::array<double, Stages> b;
};

/// The splitting of the composition of leapfrogs with steps gamma_i h.
template <std::size_t Stages>
constexpr SplittingCoefficients<Stages> composed(const std::array<double, Stages>& gamma) {
  SplittingCoefficients<Stages> c{};
  for (std::size_t i = 0; i < Stages; ++i) {
    c.a[i] += gamma[i] / 2;
    c.a[i + 1] += gamma[i] / 2;
    c.b[i] = gamma[i];
  }
  return c;
}

/// Order 4, 6 stages, and order 6, 10 stages: S6 and S10 of Blanes & Moan, J. Comput. Appl. Math. 142, 313 (2002),
/// Table 2 and 3.
constexpr SplittingCoefficients<6> blanes_moan_4() {
  constexpr double a1 = 0.0792036964311957, a2 = 0.353172906049774, a3 = -0.0420650803577195;
  constexpr double b1 = 0.209515106613362, b2 = -0.143851773179818, b3 = 0.5 - (b1 + b2);
  return {{a1, a2, a3, 1 - 2 * (a1 + a2 + a3), a3, a2, a1}, {b1, b2, b3, b3, b2, b1}};
}
constexpr SplittingCoefficients<10> blanes_moan_6() {
  constexpr double a1 = 0.0502627644003922, a2 = 0.413514300428344, a3 = 0.0450798897943977;
  constexpr double a4 = -0.188054853819569, a5 = 0.541960678450780, a6 = 1 - 2 * (a1 + a2 + a3 + a4 + a5);
  constexpr double b1 = 0.148816447901042, b2 = -0.132385865767784, b3 = 0.067307604692185, b4 = 0.432666402578175;
  constexpr double b5 = 0.5 - (b1 + b2 + b3 + b4);
  return {{a1, a2, a3, a4, a5, a6, a5, a4, a3, a2, a1}, {b1, b2, b3, b4, b5, b5, b4, b3, b2, b1}};
}
/// Order 8, 17 leapfrogs: Kahan & Li, Math. Comp. 66, 1089 (1997); Hairer, Lubich & Wanner, Geometric Numerical
/// Integration (2006), V.3.2.
constexpr SplittingCoefficients<17> kahan_li_8() {
  constexpr double g1 = 0.13020248308889008088, g2 = 0.56116298177510838456, g3 = -0.38947496264484728641;
  constexpr double g4 = 0.15884190655515560090, g5 = -0.39590389413323757734, g6 = 0.18453964097831570709;
  constexpr double g7 = 0.25837438768632204729, g8 = 0.29501172360931029887, g9 = -0.60550853383003451170;
  return composed<17>({g1, g2, g3, g4, g5, g6, g7, g8, g9, g8, g7, g6, g5, g4, g3, g2, g1});
}
constexpr SplittingCoefficients<1> leapfrog() { return composed<1>({1.0}); }

/// The symmetric-top-and-rotation splitting. The top with moments (I1, I2, I2) turns about a body axis and about the
/// momentum; the latter, the flow of x_2 |m|^2 / 2, commutes with everything and is carried out exactly at the output.
/// What remains are turns about the axes of the least and the greatest moment with strengths x_1 - x_2 and x_3 - x_2:
/// the middle axis is the choice whose error constant is least, and both vanish for a sphere.
/// Fasso, J. Comput. Phys. 189, 527 (2003). Keeps |m| and the inertial momentum; energy without drift; exact for every
/// symmetric top.
template <class Real, int Order>
class TopAndRotation {
 public:
  static constexpr int order = Order;
  static constexpr auto coefficients = [] {
    if constexpr (Order == 2) return leapfrog();
    if constexpr (Order == 4) return blanes_moan_4();
    if constexpr (Order == 6) return blanes_moan_6();
    if constexpr (Order == 8) return kahan_li_8();
  }();
  static constexpr std::size_t stages = coefficients.b.size();

  TopAndRotation(const InverseMoments<Real>& body, const ScaledState<Real>& start, Real step) : step_(step) {
    const Real half = step / Real(2);
    const Real least = (body.x[0] - body.x[1]) * half, greatest = (body.x[2] - body.x[1]) * half;
    // The stronger turn goes outside, where leapfrog's error constant is half as large.
    least_outside_ = least * least > greatest * greatest;
    for (std::size_t i = 0; i < stages; ++i) {
      outer_[i] = Real(coefficients.a[i]) * (least_outside_ ? least : greatest);
      inner_[i] = Real(coefficients.b[i]) * (least_outside_ ? greatest : least);
    }
    const Real square = start.m[0] * start.m[0] + start.m[1] * start.m[1] + start.m[2] * start.m[2];
    momentum_ = square_root(square);
    common_half_rate_ = body.x[1] * momentum_ / Real(2);
  }

  void advance(ScaledState<Real>& y, std::int64_t steps) {
    if (steps <= 0) return;
    if (least_outside_) {
      advance_axes<0, 2>(y, steps);
    } else {
      advance_axes<2, 0>(y, steps);
    }
    // exp(x_2 m t): turning about the momentum, from the body's side.
    const auto [s, c] = sine_cosine(common_half_rate_ * step_ * Real(static_cast<double>(steps)));
    const Real f = s / momentum_;
    multiply_quaternion(y.q, c, f * y.m[0], f * y.m[1], f * y.m[2]);
    evaluations += static_cast<std::int64_t>(2 * stages) * steps + 2;
  }

  std::int64_t evaluations = 0;  ///< turns about an axis

 private:
  template <int Outer, int Inner>
  void advance_axes(ScaledState<Real>& y, std::int64_t steps) const {
    const Real joined = outer_[0] + outer_[0];
    turn_about_axis<Outer>(y, outer_[0] * y.m[Outer]);
    for (std::int64_t n = 1;; ++n) {
      for (std::size_t i = 0; i < stages; ++i) {
        turn_about_axis<Inner>(y, inner_[i] * y.m[Inner]);
        if (i + 1 < stages) turn_about_axis<Outer>(y, outer_[i + 1] * y.m[Outer]);
      }
      if (n == steps) break;
      turn_about_axis<Outer>(y, joined * y.m[Outer]);
    }
    turn_about_axis<Outer>(y, outer_[0] * y.m[Outer]);
  }

  Real step_;
  Real momentum_;
  Real common_half_rate_;
  std::array<Real, stages> outer_;
  std::array<Real, stages> inner_;
  bool least_outside_;
};

}  // namespace polhode::rivals
