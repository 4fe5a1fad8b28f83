#pragma once

#include <limits>

#include "rivals/newton.hpp"
#include "rivals/state.hpp"

namespace polhode::rivals {

/// The discrete Moser-Veselov map (the RATTLE discretisation on SO(3)), and its preprocessed versions of order 6 and
/// 10. Moser & Veselov, Commun. Math. Phys. 139, 217 (1991); McLachlan & Zanna, Found. Comput. Math. 5, 87 (2005);
/// Hairer & Vilmart, J. Phys. A 39, 13225 (2006).
///
/// One step is the turn Q with Q D - D Q^T = h hat(m), D = diag(I2 + I3 - I1, ...) / 2, then m becomes Q^T m and the
/// attitude R Q. With the Gibbs vector g of Q that is
///
///     I_i g_i + (I_k - I_j) g_j g_k = (h / 2) m_i (1 + |g|^2),      i, j, k cyclic,
///
/// solved here by Newton's method: McLachlan & Zanna's matrix equation has an explicit solution as well, but that gives
/// Q to a rounding of 1 where this gives g to a rounding of g, and it divides by the entries of D, which vanish for
/// flat bodies.
///
/// The map keeps |m|, the inertial momentum and the energy exactly, so it follows the flow of some f(H, C) of the body,
/// C = |m|^2 / 2. Preprocessing replaces 1/I_i by (1/I_i) (1 + S) + d so that f = H up to h^(Order - 2):
/// f_H (1 + S) = 1 and f_H d + f_C = 0. The series of f follows from two facts that hold in closed form on each
/// principal axis with moment 1/x: the map turns by arcsin(h |m| x) a step, and a nutation about it advances by
/// 2 atan(kappa tan(half that angle)), kappa^2 = (x - x_j)(x - x_k) / x^2. They fix each homogeneous part of f, of
/// degree k in H and C, by Hermite interpolation in H/C at the three x (k <= 5). The part of degree 2 is equation (13)
/// of Hairer & Vilmart; S and d solve the truncated equations instead of being truncated series themselves, which
/// changes nothing in the order.
template <class Real, int Order>
class DiscreteMoserVeselov {
 public:
  static constexpr int order = Order;

  DiscreteMoserVeselov(const InverseMoments<Real>& body, const ScaledState<Real>& start, Real step) {
    Real casimir = 0, energy = 0;
    for (int i = 0; i < 3; ++i) {
      const Real square = start.m[i] * start.m[i] / Real(2);
      casimir += square;
      energy += square * body.x[i];
    }
    Real scale = 1, shift = 0, x[3];
    // Each round gains two orders.
    for (int round = 0;; ++round) {
      for (int i = 0; i < 3; ++i) x[i] = body.x[i] * scale + shift;
      if (2 * (round + 1) >= Order) break;
      const Gradient f = gradient(x, energy * scale + shift * casimir, casimir, step * step);
      scale = Real(1) / f.by_energy;
      shift = -f.by_casimir / f.by_energy;
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      coupling_[i] = x[i] / x[k] - x[i] / x[j];  // (I_k - I_j) / I_i
      half_rate_[i] = x[i] * step / Real(2);
    }
  }

  void advance(ScaledState<Real>& y, std::int64_t steps) {
    const std::int64_t before = newton_.evaluations;
    for (std::int64_t n = 0; n < steps; ++n) {
      const Real w[3] = {half_rate_[0] * y.m[0], half_rate_[1] * y.m[1], half_rate_[2] * y.m[2]};
      // One round of the equation itself is as good a start as the parabola through the last three solutions.
      Real first[3], g[3];
      const Real square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
      for (int i = 0; i < 3; ++i) {
        first[i] = w[i] + w[i] * square - coupling_[i] * w[(i + 1) % 3] * w[(i + 2) % 3];
      }
      const bool solved = newton_.solve(
          [&](const Real u[3], Real residual[3], Real jacobian[3][3]) {
            const Real length = Real(1) + u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
            for (int i = 0; i < 3; ++i) {
              const int j = (i + 1) % 3, k = (i + 2) % 3;
              residual[i] = u[i] + coupling_[i] * u[j] * u[k] - w[i] * length;
              const Real w2 = w[i] + w[i];
              jacobian[i][i] = Real(1) - w2 * u[i];
              jacobian[i][j] = coupling_[i] * u[k] - w2 * u[j];
              jacobian[i][k] = coupling_[i] * u[j] - w2 * u[k];
            }
          },
          first, g);
      if (!solved) {
        y.m[0] = Real(std::numeric_limits<double>::quiet_NaN());
        y.q[0] = y.m[0];
        break;
      }
      turn_by_cayley(y, g);
    }
    evaluations += newton_.evaluations - before;
  }

