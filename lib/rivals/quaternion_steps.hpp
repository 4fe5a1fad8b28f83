#pragma once

#include "rivals/right_hand_side.hpp"

namespace polhode::rivals {

/// The classical Runge-Kutta method on the seven numbers (q, m); `Renormalise` divides q by its length after each step.
/// Kutta, Z. Math. Phys. 46, 435 (1901). Order 4. Keeps nothing (with Renormalise: |q|).
template <class Real, bool Renormalise>
class ClassicalRungeKutta4 {
 public:
  static constexpr int order = 4;

  ClassicalRungeKutta4(const InverseMoments<Real>& body, const ScaledState<Real>&, Real step)
      : f_{{body.x[0] * step, body.x[1] * step, body.x[2] * step}} {}

  void advance(ScaledState<Real>& s, std::int64_t steps) {
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

/// The classical Runge-Kutta method under torques: four evaluations a step.
class ForcedRungeKutta4 {
 public:
  ForcedRungeKutta4(const Problem& problem, double start, const ScaledState<double>&, double step)
      : f_{{{problem.body.x[0], problem.body.x[1], problem.body.x[2]}}, *problem.forcing}, start_(start), h_(step) {}

  void advance(ScaledState<double>& s, std::int64_t steps) {
    std::array<double, 7> y = pack(s), k1, k2, k3, k4, u;
    for (std::int64_t n = 0; n < steps; ++n) {
      const double t = start_ + static_cast<double>(taken_++) * h_;
      f_(y, k1, t);
      for (std::size_t i = 0; i < 7; ++i) u[i] = y[i] + 0.5 * h_ * k1[i];
      f_(u, k2, t + 0.5 * h_);
      for (std::size_t i = 0; i < 7; ++i) u[i] = y[i] + 0.5 * h_ * k2[i];
      f_(u, k3, t + 0.5 * h_);
      for (std::size_t i = 0; i < 7; ++i) u[i] = y[i] + h_ * k3[i];
      f_(u, k4, t + h_);
      for (std::size_t i = 0; i < 7; ++i) y[i] += h_ / 6.0 * ((k1[i] + k4[i]) + 2.0 * (k2[i] + k3[i]));
    }
    s = unpack(y);
    evaluations += 4 * steps;
  }

  std::int64_t evaluations = 0;

 private:
  ForcedRightHandSide f_;
  double start_, h_;
  std::int64_t taken_ = 0;  // steps
};

/// What many simulators still do: q += h q omega / 2, divided by its length, and m += h m x omega. Order 1. Keeps |q|;
/// momentum and energy grow exponentially.
template <class Real>
class FirstOrderQuaternion {
 public:
  static constexpr int order = 1;

  FirstOrderQuaternion(const InverseMoments<Real>& body, const ScaledState<Real>&, Real step)
      : f_{{body.x[0] * step, body.x[1] * step, body.x[2] * step}} {}

  void advance(ScaledState<Real>& s, std::int64_t steps) {
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
