#pragma once

#include <cmath>
#include <numbers>

#include "polhode/elliptic/carlson.hpp"

namespace polhode {

/// Moments, squared momenta and Delta_j = G^2 - 2T I_j in canonical axes: those of the body, or for a long-axis mode
/// with the first and third exchanged. Real is double or a number with its derivatives.
template <class Real>
struct CanonicalBody {
  Real i1, i2, i3;
  Real i21, i31, i32;  // i21 = i2 - i1 ...
  Real delta1, delta2, delta3;
};

/// For momentum 1: the polhode's frequency nu, negative in long-axis mode, and half the mean rate 2 rho at which axis 1
/// precesses about L; axis 3 precesses at 2 rho + nu. They are the constants of the theta-series solution
/// (motion/theta): the first series converges fast far from the separatrix, the second, its Jacobi transform, near it.
template <class Real>
struct SeriesRates {
  Real rho, nu;
};

/// Incomplete integral of the first kind with parameter m, F(atan2(y, x)), from m_c = 1 - m (DLMF 19.25.5). x, y >= 0.
template <class Real>
Real elliptic_f(const Real& y, const Real& x, const Real& m_c) {
  using std::hypot, std::sqrt;
  const Real radius = hypot(x, y);
  const Real sine = y / radius, cosine = x / radius;
  if (RealTraits<Real>::high(sine) == 0.0) return 0.0;
  return sine * carlson_rf_of_roots(cosine, Real(hypot(cosine, sqrt(m_c) * sine)), Real(1.0));
}

template <class Real>
SeriesRates<Real> series_rates(const CanonicalBody<Real>& c, const Real& m_c) {
  using std::abs, std::sqrt, std::exp, std::sin, std::cos, std::pow;
  constexpr double pi = std::numbers::pi;
  const Real m = -c.i21 * c.delta3 / (c.delta1 * c.i32);  // 1 - m_c, without the subtraction
  const Real b13 = sqrt(-c.i1 * c.delta3 / c.i31);
  const Real b31 = sqrt(c.i3 * c.delta1 / c.i31);
  const bool long_axis = RealTraits<Real>::high(c.i31) < 0.0;
  const Real half_bracket = 0.5 * (long_axis ? Real(1.0 / c.i1 - b31 * c.i31 / (c.i1 * c.i3))
                                             : Real(1.0 / c.i3 + b13 * b13 * c.i31 / ((1.0 + b31) * c.i1 * c.i3)));
  const Real size = sqrt(c.delta1 * c.i32 / (c.i1 * c.i2 * c.i3));
  const Real lambda = long_axis ? Real(-size) : size;
  const Real one_over_k = reciprocal_complete_k(Real(sqrt(m_c)));
  const Real one_over_k_prime = reciprocal_complete_k(Real(sqrt(m)));
  const Real y = elliptic_f(Real(sqrt(abs(c.i1 * c.i32))), Real(sqrt(abs(c.i3 * c.i21))), m);
  const Real nu = 0.5 * pi * lambda * one_over_k;

  if (2.0 * RealTraits<Real>::high(one_over_k) >= RealTraits<Real>::high(one_over_k_prime)) {  // 2 K'/K >= 1
    const Real y_rest = elliptic_f(b31, b13, m);
    const Real p = exp(-0.5 * pi * y_rest * one_over_k);
    const Real r = exp(-0.5 * pi * y * one_over_k);
    Real a0 = 0.0, a1 = 0.0;
    for (int j = -8; j <= 8; j += 2) {
      const Real term = (j % 4 == 0 ? 1.0 : -1.0) * pow(p, j * j) * pow(r, j * (j - 1));
      a0 += term;
      a1 += static_cast<double>(j) * term;
    }
    return {half_bracket - nu * a1 / a0, nu};
  }
  const Real q = exp(-0.5 * pi * one_over_k_prime / one_over_k);
  const Real z0 = 0.25 * pi * y * one_over_k_prime;
  Real above = 0.0, below = 0.0;
  for (int n = 0; n <= 5; ++n) {
    const Real coefficient = pow(q, n * (n + 1));
    above += (2.0 * n + 1.0) * coefficient * sin((2.0 * n + 1.0) * z0);
    below += coefficient * cos((2.0 * n + 1.0) * z0);
  }
  const Real quarter = 0.25 * pi * lambda * one_over_k_prime;
  return {half_bracket - quarter * y * one_over_k + quarter * above / below, nu};
}

}  // namespace polhode
