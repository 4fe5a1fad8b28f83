#pragma once

// The partial derivatives at an instant (partials.md), for one time or for the lanes of a register. Branch-free but for
// the two ways of the second chart.

#include "polhode/motion/theta/kernel.hpp"
#include "polhode/motion/theta/partials.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

// Taylor series to 2^-60 for |x| <= 1: sinh x = x + x^3 tail(x^2), cosh x = 1 + x^2 tail(x^2).
inline constexpr double kSinhTail[] = {1.0 / 6.0,
                                       1.0 / 120.0,
                                       1.0 / 5040.0,
                                       1.0 / 362880.0,
                                       1.0 / 39916800.0,
                                       1.0 / 6227020800.0,
                                       1.0 / 1307674368000.0,
                                       1.0 / 355687428096000.0,
                                       1.0 / 121645100408832000.0};
inline constexpr double kCoshTail[] = {1.0 / 2.0,
                                       1.0 / 24.0,
                                       1.0 / 720.0,
                                       1.0 / 40320.0,
                                       1.0 / 3628800.0,
                                       1.0 / 479001600.0,
                                       1.0 / 87178291200.0,
                                       1.0 / 20922789888000.0,
                                       1.0 / 6402373705728000.0};

/// yes where a < limit, else no.
inline double where_below(double a, double limit, double yes, double no) { return a < limit ? yes : no; }
inline Lanes where_below(Lanes a, double limit, Lanes yes, Lanes no) {
  const LaneBits mask = a < all<Lanes>(limit);
  return value<Lanes>((bits(yes) & mask) | (bits(no) & ~mask));
}
inline bool any_below(double a, double limit) { return a < limit; }
inline bool any_below(Lanes a, double limit) { return any_above(-a, -limit); }  // NaN counts, the limit too

/// c - a b
template <class V>
inline V minus_product(V a, V b, V c) {
  return multiply_add(-a, b, c);
}

/// What the six columns need of an instant, by component: m_k = m_k(0) c_k + (dm_k/dt)(0) sigma_k, and R_k; and m_k
/// itself, to the last digits of each component even where the others are far larger.
template <class V>
struct Fundamental {
  V m[3], sigma[3], c[3], r[3];
};

/// The functions of Delta alone.
template <class V>
struct DeltaFunctions {
  V delta, s, c, d;  // sn, cn, dn
  V one_minus_c, one_minus_d;
  V delta_minus_s, xi, psi;  // the last: of third order, xi = integral of sn^2, psi = dn times that of (sn/dn)^2
};

/// From the functions of Delta to what the columns need; t and the momentum m2 in our units, canonical axes.
template <class V>
[[gnu::always_inline]] inline void by_addition(const AdditionConstants& a, const DeltaFunctions<V>& f, V t, V m2,
                                               Fundamental<V>& out) {
  const V k2 = all<V>(a.k2), reciprocal = all<V>(a.reciprocal_lambda);
  const V one_minus_cd = multiply_add(f.c, f.one_minus_d, f.one_minus_c);
  const V k2_psi = k2 * f.psi;
  const V upsilon = (minus_product(k2_psi, f.c, f.delta * one_minus_cd) - f.delta_minus_s) / f.d;
  const V first = multiply_add(f.c, f.delta, upsilon);  // cn times the integral of 1/cn^2
  const V third = multiply_add(f.d, f.delta, k2_psi);   // dn times the integral of 1/dn^2
  const V g = m2 * a.g0, h = m2 * a.g1, gs = g * f.s;
  out.sigma[0] = multiply_add(g, f.psi, first) * reciprocal;
  out.sigma[1] = multiply_add(g, f.xi, f.s) * reciprocal;
  out.sigma[2] = multiply_add(g, upsilon, third) * reciprocal;
  out.c[0] = minus_product(h, f.psi, multiply_add(gs, first, multiply_add(f.s, k2_psi, f.c)));
  out.c[1] = minus_product(h, f.xi, multiply_add(gs, f.s, f.c * f.d));
  out.c[2] = minus_product(h, upsilon, multiply_add(gs, third, multiply_add(f.s, k2 * upsilon, f.d)));
  const V s = f.s * reciprocal, s2 = s * s;
  const V e = s2 * a.e;
  const V reciprocal_e = 1.0 / (1.0 - e), t_over = t * reciprocal_e;
  out.m[2] = multiply_add(f.d, all<V>(a.m3), s * f.c * a.n3) * reciprocal_e;
  const V r1 = multiply_add(s2 * a.r1_c, f.c, f.d * s * a.r1_d);
  const V r2 = multiply_add(e - one_minus_cd, all<V>(a.r2_cd), s * a.r2_s);
  const V r3 = multiply_add(s2 * a.r3_d, f.d, f.c * s * a.r3_c);
  out.r[0] = minus_product(multiply_add(g, f.psi, upsilon), all<V>(a.r1_periodic), r1 * t_over);
  out.r[1] = multiply_add(minus_product(g, f.xi, f.delta_minus_s), all<V>(a.r2_periodic), r2 * t_over);
  out.r[2] = multiply_add(r3, t_over, minus_product(m2 * a.r3_upsilon, upsilon, f.psi * a.r3_psi));
}

