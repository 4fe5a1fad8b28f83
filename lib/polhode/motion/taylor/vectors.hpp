#pragma once

// Vectors of three components in a register, of doubles, and of sums of two doubles; polynomials of them.

#include <type_traits>

#include "polhode/base/double_double.hpp"
#include "polhode/base/target.hpp"
#include "polhode/motion/taylor/equations.hpp"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// GCC says how functions would pass vectors where the target has no such registers: none does, all are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace polhode::taylor {
inline namespace POLHODE_TARGET {

/// (x, y, z, anything); the compiler takes two registers where they have two lanes.
using Vector __attribute__((vector_size(32))) = double;

[[gnu::always_inline]] inline Vector all(double a) { return Vector{a, a, a, a}; }

[[gnu::always_inline]] inline void add_product(Vector& to, Vector a, Vector b) {
#if defined(__AVX2__) && defined(__FMA__)
  to = _mm256_fmadd_pd(a, b, to);
#else
  to = a * b + to;
#endif
}
[[gnu::always_inline]] inline void add_product(Vector& to, Vector a, double b) { add_product(to, a, all(b)); }

/// (y, z, x)
[[gnu::always_inline]] inline Vector yzx(Vector a) { return __builtin_shufflevector(a, a, 1, 2, 0, 3); }
[[gnu::always_inline]] inline Vector all_x(Vector a) { return __builtin_shufflevector(a, a, 0, 0, 0, 3); }
[[gnu::always_inline]] inline Vector rounded(Vector a) { return a; }
[[gnu::always_inline]] inline Vector over(Vector a, int /*n*/, double share) { return a * all(share); }

inline double larger(double a, double b) { return a > b ? a : b; }
inline double smaller(double a, double b) { return a < b ? a : b; }

[[gnu::always_inline]] inline double largest_component(Vector v) {
  const double x = __builtin_fabs(v[0]), y = __builtin_fabs(v[1]), z = __builtin_fabs(v[2]);
  return larger(x, larger(y, z));
}

[[gnu::always_inline]] inline Vector cross(Vector a, Vector b) { return yzx(a * yzx(b) - yzx(a) * b); }

/// The polynomial with these coefficients; the even and the odd ones by themselves, which takes half the time.
[[gnu::always_inline]] inline Vector sum_of(const Vector* coefficients, int order, double t) {
  const Vector t2 = all(t * t);
  Vector even = coefficients[order - order % 2], odd = coefficients[order - 1 + order % 2];
  for (int n = order - order % 2 - 2; n >= 0; n -= 2) {
    Vector next = coefficients[n];
    add_product(next, even, t2);
    even = next;
  }
  for (int n = order - 3 + order % 2; n > 0; n -= 2) {
    Vector next = coefficients[n];
    add_product(next, odd, t2);
    odd = next;
  }
  add_product(even, odd, all(t));
  return even;
}

template <class Coefficient>
[[gnu::always_inline]] inline Vector sum_at(const Coefficient& coefficient, int order, double t) {
  Vector sum = coefficient(order);
  for (int n = order - 1; n >= 0; --n) sum = coefficient(n) + sum * all(t);
  return sum;
}

/// A number between -1 and 1 in each lane (Marsaglia's xorshift).
[[gnu::always_inline]] inline Vector random_signs(unsigned long long& state) {
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  const auto part = [&](int shift) {
    return static_cast<double>(static_cast<int>((state >> shift) & 0xffff) - 0x8000) * 0x1p-15;
  };
  return Vector{part(0), part(16), part(32), part(48)};
}

/// The same in double-double (base/double_double.hpp has the numbers' own operations).
struct PreciseVector {
  Vector high = {}, low = {};
};

[[gnu::always_inline]] inline PreciseVector fast_two_sum(Vector a, Vector b) {
  const Vector s = a + b;
  return {s, b - (s - a)};
}
[[gnu::always_inline]] inline PreciseVector two_sum(Vector a, Vector b) {
  const Vector s = a + b, bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}
[[gnu::always_inline]] inline PreciseVector operator+(const PreciseVector& a, const PreciseVector& b) {
  const PreciseVector s = two_sum(a.high, b.high);
  return fast_two_sum(s.high, s.low + (a.low + b.low));
}
[[gnu::always_inline]] inline PreciseVector operator-(const PreciseVector& a, const PreciseVector& b) {
  return a + PreciseVector{-b.high, -b.low};
}
/// a b - p, exactly
[[gnu::always_inline]] inline Vector product_error(Vector a, Vector b, Vector p) {
#if defined(__AVX2__) && defined(__FMA__)
  return _mm256_fmsub_pd(a, b, p);
#else
  const Vector ta = a * all(0x1p27 + 1.0), tb = b * all(0x1p27 + 1.0);
  const Vector ah = ta - (ta - a), bh = tb - (tb - b), al = a - ah, bl = b - bh;
  return ((ah * bh - p) + ah * bl + al * bh) + al * bl;
#endif
}
[[gnu::always_inline]] inline PreciseVector operator*(const PreciseVector& a, const PreciseVector& b) {
  const Vector p = a.high * b.high;
  Vector low = product_error(a.high, b.high, p);
  add_product(low, a.high, b.low);
  add_product(low, a.low, b.high);
  return fast_two_sum(p, low);
}
[[gnu::always_inline]] inline PreciseVector operator*(const PreciseVector& a, double b) {
  return a * PreciseVector{all(b), Vector{}};
}
/// The sum's parts may overlap by the lower parts of some products; the next product or sum of two brings them in
/// order.
[[gnu::always_inline]] inline void add_product(PreciseVector& to, const PreciseVector& a, const PreciseVector& b) {
  const Vector p = a.high * b.high;
  const PreciseVector sum = two_sum(to.high, p);
  Vector low = product_error(a.high, b.high, p);
  add_product(low, a.high, b.low);
  add_product(low, a.low, b.high);
  to = {sum.high, to.low + (sum.low + low)};
}
[[gnu::always_inline]] inline void add_product(PreciseVector& to, const PreciseVector& a, TwoParts b) {
  add_product(to, a, PreciseVector{all(b.high), all(b.low)});
}
[[gnu::always_inline]] inline PreciseVector yzx(const PreciseVector& a) { return {yzx(a.high), yzx(a.low)}; }
[[gnu::always_inline]] inline PreciseVector all_x(const PreciseVector& a) { return {all_x(a.high), all_x(a.low)}; }
[[gnu::always_inline]] inline Vector rounded(const PreciseVector& a) { return a.high; }
/// a/n, with share = 1/n rounded
[[gnu::always_inline]] inline PreciseVector over(const PreciseVector& a, int n, double share) {
  const double missing = -__builtin_fma(share, static_cast<double>(n), -1.0) * share;
  return a * PreciseVector{all(share), all(missing)};
}

/// Three vectors side by side, so that their sums need not wait for each other.
struct Triple {
  Vector of[3] = {};
};
template <class Use>
[[gnu::always_inline]] inline Triple each_of(const Use& use) {
  return {{use(0), use(1), use(2)}};
}
[[gnu::always_inline]] inline Triple operator+(const Triple& a, const Triple& b) {
  return each_of([&](int k) __attribute__((always_inline)) { return a.of[k] + b.of[k]; });
}
[[gnu::always_inline]] inline Triple operator-(const Triple& a, const Triple& b) {
  return each_of([&](int k) __attribute__((always_inline)) { return a.of[k] - b.of[k]; });
}
[[gnu::always_inline]] inline void add_product(Triple& to, const Triple& a, const Vector& b) {
  for (int k = 0; k < 3; ++k) add_product(to.of[k], a.of[k], b);
}
[[gnu::always_inline]] inline void add_product(Triple& to, const Vector& a, const Triple& b) { add_product(to, b, a); }
[[gnu::always_inline]] inline Triple yzx(const Triple& a) {
  return each_of([&](int k) __attribute__((always_inline)) { return yzx(a.of[k]); });
}
[[gnu::always_inline]] inline Triple all_x(const Triple& a) {
  return each_of([&](int k) __attribute__((always_inline)) { return all_x(a.of[k]); });
}
[[gnu::always_inline]] inline Triple over(const Triple& a, int n, double share) {
  return each_of([&](int k) __attribute__((always_inline)) { return over(a.of[k], n, share); });
}

/// A vector, or a number, and its derivatives by three parameters.
struct VaryingVector {
  Vector value = {};
  Triple change;
};
struct Varying {
  double value = 0.0, change[3] = {};
};

[[gnu::always_inline]] inline VaryingVector operator+(const VaryingVector& a, const VaryingVector& b) {
  return {a.value + b.value, a.change + b.change};
}
[[gnu::always_inline]] inline VaryingVector operator-(const VaryingVector& a, const VaryingVector& b) {
  return {a.value - b.value, a.change - b.change};
}
[[gnu::always_inline]] inline void add_product(VaryingVector& to, const VaryingVector& a, const VaryingVector& b) {
  add_product(to.value, a.value, b.value);
  add_product(to.change, a.change, b.value);
  add_product(to.change, a.value, b.change);
}
[[gnu::always_inline]] inline void add_product(VaryingVector& to, const VaryingVector& a, const Varying& b) {
  add_product(to, a, VaryingVector{all(b.value), {{all(b.change[0]), all(b.change[1]), all(b.change[2])}}});
}
[[gnu::always_inline]] inline VaryingVector yzx(const VaryingVector& a) { return {yzx(a.value), yzx(a.change)}; }
[[gnu::always_inline]] inline VaryingVector all_x(const VaryingVector& a) { return {all_x(a.value), all_x(a.change)}; }
[[gnu::always_inline]] inline VaryingVector over(const VaryingVector& a, int n, double share) {
  return {over(a.value, n, share), over(a.change, n, share)};
}

/// The numbers beside vectors of a kind: coefficients of a function of time that is known.
template <class V>
using Number = std::conditional_t<std::is_same_v<V, Vector>, double,
                                  std::conditional_t<std::is_same_v<V, VaryingVector>, Varying, TwoParts>>;

}  // namespace POLHODE_TARGET
}  // namespace polhode::taylor
