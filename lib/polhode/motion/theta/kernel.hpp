#pragma once

// The answer at an instant (theta.md, "The answer"), for one time or for the lanes of a register. Branch-free.

#include "polhode/motion/theta/lanes.hpp"
#include "polhode/motion/theta/series.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

// Minimax polynomials, from coefficients.py.
// sin(pi/2 y) = pi/2 y + y^3 tail(y^2), |y| <= 1/2: largest error 2^-59.1
inline constexpr double kSineTail[] = {-0x1.4abbce625be3cp-1, 0x1.466bc67757d6ep-4,   -0x1.32d2cce22faa2p-8,
                                       0x1.50782f2e14219p-13, -0x1.e2ffdca8dc14fp-19, 0x1.e3c30b19464c1p-25};
// cos(pi/2 y) = 1 - pi^2/8 y^2 + y^4 tail(y^2): 2^-64.2
inline constexpr double kCosineTail[] = {0x1.03c1f081b5abcp-2,  -0x1.55d3c7e3ca6fbp-6, 0x1.e1f50685288bfp-11,
                                         -0x1.a6d1edbb37a86p-16, 0x1.f9cd20250ea8dp-22, -0x1.b2a1e7f755ab8p-28};
// e^x = 1 + x + x^2 tail(x), |x| <= ln2/2: 2^-58.0
inline constexpr double kExponentialTail[] = {0x1.000000000000cp-1,  0x1.5555555555561p-3,  0x1.555555554ff93p-5,
                                              0x1.111111110d5d5p-7,  0x1.6c16c185ca91bp-10, 0x1.a01a01bb0421ep-13,
                                              0x1.a019963161049p-16, 0x1.71dddf8048f86p-19, 0x1.28b0a67d70361p-22,
                                              0x1.af85ff7415c79p-26};
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

/// rate t + offset in two parts, whole units removed from the largest term.
template <class V>
inline Pair<V> turns(const TwoPart& rate, V t_high, V t_low, V offset_high, V offset_low) {
  const V f = all<V>(rate.high);
  const V product = t_high * f;
  const V fraction = product - nearest_integer(product);
  V rest = multiply_add(t_high, all<V>(rate.low), product_error(t_high, f, product));
  rest = multiply_add(t_low, f, rest);
  rest = rest - nearest_integer(rest);
  const Pair<V> sum = two_sum(fraction, offset_high);
  const V low = sum.low + (rest + offset_low);
  const V high = sum.high + low;
  return {high, (sum.high - high) + low};
}

/// sin and cos of 2 pi (high + low), |high| <= 2; absolute error below 0.6 2^-53.
template <class V>
inline void sine_cosine(const Pair<V>& x, V& sine, V& cosine) {
  const V magic = all<V>(kMagic);
  const V shifted = multiply_add(x.high, all<V>(4.0), magic);
  const V quarter = shifted - magic;
  const V y = multiply_add(x.high, all<V>(4.0), -quarter);
  const V h = all<V>(kHalfPiHigh);
  const V low = x.low * (4.0 * kHalfPiHigh);
  const V a = y * h;
  const V u = y * y;
  V s = multiply_add(y, all<V>(kHalfPiLow), low) + product_error(y, h, a);
  s = a + multiply_add(y * u, polynomial<5>(kSineTail, u), s);
  V c = multiply_add(u * u, polynomial<5>(kCosineTail, u), -low * a);
  c = 1.0 + multiply_add(u, all<V>(-kEighthPi2), c);
  const auto q = bits(shifted);
  sine = flip(choose(q, s, c), q << 62);
  cosine = flip(choose(q, c, s), (q + 1) << 62);
}

