#pragma once

#include <limits>

#include "rivals/newton.hpp"
#include "rivals/state.hpp"

namespace polhode::rivals {

/// The implicit midpoint rule for Euler's equations, m' = m + h (u x omega(u)), u = (m + m') / 2, and the attitude that
/// belongs to it: m' is m seen from a body turned by the Cayley transform of h omega(u), so the attitude turns by the
/// same. Austin, Krishnaprasad & Wang, J. Comput. Phys. 107, 105 (1993). Order 2. Keeps |m|, the energy and the
/// inertial momentum.
template <class Real>
class ImplicitMidpoint {
 public:
  static constexpr int order = 2;

  ImplicitMidpoint(const InverseMoments<Real>& body, const ScaledState<Real>&, Real step) {
    for (int i = 0; i < 3; ++i) {
      half_rate_[i] = body.x[i] * step / Real(2);
      coupling_[i] = (body.x[(i + 2) % 3] - body.x[(i + 1) % 3]) * step / Real(2);
    }
  }

  void advance(ScaledState<Real>& y, std::int64_t steps) {
    const std::int64_t before = newton_.evaluations;
    for (std::int64_t n = 0; n < steps; ++n) {
      Real u[3];
      const bool solved = newton_.solve(
          [&](const Real v[3], Real residual[3], Real jacobian[3][3]) {
            for (int i = 0; i < 3; ++i) {
              const int j = (i + 1) % 3, k = (i + 2) % 3;
              residual[i] = v[i] - y.m[i] - coupling_[i] * v[j] * v[k];
              jacobian[i][i] = Real(1);
              jacobian[i][j] = -coupling_[i] * v[k];
              jacobian[i][k] = -coupling_[i] * v[j];
            }
          },
          y.m, u);
      if (!solved) {
        y.m[0] = Real(std::numeric_limits<double>::quiet_NaN());
        y.q[0] = y.m[0];
        break;
      }
      const Real g[3] = {half_rate_[0] * u[0], half_rate_[1] * u[1], half_rate_[2] * u[2]};
      turn_by_cayley(y, g);
    }
    evaluations += newton_.evaluations - before;
  }

  std::int64_t evaluations = 0;  ///< Newton iterations

 private:
  ExtrapolatedNewton<Real> newton_;
  Real half_rate_[3];
  Real coupling_[3];
};

}  // namespace polhode::rivals
