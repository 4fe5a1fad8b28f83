#pragma once

#include <array>

#include "polhode/motion/rivals/state.hpp"

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

template <class Real>
inline std::array<Real, 7> pack(const State<Real>& s) {
  return {s.q[0], s.q[1], s.q[2], s.q[3], s.m[0], s.m[1], s.m[2]};
}
template <class Real>
inline State<Real> unpack(const std::array<Real, 7>& y) {
  return {{y[0], y[1], y[2], y[3]}, {y[4], y[5], y[6]}};
}

template <class Real>
inline void normalise_quaternion(std::array<Real, 7>& y) {
  const Real f = Real(1) / square_root(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]);
  for (std::size_t i = 0; i < 4; ++i) y[i] *= f;
}

}  // namespace polhode::rivals