/// e^{-(high + low)} for high >= 0; relative error below 2^-52; never below e^-700.
template <class V>
inline V negative_exponential(const Pair<V>& a) {
  const V argument = smaller(a.high, all<V>(700.0));
  const V magic = all<V>(kMagic);
  const V shifted = multiply_add(argument, all<V>(-0x1.71547652b82fep+0), magic);  // -1/ln 2
  const V k = shifted - magic;
  V r = multiply_add(k, all<V>(-0x1.62e42fefap-1), -argument);  // exact: the constant has 33 bits
  r = multiply_add(k, all<V>(-0x1.cf79abc9e3b3ap-40), r) - a.low;
  const V e = 1.0 + multiply_add(r * r, polynomial<9>(kExponentialTail, r), r);
  return value<V>(bits(e) + (bits(shifted) << 52));
}

/// Attitude and momentum (times its scale) from alpha and beta, one of them of size near 1, and the phase of rho t.
template <class V>
inline void attitude_and_momentum(const Frame& f, V re_alpha, V im_alpha, V re_beta, V im_beta, V sine, V cosine,
                                  V (&q)[4], V (&m)[3]) {
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
  const V c = cosine * scale, s = sine * scale;
  const V e0 = multiply_add(re_alpha, c, -im_alpha * s);
  const V e1 = multiply_add(re_beta, c, -im_beta * s);
  const V e2 = multiply_add(re_beta, s, im_beta * c);
  const V e3 = multiply_add(re_alpha, s, im_alpha * c);
  for (int k = 0; k < 4; ++k) {
    const double* row = f.frame[k];
    q[k] = multiply_add(all<V>(row[3]), e3,
                        multiply_add(all<V>(row[2]), e2, multiply_add(all<V>(row[1]), e1, row[0] * e0)));
  }
}

struct FixedAxisAt {
  const FixedAxis& s;

  template <class V>
  void operator()(V t_high, V t_low, V (&q)[4], V (&m)[3]) const {
    V sine, cosine;
    sine_cosine(turns(s.turns_per_s, t_high, t_low, V{}, V{}), sine, cosine);
    for (int k = 0; k < 4; ++k) q[k] = multiply_add(all<V>(s.sine[k]), sine, s.cosine[k] * cosine);
    for (int k = 0; k < 3; ++k) m[k] = all<V>(s.momentum[k]);
  }
};

template <int Degree>
struct FourierAt {
  const FourierChart& s;