struct FixedAxisPartialsAt {
  const PartialsSolution& p;

  template <class V>
  [[gnu::always_inline]] void operator()(V t_high, V t_low, V t, const V (&m)[3], Fundamental<V>& out) const {
    const FixedAxisPartials& f = p.fixed_axis;
    V sigma = t, c = all<V>(1.0);
    if (f.kind == FixedAxisPartials::Kind::circular) {
      sine_cosine(angle(f.rate_per_s, t_high, t_low, V{}), sigma, c);
      sigma = sigma * f.reciprocal_rate;
    } else if (f.kind == FixedAxisPartials::Kind::hyperbolic) {
      const V rate = all<V>(f.rate_per_s.high);
      const V x = t_high * rate;
      const V rest =
          multiply_add(t_low, rate, multiply_add(t_high, all<V>(f.rate_per_s.low), product_error(t_high, rate, x)));
      const V size = smaller(magnitude(x), all<V>(300.0)), x2 = x * x;
      V falling, growing;
      exponentials(size, 1.0, falling, growing);
      const V sinh = flip((growing - falling) * 0.5, bits(x));
      c = (growing + falling) * 0.5;
      sigma = where_below(size, 1.0, multiply_add(x * x2, polynomial<8>(kSinhTail, x2), x), sinh);
      // e^(x + rest), rest below 2^-53 x
      const V turned = multiply_add(c, rest, sigma);
      c = multiply_add(sigma, rest, c);
      sigma = turned * f.reciprocal_rate;
    }
    for (int k = 0; k < 3; ++k) {
      out.m[k] = m[k];
      out.sigma[k] = f.varies[k] ? sigma : t;
      out.c[k] = f.varies[k] ? c : all<V>(1.0);
      out.r[k] = t * t * f.products[k];
    }
  }
};

struct FourierPartialsAt {
  const PartialsSolution& p;

