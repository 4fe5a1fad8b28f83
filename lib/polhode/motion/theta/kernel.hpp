#pragma once

// The answer at an instant (theta.md, "The answer"), for one time or for the lanes of a register. Branch-free.

#include "polhode/motion/theta/lanes.hpp"
#include "polhode/motion/theta/series.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

// Minimax polynomials, from coefficients.py: sin(pi/2 y) = pi/2 y + y^3 tail(y^2) and cos(pi/2 y) = 1 - pi^2/8 y^2 +
// y^4 tail(y^2) for y^2 <= 0.252, cosh x = 1 + x^2 tail(x^2) and sinh x = x + x^3 tail(x^2) for |x| <= ln2/2.
// largest error 2^-59.1
inline constexpr double kSineTail[] = {-0x1.4abbce625be3ap-1, 0x1.466bc67757baep-4,   -0x1.32d2cce2105fcp-8,
                                       0x1.50782f0eb3c1cp-13, -0x1.e2ffbfabc9bfcp-19, 0x1.e3b8ff41c45b1p-25};
// largest error 2^-64.1
inline constexpr double kCosineTail[] = {0x1.03c1f081b5abcp-2,   -0x1.55d3c7e3ca604p-6, 0x1.e1f5068509874p-11,
                                         -0x1.a6d1ed9e7859ep-16, 0x1.f9cd072de0d0fp-22, -0x1.b299ad1cd5e33p-28};
// largest error 2^-58.0
inline constexpr double kExponentialEven[] = {0x1.000000000000cp-1, 0x1.555555554fef0p-5, 0x1.6c16c185e656dp-10,
                                              0x1.a01995f36068fp-16, 0x1.28b0d77ebc22dp-22};
// largest error 2^-64.0
inline constexpr double kExponentialOdd[] = {0x1.555555555555cp-3, 0x1.111111110eb6fp-7, 0x1.a01a01b3d5c86p-13,
                                             0x1.71ddef4fec744p-19, 0x1.af6d4528f3cb4p-26};
inline constexpr double kHalfPiHigh = 0x1.921fb54442d18p+0, kHalfPiLow = 0x1.1a62633145c07p-54;
inline constexpr double kEighthPi2 = 0x1.3bd3cc9be45dep+0;  // pi^2/8
inline constexpr double kMagic = 0x1.8p52;                  // its last bits are those of a small integer added to it

template <class V>
struct Pair {
  V high, low;
};

template <int Degree, class V>
inline V polynomial(const double* a, V x) {
  V sum = all<V>(a[Degree]);
  for (int k = Degree - 1; k >= 0; --k) sum = multiply_add(sum, x, all<V>(a[k]));
  return sum;
}

/// The polynomial of degree 5 in pairs: half the latency of Horner's rule.
template <class V>
inline V polynomial_of_degree_5(const double (&a)[6], V x) {
  const V x2 = x * x;
  const V first = multiply_add(x, all<V>(a[1]), all<V>(a[0]));
  const V second = multiply_add(x, all<V>(a[3]), all<V>(a[2]));
  const V third = multiply_add(x, all<V>(a[5]), all<V>(a[4]));
  return multiply_add(x2, multiply_add(x2, third, second), first);
}

/// Four polynomials side by side.
template <int Degree, class V>
inline void polynomials(const double (&a)[kMaxDegree + 1][4], V x, V (&sums)[4]) {
  for (int i = 0; i < 4; ++i) sums[i] = all<V>(a[Degree][i]);
  for (int n = Degree - 1; n >= 0; --n) {
    for (int i = 0; i < 4; ++i) sums[i] = multiply_add(sums[i], x, all<V>(a[n][i]));
  }
}

template <class V>
inline Pair<V> pair_sum(V a, V b) {
  const V s = a + b;
  const V bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}

/// An angle of (quarter + y) quarter turns, |y| <= 1/2; of the integer only its last two bits count.
template <class V>
struct Angle {
  V y;
  typename BitsOf<V>::type quarter;
};

