#pragma once

#include <bit>
#include <cstdint>

#include "polhode/base/target.hpp"

namespace polhode {
inline namespace POLHODE_TARGET {

/// An unevaluated sum high + low of two doubles, |low| <= ulp(high)/2: about 32 digits, range of a double. The error
/// bound stated beside an operation is relative, in units of u = 2^-53, for operands away from under- and overflow.
/// Algorithms: Joldes, Muller & Popescu, ACM TOMS 44 (2017) 15, numbers in brackets; Dekker 1971; Knuth, TAOCP 2.
struct DoubleDouble {
  double high = 0.0;
  double low = 0.0;

  constexpr DoubleDouble() = default;
  constexpr DoubleDouble(double value) : high(value) {}  // NOLINT(google-explicit-constructor): exact, as for numbers
  constexpr DoubleDouble(double h, double l) : high(h), low(l) {}

  explicit constexpr operator double() const { return high; }
};

/// a + b exactly, for |a| >= |b| (Dekker).
inline DoubleDouble fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

/// a + b exactly (Knuth).
inline DoubleDouble two_sum(double a, double b) {
  const double s = a + b;
  const double bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}

/// a * b exactly.
inline DoubleDouble two_product(double a, double b) {
  const double p = a * b;
  return {p, __builtin_fma(a, b, -p)};
}

inline DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }

inline DoubleDouble operator+(DoubleDouble a, double b) {  // [4], 2 u^2
  const DoubleDouble s = two_sum(a.high, b);
  return fast_two_sum(s.high, a.low + s.low);
}

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {  // [6], 3 u^2 whatever the signs
  const DoubleDouble s = two_sum(a.high, b.high);
  const DoubleDouble t = two_sum(a.low, b.low);
  const DoubleDouble v = fast_two_sum(s.high, s.low + t.high);
  return fast_two_sum(v.high, t.low + v.low);
}
inline DoubleDouble operator+(double a, DoubleDouble b) { return b + a; }
inline DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + (-b); }
inline DoubleDouble operator-(DoubleDouble a, double b) { return a + (-b); }
inline DoubleDouble operator-(double a, DoubleDouble b) { return (-b) + a; }

inline DoubleDouble operator*(DoubleDouble a, double b) {  // [9], 2 u^2
  const DoubleDouble c = two_product(a.high, b);
  return fast_two_sum(c.high, __builtin_fma(a.low, b, c.low));
}
inline DoubleDouble operator*(double a, DoubleDouble b) { return b * a; }

inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {  // [12], 4 u^2
  const DoubleDouble c = two_product(a.high, b.high);
  const double t = __builtin_fma(a.high, b.low, a.low * b.low);
  return fast_two_sum(c.high, c.low + __builtin_fma(a.low, b.high, t));
}

inline DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {  // [17], 9.8 u^2 at most
  const double q = a.high / b.high;
  const DoubleDouble r = b * q;
  const double d = (a.high - r.high) + (a.low - r.low);
  return fast_two_sum(q, d / b.high);
}
inline DoubleDouble operator/(DoubleDouble a, double b) { return a / DoubleDouble(b); }
inline DoubleDouble operator/(double a, DoubleDouble b) { return DoubleDouble(a) / b; }

inline bool operator<(DoubleDouble a, DoubleDouble b) { return a.high < b.high || (a.high == b.high && a.low < b.low); }
inline bool operator>(DoubleDouble a, DoubleDouble b) { return b < a; }

inline DoubleDouble abs(DoubleDouble a) { return a.high < 0.0 ? -a : a; }

inline DoubleDouble sqrt(DoubleDouble a) {  // one Newton step from the double, 4 u^2; 0 for 0
  if (!(a.high > 0.0)) return {__builtin_sqrt(a.high), 0.0};
  const double s = __builtin_sqrt(a.high);
  const double residual = __builtin_fma(-s, s, a.high) + a.low;
  return fast_two_sum(s, residual / (2.0 * s));
}