  template <class V>
  [[gnu::always_inline]] void operator()(V t_high, V t_low, V /*t*/, const V (&m)[3], Fundamental<V>& out) const {
    const FourierPartials& s = p.fourier;
    // v = v_r + n pi, -pi/4 <= v_r <= 3 pi/4
    const Angle<V> total = angle(s.quarters_per_s, t_high, t_low, V{});
    V sine, cosine;
    sine_cosine(Angle<V>{total.y, total.quarter & 1}, sine, cosine);
    const V quarters = choose(total.quarter, total.y, total.y + 1.0);
    const V n = nearest_integer(multiply_add(t_high, all<V>(s.quarters_per_s.high), -quarters) * 0.5);
    const auto parity = total.quarter << 62;
    const V v = quarters * kHalfPiHigh, u = total.y * total.y;
    // v - sin v, small where v is: y^3 times the tail of the sine's polynomial
    const V small = -(total.y * u) * polynomial_of_degree_5(kSineTail, u);
    const V v_minus_sine = where_below(quarters, 0.5, small, v - sine);
    const V s2 = sine * sine, size_of_cosine = magnitude(cosine);
    const V one_minus_cosine = where_below(-cosine, 0.0, s2 / (1.0 + size_of_cosine), 1.0 + size_of_cosine);
    V tail[5];
    for (int i = 0; i < 5; ++i) tail[i] = all<V>(s.polynomial[3][i]);
    for (int power = 2; power >= 0; --power) {
      for (int i = 0; i < 5; ++i) tail[i] = multiply_add(tail[i], s2, all<V>(s.polynomial[power][i]));
    }
    const V vt = v * tail[0];
    const V reciprocal = 1.0 / multiply_add(s2, tail[0], all<V>(1.0));
    DeltaFunctions<V> f;
    const V by_delta = reciprocal * s.delta_per_v;
    f.delta = v * s.delta_per_v;
    f.s = multiply_add(s2 * sine, tail[1], sine) * by_delta;
    f.c = multiply_add(s2 * cosine, tail[2], cosine) * reciprocal;
    f.d = multiply_add(s2, tail[3], all<V>(1.0)) * reciprocal;
    f.one_minus_c = multiply_add(s2, minus_product(cosine, tail[2], tail[0]), one_minus_cosine) * reciprocal;
    f.one_minus_d = s2 * (tail[0] - tail[3]) * reciprocal;
    f.delta_minus_s = multiply_add(s2, minus_product(sine, tail[1], vt), v_minus_sine) * by_delta;
    const V v_minus_sc = multiply_add(sine, one_minus_cosine, v_minus_sine);
    f.xi = multiply_add(s2, minus_product(sine * cosine, tail[4], vt), v_minus_sc) * reciprocal * s.xi_scale;
    const V d_minus_c = f.one_minus_c - f.one_minus_d;
    f.psi = minus_product(f.d, f.xi, multiply_add(f.d, f.delta_minus_s, f.s * d_minus_c)) * s.addition.reciprocal_kp2;
    const V m2 = m[1] * p.sign[1];
    by_addition(s.addition, f, f.delta * s.addition.reciprocal_lambda, flip(m2, parity), out);
    out.m[0] = m[p.exchange_1_3 ? 2 : 0] * p.sign[0];
    out.m[1] = m2;
    for (int k = 0; k < 3; ++k) {
      if (k != 2) {
        out.sigma[k] = flip(out.sigma[k], parity);
        out.c[k] = flip(out.c[k], parity);
        out.r[k] = flip(out.r[k], parity);
      }
      const V nm = n * out.m[k];
      out.sigma[k] = multiply_add(nm, all<V>(s.period_sigma[k]), out.sigma[k]);
      out.c[k] = multiply_add(nm, all<V>(s.period_c[k]), out.c[k]);
      out.r[k] = multiply_add(nm, all<V>(s.period_r[k]), out.r[k]);
    }
  }
};

struct HyperbolicPartialsAt {
  const PartialsSolution& p;
  const HyperbolicChart& chart;