inline constexpr double kSafePeriods = 0x1p50;   // up to here the nearest whole number is the nearest, and odd or even
inline constexpr double kSafeQuarters = 0x1p44;  // up to here t times the low part of a rate stays far below 1

/// rate t + offset + whole in quarter turns, |offset| <= 1/2 in the most accurate case, whole an integer. The product
/// is rounded once, after its whole quarters have gone; beyond kSafeQuarters whole quarters are taken out of each part.
template <class V>
[[gnu::always_inline]] inline Angle<V> angle(V rate, V rate_low, V t_high, V t_low, V offset, V whole) {
  const V magic = all<V>(kMagic) + whole;
  const V about = multiply_add(t_high, rate, offset);
  V rest = multiply_add(t_low, rate, t_high * rate_low);
  const V near = about + magic;
  const V fraction = product_minus(t_high, rate, near - magic);
  Angle<V> result{fraction + (offset + rest), bits(near)};
  if (any_above(magnitude(about), kSafeQuarters)) [[unlikely]] {
    const V product = t_high * rate;
    const V turns = nearest_integer(product * 0.25) * 4.0;
    rest = rest + product_error(t_high, rate, product);
    rest = rest - nearest_integer(rest * 0.25) * 4.0;
    const V y = ((product - turns) + offset) + rest;
    const V shifted = y + magic;
    const auto far = above(magnitude(about), kSafeQuarters);  // lanes do not depend on their neighbours
    result.y = choose(far, result.y, y - (shifted - magic));
    result.quarter = (result.quarter & ~far) | (bits(shifted) & far);
  }
  return result;
}

/// The same for one rate.
template <class V>
[[gnu::always_inline]] inline Angle<V> angle(const TwoPart& quarters_per_s, V t_high, V t_low, V offset,
                                             double whole = 0.0) {
  return angle(all<V>(quarters_per_s.high), all<V>(quarters_per_s.low), t_high, t_low, offset, all<V>(whole));
}

/// sin and cos of an angle; absolute errors below 0.8 and 1.1 times 2^-53 with fma, 1.3 without (measured).
template <class V>
[[gnu::always_inline]] inline void sine_cosine(const Angle<V>& x, V& sine, V& cosine) {
  const V y = x.y, u = y * y;
  const V tail = multiply_add(u, polynomial_of_degree_5(kSineTail, u), all<V>(kHalfPiLow));
  const V s = multiply_add(y, all<V>(kHalfPiHigh), y * tail);
  const V c =
      multiply_add(u, multiply_add(u, polynomial_of_degree_5(kCosineTail, u), all<V>(-kEighthPi2)), all<V>(1.0));
  sine = flip(choose(x.quarter, s, c), x.quarter << 62);
  cosine = flip(choose(x.quarter, c, s), (x.quarter + 1) << 62);
}

/// e^{-x} and scale e^x for x >= 0, relative errors below 2^-52; x is taken as 700 beyond that.
template <class V>
[[gnu::always_inline]] inline void exponentials(V x, double scale, V& falling, V& growing) {
  const V argument = smaller(x, all<V>(700.0));
  const V magic = all<V>(kMagic);
  const V shifted = multiply_add(argument, all<V>(-0x1.71547652b82fep+0), magic);  // -1/ln 2
  const V k = shifted - magic;
  V r = multiply_add(k, all<V>(-0x1.62e42fefap-1), -argument);  // exact: the constant has 33 bits
  r = multiply_add(k, all<V>(-0x1.cf79abc9e3b3ap-40), r);
  const V u = r * r;
  const V even = multiply_add(u, polynomial<4>(kExponentialEven, u), all<V>(1.0));  // cosh r
  const V odd = multiply_add(u * r, polynomial<4>(kExponentialOdd, u), r);          // sinh r
  falling = value<V>(bits(even + odd) + (bits(shifted) << 52));
  growing = (even - odd) * scale * value<V>(bits(all<V>(1.0)) - (bits(shifted) << 52));
}

