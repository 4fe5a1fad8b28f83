#pragma once

#include "polhode/motion/rivals/right_hand_side.hpp"

namespace polhode::rivals {

/// The classical Runge-Kutta method on the seven numbers (q, m); `Renormalise` divides q by its length after each step.
/// Kutta, Z. Math. Phys. 46, 435 (1901). Order 4. Keeps nothing (with Renormalise: |q|).
template <class Real, bool Renormalise>
class ClassicalRungeKutta4 {
 public:
  static constexpr int order = 4;

  ClassicalRungeKutta4(const InverseMoments<Real>& body, const State<Real>&, Real step)
      : f_{{body.x[0] * step, body.x[1] * step, body.x[2] * step}} {}

  void advance(State<Real>& s, std::int64_t steps) {
    const Real half = Real(1) / Real(2), sixth = Real(1) / Real(6);
    Y y = pack(s), k1, k2, k3, k4, u;
    for (std::int64_t n = 0; n < steps; ++n) {
      f_(y, k1);
      for (std::size_t i = 0; i < 7; ++i) u[i] = y[i] + half * k1[i];
      f_(u, k2);
      for (std::size_t i = 0; i < 7; ++i) u[i] = y[i] + half * k2[i];
      f_(u, k3);
      for (std::size_t i = 0; i < 7; ++i) u[i] = y[i] + k3[i];
      f_(u, k4);
      for (std::size_t i = 0; i < 7; ++i) y[i] += sixth * ((k1[i] + k4[i]) + Real(2) * (k2[i] + k3[i]));
      if constexpr (Renormalise) normalise_quaternion(y);
    }
    s = unpack(y);
    evaluations += 4 * steps;
  }

  std::int64_t evaluations = 0;

 private:
  using Y = std::array<Real, 7>;
  RightHandSide<Real> f_;  // times the step
};

/// What many simulators still do: q += h q omega / 2, divided by its length, and m += h m x omega. Order 1. Keeps |q|;
/// momentum and energy grow exponentially.
template <class Real>
class FirstOrderQuaternion {
 public:
  static constexpr int order = 1;

  FirstOrderQuaternion(const InverseMoments<Real>& body, const State<Real>&, Real step)
      : f_{{body.x[0] * step, body.x[1] * step, body.x[2] * step}} {}

  void advance(State<Real>& s, std::int64_t steps) {
    std::array<Real, 7> y = pack(s), k;
    for (std::int64_t n = 0; n < steps; ++n) {
      f_(y, k);
      for (std::size_t i = 0; i < 7; ++i) y[i] += k[i];
      normalise_quaternion(y);
    }
    s = unpack(y);
    evaluations += steps;
  }

  std::int64_t evaluations = 0;

 private:
  RightHandSide<Real> f_;  // times the step
};

}  // namespace polhode::rivals