  /// |x| <= 1, x = pi Delta / (2 K').
  template <class V>
  [[gnu::always_inline]] void beside_0(V x, V t, const V (&m)[3], Fundamental<V>& out) const {
    const HyperbolicPartials& h = p.hyperbolic;
    const V x2 = x * x;
    const V sinh_minus_x = x * x2 * polynomial<8>(kSinhTail, x2), cosh_minus_1 = x2 * polynomial<8>(kCoshTail, x2);
    const V sinh = x + sinh_minus_x, cosh = 1.0 + cosh_minus_1, s2 = sinh * sinh;
    const V t4 = multiply_add(s2, all<V>(h.theta4[1]), all<V>(h.theta4[0]));
    const V t3 = multiply_add(s2, all<V>(h.theta3[1]), all<V>(h.theta3[0]));
    const V x_cosh = x * cosh_minus_1, cosh1 = cosh * h.cosh1;
    const V reciprocal = 1.0 / multiply_add(s2, cosh1, cosh);
    DeltaFunctions<V> f;
    f.delta = x * h.delta_per_x;
    f.s = multiply_add(s2 * sinh, all<V>(h.sinh1), sinh) * reciprocal * h.delta_per_x;
    f.c = multiply_add(s2, t4, all<V>(1.0)) * reciprocal;
    f.d = multiply_add(s2, t3, all<V>(1.0)) * reciprocal;
    f.one_minus_c = multiply_add(s2, cosh1 - t4, cosh_minus_1) * reciprocal;
    f.one_minus_d = multiply_add(s2, cosh1 - t3, cosh_minus_1) * reciprocal;
    f.delta_minus_s = multiply_add(s2, minus_product(sinh, all<V>(h.sinh1), x * cosh1), x_cosh - sinh_minus_x) *
                      reciprocal * h.delta_per_x;
    f.psi = multiply_add(s2, minus_product(x, t3, sinh * cosh * h.integral1),
                         multiply_add(sinh, cosh_minus_1, sinh_minus_x)) *
            reciprocal * (h.psi_scale * h.addition.reciprocal_k2);
    const V d_minus_c = f.one_minus_c - f.one_minus_d;
    f.xi = minus_product(f.psi, all<V>(h.addition.kp2), multiply_add(f.d, f.delta_minus_s, f.s * d_minus_c)) / f.d;
    by_addition(h.addition, f, t, m[1] * p.sign[1], out);
    out.m[0] = multiply_add(out.sigma[0], all<V>(h.n1), out.c[0] * h.m[0]);
    out.m[1] = m[1] * p.sign[1];
    out.c[0] = multiply_add(out.sigma[0], all<V>(h.growth[0]), out.c[0]);
    out.c[2] = multiply_add(out.sigma[2], all<V>(h.growth[1]), out.c[2]);
  }

