#include "polhode/elliptic/legendre_forms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polhode/elliptic/carlson.hpp"

namespace polhode {
namespace {

/// R_C(1, 1 + e), e > -1 (DLMF 19.6.20).
double rc_one(double e) {
  if (std::abs(e) < 1e-3) {  // the alternating series of arctan
    return 1.0 - e * (1.0 / 3 - e * (1.0 / 5 - e * (1.0 / 7 - e * (1.0 / 9 - e * (1.0 / 11)))));
  }
  const double root = std::sqrt(std::abs(e));
  return e > 0.0 ? std::atan(root) / root : std::atanh(root) / root;
}

}  // namespace

double carlson_rj_of_roots(double x, double y, double z, double p) {
  const bool two_zeros = (x == 0.0) + (y == 0.0) + (z == 0.0) > 1;
  if (!(x >= 0.0 && y >= 0.0 && z >= 0.0 && p > 0.0) || two_zeros) return std::numeric_limits<double>::quiet_NaN();
  // Duplication in the form of Carlson, Numer. Algorithms 10 (1995) 13, with the sum of DLMF 19.36.2 to order 7; its
  // error is about 3 d^8, d being the largest relative deviation from the mean.
  constexpr double kTolerance = 0.008;
  double xx = x * x, yy = y * y, zz = z * z, pp = p * p;
  // Differences p^2 - x^2, exact in the roots and divided by 4 from step to step.
  double px = (p - x) * (p + x), py = (p - y) * (p + y), pz = (p - z) * (p + z);
  double sum = 0.0, weight = 1.0;
  for (;;) {
    const double mean = 0.2 * (xx + yy + zz + 2.0 * pp);
    const double X = 1.0 - xx / mean, Y = 1.0 - yy / mean, Z = 1.0 - zz / mean;
    const double P = -0.5 * (X + Y + Z);
    if (!(std::max({std::abs(X), std::abs(Y), std::abs(Z), std::abs(P)}) >= kTolerance)) {  // ends on NaN too
      const double E2 = X * Y + X * Z + Y * Z - 3.0 * P * P;
      const double E3 = X * Y * Z + 2.0 * E2 * P + 4.0 * P * P * P;
      const double E4 = (2.0 * X * Y * Z + E2 * P + 3.0 * P * P * P) * P;
      const double E5 = X * Y * Z * P * P;
      const double series = 1.0 - 3.0 * E2 / 14.0 + E3 / 6.0 + 9.0 * E2 * E2 / 88.0 - 3.0 * E4 / 22.0 -
                            9.0 * E2 * E3 / 52.0 + 3.0 * E5 / 26.0 - E2 * E2 * E2 / 16.0 + 3.0 * E3 * E3 / 40.0 +
                            3.0 * E2 * E4 / 20.0 + 45.0 * E2 * E2 * E3 / 272.0 - 9.0 * (E3 * E4 + E2 * E5) / 68.0;
      return 6.0 * sum + weight * series / (mean * std::sqrt(mean));
    }
    const double fx = p + x, fy = p + y, fz = p + z;
    const double e = (px / (fx * fx)) * (py / (fy * fy)) * (pz / (fz * fz));
    sum += weight / (fx * fy * fz) * rc_one(e);
    weight *= 0.25;
    const double lambda = x * y + y * z + z * x;
    xx = 0.25 * (xx + lambda);
    yy = 0.25 * (yy + lambda);
    zz = 0.25 * (zz + lambda);
    pp = 0.25 * (pp + lambda);
    px *= 0.25;
    py *= 0.25;
    pz *= 0.25;
    x = std::sqrt(xx);
    y = std::sqrt(yy);
    z = std::sqrt(zz);
    p = std::sqrt(pp);
  }
}

double incomplete_f(double sine, double cosine, double kc) {
  if (!(sine >= 0.0 && kc >= 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return sine * carlson_rf_of_roots(cosine, std::hypot(cosine, kc * sine), 1.0);  // DLMF 19.25.5
}

double incomplete_pi(double sine, double cosine, double n, double one_minus_n, double kc) {
  const double delta = std::hypot(cosine, kc * sine);
  const double root_p = std::sqrt(cosine * cosine + one_minus_n * sine * sine);  // of 1 - n sin^2
  return incomplete_f(sine, cosine, kc) +
         n / 3.0 * sine * sine * sine * carlson_rj_of_roots(cosine, delta, 1.0, root_p);  // DLMF 19.25.14
}

}  // namespace polhode