/// Attitude and momentum (times its scale) from alpha and beta, one of them of size near 1, and the phase of rho t.
template <class V>
[[gnu::always_inline]] inline void attitude_and_momentum(const OutputFrame& f, V re_alpha, V re_beta, V im_alpha,
                                                         V im_beta, V sine, V cosine, V (&q)[4], V (&m)[3]) {
  const V alpha2 = multiply_add(re_alpha, re_alpha, im_alpha * im_alpha);
  const V beta2 = multiply_add(re_beta, re_beta, im_beta * im_beta);
  const V n = alpha2 + beta2;
  const V reciprocal = 1.0 / n;
  const V scale = square_root(reciprocal);
  const V twice = 2.0 * reciprocal;
  const V m1 = multiply_add(im_alpha, re_beta, -re_alpha * im_beta) * twice;
  const V m2 = multiply_add(re_alpha, re_beta, im_alpha * im_beta) * twice;
  const V m3 = (alpha2 - beta2) * reciprocal;
  m[0] = (f.exchange_1_3 ? m3 : m1) * f.momentum_scale[f.exchange_1_3 ? 2 : 0];
  m[1] = m2 * f.momentum_scale[1];
  m[2] = (f.exchange_1_3 ? m1 : m3) * f.momentum_scale[f.exchange_1_3 ? 0 : 2];
  const V e0 = multiply_add(re_alpha, cosine, -im_alpha * sine);
  const V e1 = multiply_add(re_beta, cosine, -im_beta * sine);
  const V e2 = multiply_add(re_beta, sine, im_beta * cosine);
  const V e3 = multiply_add(re_alpha, sine, im_alpha * cosine);
  for (int k = 0; k < 4; ++k) q[k] = f.frame[0][k] * e0;
  for (int k = 0; k < 4; ++k) q[k] = multiply_add(all<V>(f.frame[1][k]), e1, q[k]);
  for (int k = 0; k < 4; ++k) q[k] = multiply_add(all<V>(f.frame[2][k]), e2, q[k]);
  for (int k = 0; k < 4; ++k) q[k] = multiply_add(all<V>(f.frame[3][k]), e3, q[k]) * scale;
}

struct FixedAxisAt {
  const FixedAxis& s;

  template <class V>
  struct Phases {
    V sine, cosine;
  };
  template <class V>
  [[gnu::always_inline]] Phases<V> phases(V t_high, V t_low) const {
    Phases<V> p;
    sine_cosine(angle(s.quarters_per_s, t_high, t_low, V{}), p.sine, p.cosine);
    return p;
  }
  template <class V>
  [[gnu::always_inline]] void state(const Phases<V>& p, V (&q)[4], V (&m)[3]) const {
    for (int k = 0; k < 4; ++k) q[k] = multiply_add(all<V>(s.sine[k]), p.sine, s.cosine[k] * p.cosine);
    for (int k = 0; k < 3; ++k) m[k] = all<V>(s.momentum[k]);
  }
};

template <int Degree>
struct FourierAt {
  const FourierChart& s;

  template <class V>
  struct Phases {
    V sin_v, cos_v, sin_rho, cos_rho;
  };
  template <class V>
  [[gnu::always_inline]] Phases<V> phases(V t_high, V t_low) const {
    Phases<V> p;
    sine_cosine(angle(s.v_quarters_per_s, t_high, t_low, all<V>(s.v_quarters_at_0), s.v_whole_quarters_at_0), p.sin_v,
                p.cos_v);
    sine_cosine(angle(s.rho_quarters_per_s, t_high, t_low, V{}), p.sin_rho, p.cos_rho);
    return p;
  }
  template <class V>
  [[gnu::always_inline]] void state(const Phases<V>& p, V (&q)[4], V (&m)[3]) const {
    const V two_sin = p.sin_v + p.sin_v;
    const V cos_2v = multiply_add(-two_sin, p.sin_v, all<V>(1.0));
    const V sin_2v = two_sin * p.cos_v;
    V c[4];
    polynomials<Degree>(s.polynomial, cos_2v, c);
    attitude_and_momentum(s.frame, c[0], p.sin_v * c[1], sin_2v * c[2], p.cos_v * c[3], p.sin_rho, p.cos_rho, q, m);
  }
};