  /// Elsewhere, x(t) reduced by n periods; the highest bit of `parity` says whether n is odd.
  template <class V>
  [[gnu::always_inline]] void elsewhere(V x, V n, typename BitsOf<V>::type parity, V t, const V (&m)[3],
                                        Fundamental<V>& out) const {
    const HyperbolicPartials& h = p.hyperbolic;
    V e, y;
    exponentials(magnitude(x), chart.root_of_nome, e, y);
    const V e2 = e * e, e4 = e2 * e2, e8 = e4 * e4, y2 = y * y, q2y2 = y2 * h.nome2;
    const V numerator = multiply_add(q2y2 * 2.0, 1.0 - e8, 1.0 - e4);
    const V once = y2 * (1.0 + e4), twice = q2y2 * y2 * (1.0 + e8);
    const V theta3 = 1.0 + once + twice, theta4 = 1.0 - once + twice;
    const V over_theta2 = 1.0 / (1.0 + e2 + y2 * h.nome * multiply_add(e4, e2, all<V>(1.0)));
    // cn and dn from their series, and over e: of the state's small components only the absolute error is small
    const V cn_e = flip(theta4 * over_theta2 * h.cn_scale, parity), dn_e = theta3 * over_theta2 * h.dn_scale;
    const V cn = cn_e * e, dn = dn_e * e, sn = m[1] * p.sign[1] * h.reciprocal_b23;
    out.m[0] = cn * h.b13;
    out.m[1] = m[1] * p.sign[1];
    out.m[2] = dn * h.b31;
    const V over_e = 1.0 / e;
    const V e_m = flip(over_e * 0.5 * (numerator / theta3), bits(x));  // e M(x)
    // j is e e0 times the integral of 1/dn^2 from w(0) to w(t)
    const V delta = t * h.addition.lambda, ee = e * h.e0;
    const V change = multiply_add(e_m, all<V>(h.e0), multiply_add(n * h.jump, e * h.reciprocal_root, -h.e0_m0 * e));
    const V j = multiply_add(delta * h.s0, ee, change * h.s1);
    const V rest = multiply_add(delta, ee, -j);
    const V cn_over_dn = cn_e / dn_e, sn_over_dn = sn / dn;
    const V k2 = all<V>(h.addition.k2);
    // k^2 times the integral of sn^2
    const V sine2 =
        multiply_add(-k2, multiply_add(sn, cn_over_dn, all<V>(-h.sn_cn_dn)), minus_product(y * h.kp2_scale, j, delta));
    const V sigma1 = multiply_add(h.cn_e * cn_e, rest, minus_product(cn, all<V>(h.sn / h.dn), sn_over_dn * h.cn));
    const V sigma2 = multiply_add(sn * h.sn, sine2, minus_product(cn * dn, all<V>(h.sn), sn * (h.cn * h.dn)));
    const V sigma3 = h.dn_e * dn_e * j;
    out.c[0] = h.by_ratio ? cn_e * (1.0 / h.cn_e) * (e * (1.0 / h.e0))
                          : multiply_add(cn_e * (h.sn * h.dn_e), rest,
                                         multiply_add(sn_over_dn, all<V>(h.sn * h.dn), cn * h.cn));
    out.c[1] = multiply_add(sn, h.sn * (1.0 + k2 * (h.cn * h.cn)), (h.cn * h.dn) * minus_product(sn, sine2, cn * dn));
    out.c[2] = dn * (1.0 / h.dn);
    const V sigma[3] = {sigma1, sigma2, sigma3};
    for (int k = 0; k < 3; ++k) {
      out.sigma[k] = sigma[k] * h.addition.reciprocal_lambda;
      out.r[k] = minus_product(sigma[k], all<V>(h.m[k]), out.m[k] * delta) * h.reciprocal_kappa_lambda[k];
    }
  }

  template <class V>
  [[gnu::always_inline]] void operator()(V t_high, V t_low, V t, const V (&m)[3], Fundamental<V>& out) const {
    constexpr double near = 1.0;
    const V from_0 = t_high * chart.x_per_s.high, size = magnitude(from_0);
    Fundamental<V> beside;
    const bool some_near = any_below(size, near);
    if (some_near) beside_0(from_0, t, m, beside);
    if (any_above(size, near)) {
      const auto [x, odd] = HyperbolicAt<0>{chart}.position(t_high, t_low);
      const V whole = multiply_add(t_high, all<V>(chart.x_per_s.high), all<V>(chart.x_at_0.high)) - x;
      const V n = nearest_integer(whole * chart.reciprocal_x_period);
      elsewhere(x, n, bits(odd + all<V>(kMagic)) << 63, t, m, out);
      if (some_near) {
        for (int k = 0; k < 3; ++k) {
          out.m[k] = where_below(size, near, beside.m[k], out.m[k]);
          out.sigma[k] = where_below(size, near, beside.sigma[k], out.sigma[k]);
          out.c[k] = where_below(size, near, beside.c[k], out.c[k]);
          out.r[k] = where_below(size, near, beside.r[k], out.r[k]);
        }
      }
    } else {
      out = beside;
    }
  }
};