  template <class V>
  void operator()(V t_high, V t_low, V (&q)[4], V (&m)[3]) const {
    V sin_v, cos_v, sin_rho, cos_rho;
    sine_cosine(turns(s.v_turns_per_s, t_high, t_low, all<V>(s.v_turns_at_0.high), all<V>(s.v_turns_at_0.low)), sin_v,
                cos_v);
    sine_cosine(turns(s.rho_turns_per_s, t_high, t_low, V{}, V{}), sin_rho, cos_rho);
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
  void operator()(V t_high, V t_low, V (&q)[4], V (&m)[3]) const {
    // x, reduced by n periods
    const V rate = all<V>(s.x_per_s.high), period = all<V>(s.x_period.high);
    const V product = t_high * rate;
    V rest = multiply_add(t_high, all<V>(s.x_per_s.low), product_error(t_high, rate, product));
    rest = multiply_add(t_low, rate, rest);
    Pair<V> x = two_sum(product, all<V>(s.x_at_0.high));
    x.low = x.low + (rest + s.x_at_0.low);
    const V n = nearest_integer(x.high * s.reciprocal_x_period);
    const V whole = n * period;
    const V lost = multiply_add(n, all<V>(s.x_period.low), product_error(n, period, whole));
    const V difference = x.high - whole;  // exact, or n = 0
    x.low = x.low - lost;
    const V reduced = difference + x.low;
    x = {reduced, (difference - reduced) + x.low};

    // E and Y, the larger of them by an exponential: E Y = Q.
    const auto side = bits(x.high);
    const Pair<V> from_0{magnitude(x.high), flip(x.low, side)};
    const V half = all<V>(0.5 * s.x_period.high);
    const V other_side = half - from_0.high;
    const Pair<V> from_end{other_side, ((half - other_side) - from_0.high) + (0.5 * s.x_period.low - from_0.low)};
    const auto near_end = bits(from_end.high - from_0.high) >> 63;  // lowest bit set where nearer to the end
    const V larger_one = negative_exponential<V>(
        {larger(choose(near_end, from_0.high, from_end.high), V{}), choose(near_end, from_0.low, from_end.low)});
    const V smaller_one = s.root_of_nome_bound / larger_one;
    const V e = choose(near_end, larger_one, smaller_one);
    const V y = choose(near_end, smaller_one, larger_one);

    V sin_phase, cos_phase;
    const V k = all<V>(s.x_to_turns);
    const V phase = x.high * k;
    const V phase_low = multiply_add(x.low, k, product_error(x.high, k, phase));
    sine_cosine(turns(s.rho_turns_per_s, t_high, t_low, phase, phase_low), sin_phase, cos_phase);

    const auto parity = bits(multiply_add(n, all<V>(1.0), all<V>(kMagic))) << 63;
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
    case Chart::fixed_axis: return with(FixedAxisAt{s.fixed_axis});
    case Chart::fourier:
      switch (s.fourier.degree) {
        case 0: return with(FourierAt<0>{s.fourier});
        case 1: return with(FourierAt<1>{s.fourier});
        case 2: return with(FourierAt<2>{s.fourier});
        default: return with(FourierAt<3>{s.fourier});
      }
    case Chart::hyperbolic:
      switch (s.hyperbolic.degree) {
        case 0: return with(HyperbolicAt<0>{s.hyperbolic});
        case 1: return with(HyperbolicAt<1>{s.hyperbolic});
        case 2: return with(HyperbolicAt<2>{s.hyperbolic});
        default: return with(HyperbolicAt<3>{s.hyperbolic});
      }
  }
}

inline constexpr std::size_t kBlock = 512;                  // instants whose results stay in the first cache
inline constexpr std::size_t kStreamedBytes = 4u << 20;     // results larger than this are written past the caches

/// A block of rows, as structures or as separate arrays, each in its own aligned buffer or in the caller's arrays.
template <class At>
inline void block_of_structures(const At& at, const double* t_high, const double* t_low, std::size_t count, double* q,
                                double* m) {
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    Lanes qs[4], ms[3];
    at(load<Lanes>(t_high + i), t_low == nullptr ? Lanes{} : load<Lanes>(t_low + i), qs, ms);
    store_rows_of_4(q + 4 * i, qs);
    if (m != nullptr) store_rows_of_3(m + 3 * i, ms);
  }
  if (i == count) return;
  double high[kLanes] = {}, low[kLanes] = {}, rows_q[4 * kLanes], rows_m[3 * kLanes];
  std::memcpy(high, t_high + i, (count - i) * sizeof(double));
  if (t_low != nullptr) std::memcpy(low, t_low + i, (count - i) * sizeof(double));
  Lanes qs[4], ms[3];
  at(load<Lanes>(high), load<Lanes>(low), qs, ms);
  store_rows_of_4(rows_q, qs);
  std::memcpy(q + 4 * i, rows_q, (count - i) * 4 * sizeof(double));
  if (m == nullptr) return;
  store_rows_of_3(rows_m, ms);
  std::memcpy(m + 3 * i, rows_m, (count - i) * 3 * sizeof(double));
}

template <class At>
inline void block_of_arrays(const At& at, const double* t_high, const double* t_low, std::size_t count, double (*q)[kBlock],
                            double (*m)[kBlock]) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    const std::size_t here = count - i < kLanes ? count - i : kLanes;
    double high[kLanes] = {}, low[kLanes] = {};
    std::memcpy(high, t_high + i, here * sizeof(double));
    if (t_low != nullptr) std::memcpy(low, t_low + i, here * sizeof(double));
    Lanes qs[4], ms[3];
    at(load<Lanes>(high), load<Lanes>(low), qs, ms);
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
  const bool structures =
      rows_of_structures(a.q, 4, a.q_stride) && (!with_m || rows_of_structures(a.m, 3, a.m_stride));
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
