#pragma once

#include <array>

#include "rivals/integrated_motion.hpp"

namespace polhode::rivals {

/// d/dt (q, m) = (q omega / 2, m x omega), omega_i = x_i m_i: what the general-purpose integrators are given.
template <class Real>
struct RightHandSide {
  Real x[3];

  void operator()(const std::array<Real, 7>& y, std::array<Real, 7>& dydt) const {
    const Real w1 = x[0] * y[4], w2 = x[1] * y[5], w3 = x[2] * y[6];
    const Real half = Real(1) / Real(2);
    dydt[0] = -half * (y[1] * w1 + y[2] * w2 + y[3] * w3);
    dydt[1] = half * (y[0] * w1 + y[2] * w3 - y[3] * w2);
    dydt[2] = half * (y[0] * w2 + y[3] * w1 - y[1] * w3);
    dydt[3] = half * (y[0] * w3 + y[1] * w2 - y[2] * w1);
    dydt[4] = y[5] * w3 - y[6] * w2;
    dydt[5] = y[6] * w1 - y[4] * w3;
    dydt[6] = y[4] * w2 - y[5] * w1;
  }
};

/// The same with torques, at a time in the body's own unit. The torques see q as it is, off its length by no more than
/// the error of the integration.
struct ForcedRightHandSide {
  RightHandSide<double> free;
  const Forcing& forcing;

  void operator()(const std::array<double, 7>& y, std::array<double, 7>& dydt, double t) const {
    free(y, dydt);
    const TorqueTerms<double> terms = forcing.torques.at(forcing.start_s + t * forcing.time_unit_s,
                                                         Quaternion(y[0], y[1], y[2], y[3]), forcing.principal_moments);
    Vector3 change = terms.constant;
    if (terms.depends_on_rate) {
      const Vector3 omega(free.x[0] * y[4], free.x[1] * y[5], free.x[2] * y[6]);
      change -= terms.damping * omega / forcing.time_unit_s;
    }
    change *= forcing.time_unit_s / forcing.momentum;
    if (terms.relaxation != 0.0) {  // m' += k m x (m x omega), q' += q (0, k m x omega) / 2
      const Vector3 turn = terms.relaxation * forcing.momentum * Vector3(dydt[4], dydt[5], dydt[6]);
      change += Vector3(y[4], y[5], y[6]).cross(turn);
      dydt[0] -= 0.5 * (y[1] * turn[0] + y[2] * turn[1] + y[3] * turn[2]);
      dydt[1] += 0.5 * (y[0] * turn[0] + y[2] * turn[2] - y[3] * turn[1]);
      dydt[2] += 0.5 * (y[0] * turn[1] + y[3] * turn[0] - y[1] * turn[2]);
      dydt[3] += 0.5 * (y[0] * turn[2] + y[1] * turn[1] - y[2] * turn[0]);
    }
    for (std::size_t i = 0; i < 3; ++i) dydt[4 + i] += change[static_cast<Eigen::Index>(i)];
  }
};

/// Calls `integrate` with the right-hand side of the problem, f(y, dydt, t).
template <class Integrate>
auto with_right_hand_side(const Problem& problem, const Integrate& integrate) {
  const RightHandSide<double> free{{problem.body.x[0], problem.body.x[1], problem.body.x[2]}};
  if (problem.forcing != nullptr) return integrate(ForcedRightHandSide{free, *problem.forcing});
  return integrate([free](const std::array<double, 7>& y, std::array<double, 7>& dydt, double) { free(y, dydt); });
}

template <class Real>
inline std::array<Real, 7> pack(const ScaledState<Real>& s) {
  return {s.q[0], s.q[1], s.q[2], s.q[3], s.m[0], s.m[1], s.m[2]};
}
template <class Real>
inline ScaledState<Real> unpack(const std::array<Real, 7>& y) {
  return {{y[0], y[1], y[2], y[3]}, {y[4], y[5], y[6]}};
}

template <class Real>
inline void normalise_quaternion(std::array<Real, 7>& y) {
  const Real f = Real(1) / square_root(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]);
  for (std::size_t i = 0; i < 4; ++i) y[i] *= f;
}

}  // namespace polhode::rivals