/// The matrix, row by row, from the state and the fundamental functions.
template <class V>
[[gnu::always_inline]] inline void matrix(const PartialsSolution& p, V t, const V (&q)[4], const V (&m)[3],
                                          const Fundamental<V>& canonical, V (&out)[54]) {
  const PartialsFrame& f = p.frame;
  // The body's turn from t to 0 as a matrix: components at 0 to components at t. w + u_1 i + ... = conj(q) q0
  const V w = multiply_add(q[0], all<V>(f.q0[0]),
                           multiply_add(q[1], all<V>(f.q0[1]), multiply_add(q[2], all<V>(f.q0[2]), q[3] * f.q0[3])));
  V u[3];
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3 + 1, j = (k + 2) % 3 + 1;
    u[k] = multiply_add(q[0], all<V>(f.q0[k + 1]),
                        minus_product(q[k + 1], all<V>(f.q0[0]), minus_product(q[i], all<V>(f.q0[j]), q[j] * f.q0[i])));
  }
  V turn[3][3];
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    turn[k][k] = multiply_add(u[i] * -2.0, u[i], multiply_add(u[j] * -2.0, u[j], all<V>(1.0)));
    const V wj = w * u[j] * 2.0, twice = u[k] * 2.0;
    turn[k][i] = multiply_add(twice, u[i], -wj);
    turn[i][k] = multiply_add(twice, u[i], wj);
  }
  V theta[3][6];
  for (int k = 0; k < 3; ++k) {
    const int own = k == 1 || !p.exchange_1_3 ? k : 2 - k;
    const V tm = t * canonical.m[own], c = canonical.c[own], sigma = canonical.sigma[own], r = canonical.r[own];
    for (int column = 0; column < 6; ++column) {
      V sum = r * f.of_r[k][column];
      sum = multiply_add(sigma, all<V>(f.of_sigma[k][column]), sum);
      if (column < 3) {
        sum = multiply_add(c, all<V>(f.of_c[k][column]), sum);
        for (int i = 0; i < 3; ++i) sum = multiply_add(turn[k][i], all<V>(f.turn[i][column]), sum);
      }
      theta[k][column] = multiply_add(tm, all<V>(f.of_tm[k][column]), sum);
    }
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    for (int l = 0; l < 3; ++l) {
      out[9 * k + l] = turn[k][l];
      out[9 * (k + 3) + l] = V{};
    }
    for (int column = 0; column < 6; ++column) {
      out[9 * k + 3 + column] = theta[k][column];
      // dm = (turn of dm at 0) - theta x m
      V dm = minus_product(theta[i][column], m[j], theta[j][column] * m[i]);
      if (column < 3) dm = dm + turn[k][column];
      out[9 * (k + 3) + 3 + column] = dm;
    }
  }
}

/// The matrix that belongs to a state, at one time or at lanes. Not inlined: once for each chart, not for each degree.
template <class V, class PartialsAt>
[[gnu::noinline]] void matrix_of_state(const PartialsAt& partials_at, V t_high, V t_low, const V (&q)[4],
                                       const V (&m)[3], V (&out)[54]) {
  const PartialsSolution& p = partials_at.p;
  const V t = (t_high + t_low) * p.frame.time_scale;
  const V m_ours[3] = {m[0] * p.frame.momentum_scale, m[1] * p.frame.momentum_scale, m[2] * p.frame.momentum_scale};
  Fundamental<V> f;
  partials_at(t_high, t_low, t, m_ours, f);
  matrix(p, t, q, m, f, out);
}

template <class V, class At, class PartialsAt>
[[gnu::always_inline]] inline void state_and_matrix(const At& at, const PartialsAt& partials_at, V t_high, V t_low,
                                                    V (&q)[4], V (&m)[3], V (&out)[54]) {
  at.state(at.phases(t_high, t_low), q, m);
  matrix_of_state(partials_at, t_high, t_low, q, m, out);
}

/// Calls `with` with the evaluations of the state and of the partials.
template <class With>
inline void dispatch(const Solution& s, const PartialsSolution& p, const With& with) {
  dispatch(s, [&]<class At>(const At& at) {
    if constexpr (requires { at.s.quarters_per_s; }) {
      with(at, FixedAxisPartialsAt{p});
    } else if constexpr (requires { at.s.polynomial; }) {
      with(at, FourierPartialsAt{p});
    } else {
      with(at, HyperbolicPartialsAt{p, at.s});
    }
  });
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