  std::int64_t evaluations = 0;  ///< Newton iterations

 private:
  struct Gradient {
    Real by_energy, by_casimir;
  };

  /// f_H and f_C of the map with inverse moments x, truncated at h^(Order - 2).
  static Gradient gradient(const Real x[3], Real energy, Real casimir, Real h2) {
    const Real e1 = x[0] + x[1] + x[2];
    const Real e2 = x[0] * x[1] + x[1] * x[2] + x[2] * x[0];
    const Real e3 = x[0] * x[1] * x[2];
    const auto r = [](int numerator, int denominator) { return Real(numerator) / Real(denominator); };
    // phi[k][i]: coefficient of H^i C^(k - i) h^(2 k - 2) in f.
    Real phi[6][6] = {};
    phi[2][0] = e3 / Real(6);
    phi[2][1] = -e2 / Real(6);
    phi[2][2] = e1 / Real(6);
    phi[3][0] = r(-1, 20) * e2 * e3;
    phi[3][1] = r(1, 10) * e1 * e3 + r(1, 20) * e2 * e2;
    phi[3][2] = r(-3, 20) * e1 * e2 + r(1, 10) * e3;
    phi[3][3] = r(1, 10) * e1 * e1 - r(1, 20) * e2;
    phi[4][0] = r(1, 56) * (e1 * e3 + e2 * e2) * e3;
    phi[4][1] = r(-3, 28) * e1 * e2 * e3 - r(1, 56) * e2 * e2 * e2 + r(1, 14) * e3 * e3;
    phi[4][2] = r(3, 28) * e1 * (e1 * e3 + e2 * e2) - r(9, 56) * e2 * e3;
    phi[4][3] = r(-5, 28) * e1 * e1 * e2 + r(1, 7) * e1 * e3 + r(1, 14) * e2 * e2;
    phi[4][4] = r(5, 56) * e1 * (e1 * e1 - e2) + r(1, 56) * e3;
    phi[5][0] = e3 * (r(-1, 48) * e1 * e2 * e3 - r(1, 144) * e2 * e2 * e2 + r(1, 72) * e3 * e3);
    phi[5][1] = r(1, 24) * e1 * e1 * e3 * e3 + r(1, 12) * e1 * e2 * e2 * e3 + r(1, 144) * e2 * e2 * e2 * e2 -
                r(5, 48) * e2 * e3 * e3;
    phi[5][2] = r(-5, 24) * e1 * e1 * e2 * e3 - r(5, 72) * e1 * e2 * e2 * e2 + r(1, 6) * e3 * (e1 * e3 + e2 * e2);
    phi[5][3] = r(5, 36) * e1 * e1 * e1 * e3 + r(5, 24) * e1 * e1 * e2 * e2 - r(5, 12) * e1 * e2 * e3 -
                r(5, 72) * e2 * e2 * e2 + r(1, 12) * e3 * e3;
    phi[5][4] = r(-35, 144) * e1 * e1 * e1 * e2 + r(5, 24) * e1 * (e1 * e3 + e2 * e2) - r(5, 48) * e2 * e3;
    phi[5][5] = r(7, 72) * e1 * e1 * e1 * e1 - r(7, 48) * e1 * e1 * e2 + r(1, 24) * e1 * e3 + r(1, 48) * e2 * e2;

    Gradient f{Real(1), Real(0)};
    Real power = 1;
    for (int k = 2; 2 * k <= Order; ++k) {
      power *= h2;
      // sum over i of phi_i H^i C^(k - i), differentiated by Horner's rule in H with rising powers of C.
      Real by_energy = 0, by_casimir = 0;
      for (int i = k; i >= 0; --i) {
        Real c = 1;  // C^(k - i - 1)
        for (int n = 0; n < k - i - 1; ++n) c *= casimir;
        Real e = 1;  // H^(i - 1)
        for (int n = 0; n < i - 1; ++n) e *= energy;
        if (i > 0) by_energy += Real(i) * phi[k][i] * e * (i < k ? c * casimir : Real(1));
        if (i < k) by_casimir += Real(k - i) * phi[k][i] * c * (i > 0 ? e * energy : Real(1));
      }
      f.by_energy += power * by_energy;
      f.by_casimir += power * by_casimir;
    }
    return f;
  }

  ExtrapolatedNewton<Real> newton_;
  Real coupling_[3];
  Real half_rate_[3];
};

}  // namespace polhode::rivals
