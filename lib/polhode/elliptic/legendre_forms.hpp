#pragma once

#include <limits>

#include "polhode/base/double_double.hpp"

// Elliptic integrals by the complementary modulus kc = k' = sqrt(m_c), and the amplitude phi by its sine and cosine, so
// that a caller who knows 1 - k^2 or the distance to pi/2 better than a subtraction loses nothing. With
// D(theta)^2 = cos^2 + kc^2 sin^2 = 1 - k^2 sin^2. Arguments out of the stated range give NaN.

namespace polhode {

/// Bulirsch's complete integral (DLMF 19.2.11 with 19.2(iii); Bulirsch, Numer. Math. 13 (1969) 305, "cel"), with
/// p = root_p^2:
///   integral of (a cos^2 + b sin^2) / ((cos^2 + p sin^2) D) from 0 to pi/2,
/// for 0 < kc, 0 < root_p and a, b >= 0. Every operation adds positive terms: nothing cancels, whatever kc and p. Real
/// is double or DoubleDouble; the relative error is a few epsilon of the type.
template <class Real>
Real complete_integral(Real kc, Real root_p, Real a, Real b) {
  using Traits = RealTraits<Real>;
  if (!(Traits::high(kc) > 0.0 && Traits::high(root_p) > 0.0 && Traits::high(a) >= 0.0 && Traits::high(b) >= 0.0)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  Real e = kc, m = 1.0, p = root_p;
  b = b / p;
  for (;;) {
    const Real previous_a = a;
    a = a + b / p;
    Real g = e / p;
    b = (b + previous_a * g) * 2.0;
    p = p + g;
    g = m;
    m = m + kc;
    const Real difference = g - kc;
    const double relative = Traits::high(difference) / Traits::high(g);
    if (!(relative * relative >= Traits::epsilon)) break;  // ends on NaN too
    kc = sqrt(e) * 2.0;
    e = kc * m;
  }
  return (a * m + b) / (m * (m + p)) * (Traits::pi() * 0.5);
}

/// R_J(x^2, y^2, z^2, p^2) of the roots of its arguments (DLMF 19.16.2): x, y, z >= 0, at most one of them 0, p > 0,
/// all between 1e-100 and 1e100 where not 0. Needs (p - x)(p - y)(p - z) / ((p + x)(p + y)(p + z)) > -0.99, as it is
/// for every free body (there it is positive). Measured within 10 ulp.
double carlson_rj_of_roots(double x, double y, double z, double p);

/// F(phi, k) for sine, cosine >= 0: 0 <= phi <= pi/2 (DLMF 19.2.4).
double incomplete_f(double sine, double cosine, double kc);

/// Pi(phi, n, k) in the sense of DLMF 19.2.7 (denominator 1 - n sin^2), 0 <= phi <= pi/2, n < 1; `one_minus_n` is given
/// beside n because it may be known better than by subtraction.
double incomplete_pi(double sine, double cosine, double n, double one_minus_n, double kc);

}  // namespace polhode
