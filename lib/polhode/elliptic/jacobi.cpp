#include "polhode/elliptic/jacobi.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace polhode {

Jacobi::Jacobi(double kc) : kc_(kc), limit_(1.0) {
  double a = 1.0, b = kc;
  // A step squares the relative difference: once it is below 2^-27 the next mean is exact.
  for (bool last = false; !last && steps_ < static_cast<int>(ab_.size());) {
    last = std::abs(a - b) <= 0x1p-27 * a;
    const double next = 0.5 * (a + b);
    const auto n = static_cast<std::size_t>(steps_++);
    ab_[n] = next * b;
    aa_[n] = next * a;
    b = std::sqrt(a * b);
    a = next;
  }
  limit_ = kc > 0.0 ? a : std::numeric_limits<double>::quiet_NaN();
  quarter_period_ = 0.5 * std::numbers::pi / limit_;
}

JacobiValues Jacobi::at_half_period_fraction(double x) const {
  // Beyond half of a quarter period go by K - u (DLMF 22.4(iii)): the trigonometric functions below stay within pi/4.
  const double distance = std::abs(x);
  const bool outer = distance > 0.25;
  const double v = 2.0 * quarter_period_ * (outer ? 0.5 - distance : distance);

  // Gauss's (descending Landen) transformation, DLMF 22.7.2 and 22.7.4, written for a_n sc: sums of positive terms.
  double tangent = std::tan(limit_ * v) / limit_;
  double dn = 1.0;
  for (int i = steps_ - 1; i >= 0; --i) {
    const auto n = static_cast<std::size_t>(i);
    const double square = tangent * tangent;
    const double next_dn = (1.0 + ab_[n] * square) / (1.0 + aa_[n] * square);
    tangent /= dn;
    dn = next_dn;
  }
  const double cn = 1.0 / std::sqrt(1.0 + tangent * tangent);
  const double sn = cn * tangent;
  if (!outer) return {std::copysign(sn, x), cn, dn};
  return {std::copysign(cn / dn, x), kc_ * sn / dn, kc_ / dn};
}

}  // namespace polhode