/// a 2^exponent. The library's function is called only for powers that are not normal numbers themselves.
inline double ldexp(double a, int exponent) {
  if (exponent < -1022 || exponent > 1023) return __builtin_ldexp(a, exponent);
  return a * std::bit_cast<double>((std::int64_t{exponent} + 1023) << 52);
}
inline DoubleDouble ldexp(DoubleDouble a, int exponent) { return {ldexp(a.high, exponent), ldexp(a.low, exponent)}; }

inline constexpr DoubleDouble kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
inline constexpr DoubleDouble kLn2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};

/// e^a, relative error below 2^-100 (argument reduced by ln 2 and 2^-9, Taylor series of expm1, nine squarings).
inline DoubleDouble exp(DoubleDouble a) {
  if (a.high < -745.0) return 0.0;
  const double k = __builtin_rint(a.high / kLn2.high);
  const DoubleDouble r = ldexp(a - kLn2 * k, -9);
  DoubleDouble term = r, sum = r;
  for (int n = 2; n <= 9; ++n) {
    term = term * r / static_cast<double>(n);
    sum = sum + term;
  }
  for (int i = 0; i < 9; ++i) sum = sum * 2.0 + sum * sum;  // expm1(2x) from expm1(x)
  return ldexp(sum + 1.0, static_cast<int>(k));
}

/// Natural logarithm of a > 0, absolute error below 2^-100 (one Newton step on exp).
inline DoubleDouble log(DoubleDouble a) {
  const double y = __builtin_log(a.high);
  return a * exp(-DoubleDouble(y)) - 1.0 + y;
}

/// sin and cos of 2 pi x for |x| <= 1/2, absolute error below 2^-100.
inline void sincos_turns(DoubleDouble x, DoubleDouble& sine, DoubleDouble& cosine) {
  const double quarter = __builtin_rint(4.0 * x.high);
  const DoubleDouble a = (x - 0.25 * quarter) * kPi * 2.0;
  const DoubleDouble minus_a2 = -(a * a);
  DoubleDouble s = a, c = 1.0, s_term = a, c_term = 1.0;
  for (int n = 1; n <= 14; ++n) {
    c_term = c_term * minus_a2 / (2.0 * n * (2.0 * n - 1.0));
    s_term = s_term * minus_a2 / (2.0 * n * (2.0 * n + 1.0));
    c = c + c_term;
    s = s + s_term;
  }
  switch (static_cast<int>(quarter) & 3) {
    case 0:
      sine = s, cosine = c;
      break;
    case 1:
      sine = c, cosine = -s;
      break;
    case 2:
      sine = -s, cosine = -c;
      break;
    default:
      sine = -c, cosine = s;
      break;
  }
}

// The same functions for double, so that one text serves both.
inline double abs(double a) { return __builtin_fabs(a); }
inline double sqrt(double a) { return __builtin_sqrt(a); }
inline double exp(double a) { return __builtin_exp(a); }
inline double log(double a) { return __builtin_log(a); }
inline void sincos_turns(double x, double& sine, double& cosine) {
  const double a = x * (2.0 * kPi.high);
  sine = __builtin_sin(a);
  cosine = __builtin_cos(a);
}

/// Largest relative error of one operation, and the two parts of a number.
template <class Real>
struct RealTraits;
template <>
struct RealTraits<double> {
  static constexpr double epsilon = 0x1p-53;
  static double high(double a) { return a; }
  static double low(double) { return 0.0; }
  static double pi() { return kPi.high; }
  static double ln2() { return kLn2.high; }
};
template <>
struct RealTraits<DoubleDouble> {
  static constexpr double epsilon = 0x1p-104;
  static double high(DoubleDouble a) { return a.high; }
  static double low(DoubleDouble a) { return a.low; }
  static DoubleDouble pi() { return kPi; }
  static DoubleDouble ln2() { return kLn2; }
};

}  // namespace POLHODE_TARGET
}  // namespace polhode
