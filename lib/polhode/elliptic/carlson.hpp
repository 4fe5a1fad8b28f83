#pragma once

#include <limits>

#include "polhode/base/double_double.hpp"

namespace polhode {
inline namespace POLHODE_TARGET {

/// Carlson's R_F(x^2, y^2, z^2) from the square roots of its arguments (DLMF 19.16.1), so that arguments whose squares
/// underflow keep their digits. x, y, z >= 0; infinity if two are zero, NaN if one is negative or NaN. Real is double
/// (measured within 2 ulp) or DoubleDouble (within 2^-99). Duplication (DLMF 19.26.18), then the seventh-order series
/// (DLMF 19.36.1 with the terms of order 6 and 7).
template <class Real>
Real carlson_rf_of_roots(Real x, Real y, Real z) {
  using Traits = RealTraits<Real>;
  const auto high = [](Real v) { return Traits::high(v); };
  if (!(high(x) >= 0.0 && high(y) >= 0.0 && high(z) >= 0.0)) return std::numeric_limits<double>::quiet_NaN();
  const double smallest_two =
      high(x) < high(y) ? (high(y) < high(z) ? high(y) : high(z)) : (high(x) < high(z) ? high(x) : high(z));
  if (smallest_two == 0.0) return std::numeric_limits<double>::infinity();
  // The series' relative error is about 0.2 d^8, with d the largest relative deviation from the mean.
  const double tolerance = sizeof(Real) == sizeof(double) ? 0.011 : 1e-4;
  Real xx = x * x, yy = y * y, zz = z * z;
  for (;;) {
    const double sum = high(xx) + high(yy) + high(zz);
    const auto differs = [&](Real v) { return __builtin_fabs(sum - 3.0 * high(v)) > tolerance * sum; };
    if (!(differs(xx) || differs(yy) || differs(zz))) {
      const Real mean = (xx + yy + zz) / 3.0;
      const Real dx = 1.0 - xx / mean, dy = 1.0 - yy / mean;
      const Real dz = -(dx + dy);
      const Real e2 = dx * dy - dz * dz;
      const Real e3 = dx * dy * dz;
      const Real e2_2 = e2 * e2;
      const Real series = 1.0 - e2 / 10.0 + e3 / 14.0 + e2_2 / 24.0 - e2 * e3 * 3.0 / 44.0 - e2_2 * e2 * 5.0 / 208.0 +
                          e3 * e3 * 3.0 / 104.0 + e2_2 * e3 / 16.0;
      return series / sqrt(mean);
    }
    const Real lambda = x * y + y * z + z * x;
    xx = (xx + lambda) * 0.25;
    yy = (yy + lambda) * 0.25;
    zz = (zz + lambda) * 0.25;
    x = sqrt(xx);
    y = sqrt(yy);
    z = sqrt(zz);
  }
}

/// 1/K, the reciprocal of the complete elliptic integral of the first kind whose complementary parameter is
/// m_c = kc^2 (DLMF 19.8.5): 2/pi times the arithmetic-geometric mean of 1 and kc. 0 <= kc <= 1; zero at kc = 0, NaN
/// where kc is negative or NaN.
template <class Real>
Real reciprocal_complete_k(Real kc) {
  using Traits = RealTraits<Real>;
  if (Traits::high(kc) == 0.0) return 0.0;
  if (!(Traits::high(kc) > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  Real a = 1.0, b = kc;
  for (;;) {
    const Real difference = a - b;
    const Real mean = (a + b) * 0.5;
    // Quadratic convergence: the next mean would differ by difference^2 / (16 mean).
    const double relative = __builtin_fabs(Traits::high(difference)) / Traits::high(mean);
    if (!(relative * relative >= 8.0 * Traits::epsilon)) return mean * 2.0 / Traits::pi();
    b = sqrt(a * b);
    a = mean;
  }
}

}  // namespace POLHODE_TARGET
}  // namespace polhode