template <int Degree>
struct HyperbolicAt {
  const HyperbolicChart& s;

  template <class V>
  struct Phases {
    V falling, growing, sine, cosine;       // E, Y; of the phase
    typename BitsOf<V>::type side, parity;  // in the highest bit
  };
  template <class V>
  struct Position {
    V x, n;
  };
  /// Exact to its last place where e^{-|x|} is not small, since that is where the body turns over.
  template <class V>
  [[gnu::always_inline]] Position<V> position(V t_high, V t_low) const {
    const V rate = all<V>(s.x_per_s.high);
    const V product = t_high * rate;
    V rest = multiply_add(t_high, all<V>(s.x_per_s.low), product_error(t_high, rate, product));
    rest = multiply_add(t_low, rate, rest) + s.x_at_0.low;
    const Pair<V> sum = pair_sum(product, all<V>(s.x_at_0.high));
    V n = nearest_integer(sum.high * s.reciprocal_x_period);
    V x = product_minus(-n, all<V>(s.x_period.high), -sum.high) +
          multiply_add(-n, all<V>(s.x_period.low), sum.low + rest);
    if (any_above(magnitude(n), kSafePeriods)) [[unlikely]] {
      // The whole number was rounded, by whole periods perhaps: reduce what it left. Of itself only the parity counts.
      n = n - 2.0 * nearest_integer(n * 0.5);
      for (int i = 0; i < 2; ++i) {
        const V more = nearest_integer(x * s.reciprocal_x_period);
        x = product_minus(-more, all<V>(s.x_period.high), -x) - more * s.x_period.low;
        n = n + (more - 2.0 * nearest_integer(more * 0.5));
      }
      // Beyond any arithmetic: some state of the body.
      const V half = all<V>(0.5 * s.x_period.high);
      x = -smaller(-smaller(x, half), half);
    }
    return {x, n};
  }
  template <class V>
  [[gnu::always_inline]] Phases<V> phases(V t_high, V t_low) const {
    const auto [x, n] = position(t_high, t_low);
    Phases<V> p;
    exponentials(magnitude(x), s.root_of_nome, p.falling, p.growing);
    sine_cosine(angle(s.rho_quarters_per_s, t_high, t_low, x * s.x_to_quarters), p.sine, p.cosine);
    p.side = bits(x);
    p.parity = bits(n + all<V>(kMagic)) << 63;
    return p;
  }
  template <class V>
  [[gnu::always_inline]] void state(const Phases<V>& p, V (&q)[4], V (&m)[3]) const {
    V growing[4], falling[4];
    polynomials<Degree>(s.growing, p.growing, growing);
    polynomials<Degree>(s.falling, p.falling, falling);
    V c[4];
    for (int i = 0; i < 4; ++i) c[i] = multiply_add(p.falling, falling[i], growing[i]);
    attitude_and_momentum(s.frame, c[0], flip(c[1], p.side ^ p.parity), flip(c[2], p.side), flip(c[3], p.parity),
                          p.sine, p.cosine, q, m);
  }
};

/// Calls `with` with the evaluation that belongs to the solution.
template <class With>
inline void dispatch(const Solution& s, const With& with) {
  switch (s.chart) {
    case Chart::fixed_axis:
      return with(FixedAxisAt{s.fixed_axis});
    case Chart::fourier:
      switch (s.fourier.degree) {
        case 0:
          return with(FourierAt<0>{s.fourier});
        case 1:
          return with(FourierAt<1>{s.fourier});
        case 2:
          return with(FourierAt<2>{s.fourier});
        default:
          return with(FourierAt<3>{s.fourier});
      }
    case Chart::hyperbolic:
      switch (s.hyperbolic.degree) {
        case 0:
          return with(HyperbolicAt<0>{s.hyperbolic});
        case 1:
          return with(HyperbolicAt<1>{s.hyperbolic});
        case 2:
          return with(HyperbolicAt<2>{s.hyperbolic});
        default:
          return with(HyperbolicAt<3>{s.hyperbolic});
      }
  }
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
