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

template <class V>
inline Pair<V> two_sum(V a, V b) {
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

inline constexpr double kSafeQuarters = 0x1p44;  // up to here t times the low part of a rate stays far below 1

/// rate t + offset + whole in quarter turns, |offset| <= 1/2 in the most accurate case, whole an integer. The product
/// is rounded once, after its whole quarters have gone; beyond kSafeQuarters whole quarters are taken out of each part.
template <class V>
[[gnu::always_inline]] inline Angle<V> angle(const TwoPart& quarters_per_s, V t_high, V t_low, V offset,
                                             double whole = 0.0) {
  const V magic = all<V>(kMagic + whole), rate = all<V>(quarters_per_s.high);
  const V about = multiply_add(t_high, rate, offset);
  V rest = multiply_add(t_low, rate, t_high * quarters_per_s.low);
  if (any_above(magnitude(about), kSafeQuarters)) [[unlikely]] {
    const V product = t_high * rate;
    const V turns = nearest_integer(product * 0.25) * 4.0;
    rest = rest + product_error(t_high, rate, product);
    rest = rest - nearest_integer(rest * 0.25) * 4.0;
    const V y = ((product - turns) + offset) + rest;
    const V shifted = y + magic;
    return {y - (shifted - magic), bits(shifted)};
  }
  const V shifted = about + magic;
  const V fraction = product_minus(t_high, rate, shifted - magic);
  return {fraction + (offset + rest), bits(shifted)};
}

/// sin and cos of an angle; absolute error below 0.7 2^-53.
template <class V>
[[gnu::always_inline]] inline void sine_cosine(const Angle<V>& x, V& sine, V& cosine) {
  const V y = x.y, u = y * y;
  const V tail = multiply_add(u, polynomial<5>(kSineTail, u), all<V>(kHalfPiLow));
  const V s = multiply_add(y, all<V>(kHalfPiHigh), y * tail);
  const V c = multiply_add(u, multiply_add(u, polynomial<5>(kCosineTail, u), all<V>(-kEighthPi2)), all<V>(1.0));
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
[[gnu::always_inline]] inline void attitude_and_momentum(const Frame& f, V re_alpha, V im_alpha, V re_beta, V im_beta,
                                                         V sine, V cosine, V (&q)[4], V (&m)[3]) {
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
  for (int k = 0; k < 4; ++k) {
    const double* row = f.frame[k];
    q[k] = scale * multiply_add(all<V>(row[3]), e3,
                                multiply_add(all<V>(row[2]), e2, multiply_add(all<V>(row[1]), e1, row[0] * e0)));
  }
}

struct FixedAxisAt {
  const FixedAxis& s;

  template <class V>
  [[gnu::always_inline]] void operator()(V t_high, V t_low, V (&q)[4], V (&m)[3]) const {
    V sine, cosine;
    sine_cosine(angle(s.quarters_per_s, t_high, t_low, V{}), sine, cosine);
    for (int k = 0; k < 4; ++k) q[k] = multiply_add(all<V>(s.sine[k]), sine, s.cosine[k] * cosine);
    for (int k = 0; k < 3; ++k) m[k] = all<V>(s.momentum[k]);
  }
};

template <int Degree>
struct FourierAt {
  const FourierChart& s;

  template <class V>
  [[gnu::always_inline]] void operator()(V t_high, V t_low, V (&q)[4], V (&m)[3]) const {
    V sin_v, cos_v, sin_rho, cos_rho;
    sine_cosine(angle(s.v_quarters_per_s, t_high, t_low, all<V>(s.v_quarters_at_0), s.v_whole_quarters_at_0), sin_v,
                cos_v);
    sine_cosine(angle(s.rho_quarters_per_s, t_high, t_low, V{}), sin_rho, cos_rho);
    const V two_sin = sin_v + sin_v;
    const V cos_2v = multiply_add(-two_sin, sin_v, all<V>(1.0));
    const V sin_2v = two_sin * cos_v;
    attitude_and_momentum(s.frame, polynomial<Degree>(s.polynomial[0], cos_2v),
                          sin_2v * polynomial<Degree>(s.polynomial[1], cos_2v),
                          sin_v * polynomial<Degree>(s.polynomial[2], cos_2v),
                          cos_v * polynomial<Degree>(s.polynomial[3], cos_2v), sin_rho, cos_rho, q, m);
  }
};

template <int Degree>
struct HyperbolicAt {
  const HyperbolicChart& s;

  template <class V>
  [[gnu::always_inline]] void operator()(V t_high, V t_low, V (&q)[4], V (&m)[3]) const {
    // x: exact to its last place where e^{-|x|} is not small, since that is where the body turns over.
    const V rate = all<V>(s.x_per_s.high);
    const V product = t_high * rate;
    V rest = multiply_add(t_high, all<V>(s.x_per_s.low), product_error(t_high, rate, product));
    rest = multiply_add(t_low, rate, rest) + s.x_at_0.low;
    const Pair<V> sum = two_sum(product, all<V>(s.x_at_0.high));
    const V n = nearest_integer(sum.high * s.reciprocal_x_period);
    const V x = product_minus(-n, all<V>(s.x_period.high), -sum.high) +
                multiply_add(-n, all<V>(s.x_period.low), sum.low + rest);
    const auto side = bits(x);
    V e, y;
    exponentials(magnitude(x), s.root_of_nome, e, y);

    V sin_phase, cos_phase;
    sine_cosine(angle(s.rho_quarters_per_s, t_high, t_low, x * s.x_to_quarters), sin_phase, cos_phase);

    const auto parity = bits(n + all<V>(kMagic)) << 63;
    const V re_alpha = multiply_add(e, polynomial<Degree>(s.polynomial[4], e), polynomial<Degree>(s.polynomial[0], y));
    const V im_alpha = multiply_add(-e, polynomial<Degree>(s.polynomial[5], e), polynomial<Degree>(s.polynomial[1], y));
    const V re_beta = multiply_add(-e, polynomial<Degree>(s.polynomial[6], e), polynomial<Degree>(s.polynomial[2], y));
    const V im_beta = multiply_add(e, polynomial<Degree>(s.polynomial[7], e), polynomial<Degree>(s.polynomial[3], y));
    attitude_and_momentum(s.frame, re_alpha, flip(im_alpha, side), flip(re_beta, side ^ parity), flip(im_beta, parity),
                          sin_phase, cos_phase, q, m);
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

inline constexpr std::size_t kBlock = 128;               // instants whose results stay in the first cache
inline constexpr std::size_t kStreamedBytes = 4u << 20;  // results larger than this are written past the caches

/// Times whose parts do not overlap; `low` may be null.
inline Pair<Lanes> times(const double* high, const double* low) {
  if (low == nullptr) return {load<Lanes>(high), Lanes{}};
  return two_sum(load<Lanes>(high), load<Lanes>(low));
}

/// A block of rows, as structures or as separate arrays, each in its own aligned buffer or in the caller's arrays.
template <class At>
inline void block_of_structures(const At& at, const double* t_high, const double* t_low, std::size_t count, double* q,
                                double* m) {
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    Lanes qs[4], ms[3];
    const Pair<Lanes> t = times(t_high + i, t_low == nullptr ? nullptr : t_low + i);
    at(t.high, t.low, qs, ms);
    store_rows_of_4(q + 4 * i, qs);
    if (m != nullptr) store_rows_of_3(m + 3 * i, ms);
  }
  if (i == count) return;
  double high[kLanes] = {}, low[kLanes] = {}, rows_q[4 * kLanes], rows_m[3 * kLanes];
  std::memcpy(high, t_high + i, (count - i) * sizeof(double));
  if (t_low != nullptr) std::memcpy(low, t_low + i, (count - i) * sizeof(double));
  Lanes qs[4], ms[3];
  const Pair<Lanes> t = times(high, low);
  at(t.high, t.low, qs, ms);
  store_rows_of_4(rows_q, qs);
  std::memcpy(q + 4 * i, rows_q, (count - i) * 4 * sizeof(double));
  if (m == nullptr) return;
  store_rows_of_3(rows_m, ms);
  std::memcpy(m + 3 * i, rows_m, (count - i) * 3 * sizeof(double));
}

template <class At>
inline void block_of_arrays(const At& at, const double* t_high, const double* t_low, std::size_t count,
                            double (*q)[kBlock], double (*m)[kBlock]) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    const std::size_t here = count - i < kLanes ? count - i : kLanes;
    double high[kLanes] = {}, low[kLanes] = {};
    std::memcpy(high, t_high + i, here * sizeof(double));
    if (t_low != nullptr) std::memcpy(low, t_low + i, here * sizeof(double));
    Lanes qs[4], ms[3];
    const Pair<Lanes> t = times(high, low);
    at(t.high, t.low, qs, ms);
    for (int k = 0; k < 4; ++k) store(q[k] + i, qs[k]);
    for (int k = 0; k < 3; ++k) store(m[k] + i, ms[k]);
  }
}

inline bool rows_of_structures(double* const* p, int components, std::ptrdiff_t stride) {
  if (stride != components) return false;
  for (int k = 1; k < components; ++k) {
    if (p[k] != p[0] + k) return false;
  }
  return true;
}

template <class At>
inline void batch_with(const At& at, const BatchArguments& a) {
  const bool with_m = a.m[0] != nullptr;
  const bool streamed = a.count * (with_m ? 7 : 4) * sizeof(double) > kStreamedBytes;
  const bool structures = rows_of_structures(a.q, 4, a.q_stride) && (!with_m || rows_of_structures(a.m, 3, a.m_stride));
  if (structures && !streamed) {
    return block_of_structures(at, a.t_high, a.t_low, a.count, a.q[0], with_m ? a.m[0] : nullptr);
  }
  alignas(64) double buffer[7][kBlock];
  for (std::size_t i = 0; i < a.count; i += kBlock) {
    const std::size_t here = a.count - i < kBlock ? a.count - i : kBlock;
    const double* high = a.t_high + i;
    const double* low = a.t_low == nullptr ? nullptr : a.t_low + i;
    if (structures) {
      double* q = buffer[0];
      double* m = buffer[4];
      block_of_structures(at, high, low, here, q, with_m ? m : nullptr);
      copy_past_caches(a.q[0] + 4 * i, q, 4 * here);
      if (with_m) copy_past_caches(a.m[0] + 3 * i, m, 3 * here);
      continue;
    }
    block_of_arrays(at, high, low, here, buffer, buffer + 4);
    const auto spread = [&](double* to, std::ptrdiff_t stride, const double* from) {
      to += static_cast<std::ptrdiff_t>(i) * stride;
      if (stride == 1 && streamed) return copy_past_caches(to, from, here);
      if (stride == 1) return static_cast<void>(std::memcpy(to, from, here * sizeof(double)));
      for (std::size_t j = 0; j < here; ++j) to[static_cast<std::ptrdiff_t>(j) * stride] = from[j];
    };
    for (int k = 0; k < 4; ++k) spread(a.q[k], a.q_stride, buffer[k]);
    if (with_m) {
      for (int k = 0; k < 3; ++k) spread(a.m[k], a.m_stride, buffer[4 + k]);
    }
  }
  if (streamed) finish_streaming();
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
