#pragma once

#include <cmath>
#include <cstdint>

namespace polhode::rivals {

/// Solves the 3 x 3 system J d = r by Cramer's rule.
template <class Real>
inline void solve_3x3(const Real j[3][3], const Real r[3], Real d[3]) {
  const Real c00 = j[1][1] * j[2][2] - j[1][2] * j[2][1];
  const Real c01 = j[1][2] * j[2][0] - j[1][0] * j[2][2];
  const Real c02 = j[1][0] * j[2][1] - j[1][1] * j[2][0];
  const Real inverse = Real(1) / (j[0][0] * c00 + j[0][1] * c01 + j[0][2] * c02);
  const Real c10 = j[0][2] * j[2][1] - j[0][1] * j[2][2];
  const Real c11 = j[0][0] * j[2][2] - j[0][2] * j[2][0];
  const Real c12 = j[0][1] * j[2][0] - j[0][0] * j[2][1];
  const Real c20 = j[0][1] * j[1][2] - j[0][2] * j[1][1];
  const Real c21 = j[0][2] * j[1][0] - j[0][0] * j[1][2];
  const Real c22 = j[0][0] * j[1][1] - j[0][1] * j[1][0];
  d[0] = (c00 * r[0] + c10 * r[1] + c20 * r[2]) * inverse;
  d[1] = (c01 * r[0] + c11 * r[1] + c21 * r[2]) * inverse;
  d[2] = (c02 * r[0] + c12 * r[1] + c22 * r[2]) * inverse;
}

/// The unknown of an implicit step, solved by Newton's method from the parabola through the last three solutions.
template <class Real>
class ExtrapolatedNewton {
 public:
  /// `equation(u, residual, jacobian)`; the first call of a run starts from `fallback`. Returns false without
  /// convergence.
  template <class Equation>
  bool solve(const Equation& equation, const Real fallback[3], Real u[3]) {
    for (int i = 0; i < 3; ++i) {
      u[i] = known_ >= 3 ? Real(3) * (last_[0][i] - last_[1][i]) + last_[2][i] : known_ > 0 ? last_[0][i] : fallback[i];
    }
    bool converged = false;
    for (int iteration = 0; iteration < max_iterations && !converged; ++iteration) {
      Real residual[3], jacobian[3][3], d[3];
      equation(u, residual, jacobian);
      ++evaluations;
      solve_3x3(jacobian, residual, d);
      Real change = 0, size = 0;
      for (int i = 0; i < 3; ++i) {
        u[i] -= d[i];
        change += d[i] * d[i];
        size += u[i] * u[i];
      }
      // Convergence is quadratic: what remains is of the order of the square of this change.
      if (!(change <= size)) return false;
      converged = change * change <= tolerance_ * size * size;
    }
    for (int i = 0; i < 3; ++i) {
      last_[2][i] = last_[1][i];
      last_[1][i] = last_[0][i];
      last_[0][i] = u[i];
    }
    if (known_ < 3) ++known_;
    return converged;
  }

  std::int64_t evaluations = 0;

 private:
  static constexpr int max_iterations = 30;
  static constexpr double epsilon = sizeof(Real) > 8 ? 0x1p-112 : 0x1p-52;
  Real tolerance_ = Real(epsilon) * Real(epsilon) * Real(16);
  int known_ = 0;
  Real last_[3][3] = {};
};

}  // namespace polhode::rivals
