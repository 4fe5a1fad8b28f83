#pragma once

#include <array>

namespace polhode {

/// sn, cn and dn of one argument.
struct JacobiValues {
  double sn, cn, dn;
};

/// The Jacobi functions of one modulus, given by its complement kc = k' = sqrt(m_c), 0 < kc <= 1 or a rounding more
/// (NaN where it is not positive): near kc = 0 the modulus itself would have no digits left. Each of sn, cn and dn
/// keeps its relative accuracy over the whole period, also beside its zeros (measured for kc from 1e-20 to 1: 6 ulp of
/// 2^-53 for sn, 6 (1 + |u|) for cn and dn).
class Jacobi {
 public:
  explicit Jacobi(double kc);

  /// K, a quarter of the period; 364 for kc = 1e-157.
  double quarter_period() const { return quarter_period_; }

  /// Values at u = 2 K x for |x| <= 1/2, that is |u| <= K. Elsewhere sn and cn change sign with every 2 K, dn does not.
  JacobiValues at_half_period_fraction(double x) const;

 private:
  double kc_, quarter_period_;
  int steps_ = 0;
  // Per Landen step the products a_n b_(n-1) and a_n a_(n-1) of the arithmetic-geometric mean.
  std::array<double, 16> ab_{}, aa_{};
  double limit_;
};

}  // namespace polhode
