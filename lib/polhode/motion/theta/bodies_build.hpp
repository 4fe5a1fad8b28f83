#pragma once

// From many bodies at t = 0 to the constants of their motions, lanes are bodies. No branch, no iteration whose length
// depends on the numbers: a lane's result does not depend on its neighbours. Formulas: theta.md, "Many bodies".

#include "polhode/motion/theta/bodies.hpp"
#include "polhode/motion/theta/kernel.hpp"
#include "polhode/motion/theta/lanes_double_double.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes b) { return where(a < b, b, a); }

/// 2^-e of numbers 2^e to 2^(e+1), and where they are neither tiny nor huge.
struct PowerOfTwo {
  Lanes reciprocal, value;
  LaneBits usual;
};
[[gnu::always_inline]] inline PowerOfTwo power_of_two(Lanes size) {
  const LaneBits exponent = bits(size) >> 52;
  return {value<Lanes>((2046 - exponent) << 52), value<Lanes>(exponent << 52),
          (size > all<Lanes>(0x1p-400)) & (size < all<Lanes>(0x1p400))};
}

/// Momentum and moments in canonical axes, with what the constants are made of. Products of the three moments stand in
/// for quotients: d1, d2, d3 are |Delta_j| I1 I2 I3.
template <class Real>
struct CanonicalLanes {
  Lanes i1, i2, i3, m1, m2, m3;
  LaneBits long_axis_mode;
  LaneBits sign[3];  // in the highest bit
  Real j21, j31, j32, i12, i13, i23, i123, d1, d2, d3, g;
};

template <class Real>
[[gnu::always_inline]] inline CanonicalLanes<Real> canonical_lanes(const Lanes (&i)[3], const Lanes (&m)[3]) {
  using N = LaneNumbers<Real>;
  CanonicalLanes<Real> c;
  const Real i21 = N::sum(i[1], -i[0]), i31 = N::sum(i[2], -i[0]), i32 = N::sum(i[2], -i[1]);
  const Real d2 = N::product(m[2], m[2]) * i32 * i[0] - N::product(m[0], m[0]) * i21 * i[2];
  const LaneBits longs = N::high(d2) < 0.0;
  c.long_axis_mode = longs;
  c.d2 = where(longs, -d2, d2) * i[1];
  c.i1 = where(longs, i[2], i[0]), c.i2 = i[1], c.i3 = where(longs, i[0], i[2]);
  c.j21 = where(longs, i32, i21), c.j31 = i31, c.j32 = where(longs, i21, i32);
  // e1' = e3, e2' = -e2, e3' = e1; then by pi about e1 where m3 < 0, and about e3 where m1 < 0 still.
  const Lanes m1 = where(longs, m[2], m[0]), m3 = where(longs, m[0], m[2]);
  const LaneBits about_1 = m3 < 0.0, about_3 = m1 < 0.0;
  c.sign[0] = about_3;
  c.sign[1] = longs ^ about_1 ^ about_3;
  c.sign[2] = about_1;
  c.m1 = flip(m1, c.sign[0]), c.m2 = flip(m[1], c.sign[1]), c.m3 = flip(m3, c.sign[2]);

  const Real q1 = N::product(c.m1, c.m1), q2 = N::product(c.m2, c.m2), q3 = N::product(c.m3, c.m3);
  c.i12 = N::product(c.i1, c.i2), c.i13 = N::product(c.i1, c.i3), c.i23 = N::product(c.i2, c.i3);
  c.i123 = c.i12 * c.i3;
  c.d1 = q2 * c.j21 * c.i13 + q3 * c.j31 * c.i12;
  c.d3 = q1 * c.j31 * c.i23 + q2 * c.j32 * c.i13;
  c.g = N::root(q1 + q2 + q3);
  return c;
}

/// R_F of the roots x from 0, y from 1/6, and 1: three steps of duplication, relative error below 1e-12.
[[gnu::always_inline]] inline Lanes rf_of_roots(Lanes x, Lanes y) {
  Lanes z = all<Lanes>(1.0);
  Lanes xx = x * x, yy = y * y, zz = z;
  for (int step = 0; step < 3; ++step) {
    const Lanes lambda = x * y + y * z + z * x;
    xx = (xx + lambda) * 0.25, yy = (yy + lambda) * 0.25, zz = (zz + lambda) * 0.25;
    x = square_root(xx), y = square_root(yy), z = square_root(zz);
  }
  const Lanes mean = (xx + yy + zz) * (1.0 / 3.0);
  const Lanes reciprocal = 1.0 / mean;
  const Lanes dx = 1.0 - xx * reciprocal, dy = 1.0 - yy * reciprocal, dz = -(dx + dy);
  const Lanes e2 = dx * dy - dz * dz, e3 = dx * dy * dz, e22 = e2 * e2;
  const Lanes series = 1.0 - e2 * (1.0 / 10.0) + e3 * (1.0 / 14.0) + e22 * (1.0 / 24.0) - e2 * e3 * (3.0 / 44.0) -
                       e22 * e2 * (5.0 / 208.0) + e3 * e3 * (3.0 / 104.0) + e22 * e3 * (1.0 / 16.0);
  return series * square_root(reciprocal);
}

/// The nome q from epsilon = (1 - sqrt k')/(1 + sqrt k')/2 = (q + q^9 + q^25 + ...)/(1 + 2 q^4 + 2 q^16 + ...), for
/// q <= e^(-pi/2): the inverse series, then Newton's steps. `sum` is the denominator, theta_3(q^4).
template <class Real>
struct Nome {
  Real q, sum;
};
template <class Real>
[[gnu::always_inline]] inline Nome<Real> nome_step(Lanes q0, Real epsilon) {
  using N = LaneNumbers<Real>;
  const Real q2 = N::product(q0, q0), q4 = q2 * q2, q8 = q4 * q4, q16 = q8 * q8;
  const Lanes h8 = N::high(q8), q24 = N::high(q16) * h8;
  Real sum = q4 + q16;
  sum = N::with_small(sum + sum + 1.0, 2.0 * (N::high(q16) * N::high(q16)) * N::high(q4));
  const Real above = N::with_small(q8 + 1.0, q24 * (1.0 + q24)) * q0;
  const Lanes h4 = N::high(q4), cube = N::high(q2) * q0;
  const Lanes sum_slope = 8.0 * cube * (1.0 + 4.0 * h8 * h4);
  const Lanes slope = 1.0 + h8 * (9.0 + 25.0 * N::high(q16)) - N::high(epsilon) * sum_slope;
  const Lanes step = -N::high(above - epsilon * sum) / slope;
  return {N::sum(q0, step), N::with_small(sum, sum_slope * step)};
}

template <class Real>
[[gnu::always_inline]] inline Nome<Real> nome_of(Real epsilon) {
  const Lanes e = LaneNumbers<Real>::high(epsilon);
  const Lanes e2 = e * e, e4 = e2 * e2;
  const Lanes q = e * (1.0 + e4 * (2.0 + e4 * (15.0 + e4 * (150.0 + e4 * 1707.0))));
  if constexpr (LaneNumbers<Real>::kTwoParts) return nome_step<Real>(nome_step<Lanes>(q, e).q, epsilon);
  return nome_step<Real>(q, epsilon);
}

/// The sums of the first chart (series.hpp) from u = p - q/p and s = p + q/p, which solve B0 = tau A0.
template <class Real>
struct SeriesLanes {
  Real first_sum, first_difference;    // T_1 +- T_-1 = s, u
  Real second_sum, second_difference;  // T_2 +- T_-2
  Lanes sum[8], difference[8];         // T_j +- T_-j, j from 3 on
  Real ratio;                          // A1/A0
};

template <class Real>
[[gnu::always_inline]] inline SeriesLanes<Real> series_lanes(Real q, Real tau) {
  using N = LaneNumbers<Real>;
  // u to a double: with U = u^2, A0 = 1 - q (U + 2q) + q^6 (U^2 + 4qU + 2q^2) - ... and B0/u likewise.
  const Lanes h = N::high(q), t = N::high(tau);
  const Lanes h2 = h * h, h3 = h2 * h, h4 = h2 * h2, h6 = h3 * h3, h8 = h4 * h4, h10 = h6 * h4, h12 = h6 * h6,
              h15 = h12 * h3, h21 = h15 * h6;
  const Lanes a[4] = {1.0 - 2.0 * h2 * (1.0 - h6 * (1.0 - h10)), -h * (1.0 - h6 * (4.0 - 9.0 * h10)),
                      h6 * (1.0 - 6.0 * h10), -h15};
  const Lanes b[4] = {1.0 - h4 * (3.0 - h8 * (5.0 - 7.0 * h12)), -h3 * (1.0 - h8 * (5.0 - 14.0 * h12)),
                      h10 * (1.0 - 7.0 * h12), -h21};
  Lanes u = t * (1.0 - 2.0 * h2 - h * (t * t) * (1.0 - 2.0 * h2) * (1.0 - 1.8 * h * (t * t)));
  for (int step = 0; step < 3; ++step) {
    const Lanes uu = u * u;
    const Lanes at = ((a[3] * uu + a[2]) * uu + a[1]) * uu + a[0], bt = ((b[3] * uu + b[2]) * uu + b[1]) * uu + b[0];
    const Lanes a_slope = (3.0 * a[3] * uu + 2.0 * a[2]) * uu + a[1], b_slope = (2.0 * b[2]) * uu + b[1];
    u = u - (u * bt - t * at) / (bt + 2.0 * (uu * b_slope - t * u * a_slope));
  }
  // Once more with all digits, and what depends on u by the slope.
  const Lanes u0 = u, hu2 = u0 * u0;
  const Real uu = N::product(u0, u0);
  const Real q2 = q * q, q3 = q2 * q, q4 = q2 * q2, q6 = q3 * q3, q10 = q6 * q4, q15 = q10 * (q4 * q);
  const Real y2 = uu + (q + q), y3 = y2 + q;  // p^2 + g^2, and (p^3 - g^3)/u
  const Real y4 = y2 * y2 - (q2 + q2);        // p^4 + g^4
  const Real y6 = y2 * (y4 - q2);             // p^6 + g^6
  const Lanes hy2 = N::high(y2), hy4 = N::high(y4);
  const Lanes h28 = h21 * h6 * h;
  const Lanes s8 = h28 * (hy4 * hy4 - 2.0 * h4);
  Real a0 = N::with_small((q6 * y4 - q * y2) - q15 * y6, s8) + 1.0;
  const Lanes y7 = ((hu2 + 7.0 * h) * hu2 + 14.0 * h2) * hu2 + 7.0 * h3;                      // (p^7 - g^7)/u
  const Lanes y9 = (((hu2 + 9.0 * h) * hu2 + 27.0 * h2) * hu2 + 30.0 * h3) * hu2 + 9.0 * h4;  // (p^9 - g^9)/u
  const Real b0 = (N::with_small(q10 * (y4 + q * y3) - q3 * y3, h15 * h21 * y9 - h21 * y7) + 1.0) * u0;
  const Lanes a_slope = (3.0 * a[3] * hu2 + 2.0 * a[2]) * hu2 + a[1], b_slope = (2.0 * b[2]) * hu2 + b[1];
  const Lanes b_of_u = ((b[3] * hu2 + b[2]) * hu2 + b[1]) * hu2 + b[0];
  const Lanes delta = -N::high(b0 - tau * a0) / (b_of_u + 2.0 * (hu2 * b_slope - t * u0 * a_slope));
  const Lanes uu_delta = 2.0 * u0 * delta;
  a0 = N::with_small(a0, a_slope * uu_delta);

  SeriesLanes<Real> s;
  s.first_difference = N::sum(u0, delta);
  const Real uu_1 = N::with_small(uu, uu_delta);
  const Real q_4 = q + q;
  s.first_sum = N::root(uu_1 + (q_4 + q_4));
  s.second_sum = q * (uu_1 + q_4);
  const Real us = s.first_difference * s.first_sum;  // p^2 - g^2
  s.second_difference = q * us;
  // A1 = -2 D2 + 4 D4 - 6 D6 + 8 D8
  const Real d4 = q6 * y2, d6 = q15 * (y4 + q2);
  const Real d6_2 = d6 + d6;
  Real a1 = (d4 + d4 - q) - (d6_2 + d6);
  a1 = N::with_small(a1, 4.0 * h28 * hy2 * hy4 + (2.0 * h6 - 6.0 * h15 * hy2) * uu_delta);
  s.ratio = N::quotient((a1 + a1) * us, a0);

  const Lanes hs = N::high(s.first_sum), hu = N::high(s.first_difference), hus = N::high(us);
  s.sum[3] = h3 * hs * (hu2 + h), s.difference[3] = h3 * hu * N::high(y3);
  s.sum[4] = h6 * hy4, s.difference[4] = h6 * hus * hy2;
  s.sum[5] = h10 * hs * ((hu2 + 3.0 * h) * hu2 + h2), s.difference[5] = h10 * hu * (hy4 + h * N::high(y3));
  s.sum[6] = h15 * N::high(y6), s.difference[6] = h15 * hus * (hy4 + h2);
  s.sum[7] = h21 * hs * (((hu2 + 5.0 * h) * hu2 + 6.0 * h2) * hu2 + h3), s.difference[7] = h21 * hu * y7;
  return s;
}

/// A coefficient below 2^-62 is left out, as in a solution's degree: then so are those of all bodies, whatever their
/// neighbours.
[[gnu::always_inline]] inline Lanes worth_keeping(Lanes a) { return where(magnitude(a) > 0x1p-62, a, Lanes{}); }

/// sin and cos of y quarter turns, |y| <= 1/2, absolute error below 2^-56 in two parts.
[[gnu::always_inline]] inline void sine_cosine_in_two_parts(Lanes y, LanePairs& sine, LanePairs& cosine) {
  using N = LaneNumbers<LanePairs>;
  const LanePairs u = N::product(y, y);
  const Lanes sine_tail = y * u.high * polynomial_of_degree_5(kSineTail, u.high);
  sine = N::with_small(N::constant(kHalfPiHigh, kHalfPiLow) * y, sine_tail);
  const Lanes cosine_tail = u.high * u.high * polynomial_of_degree_5(kCosineTail, u.high);
  cosine = (u * N::constant(-kEighthPi2, -0x1.692b71366cc04p-54) + 1.0) + cosine_tail;
}
[[gnu::always_inline]] inline void sine_cosine_in_two_parts(Lanes y, Lanes& sine, Lanes& cosine) {
  sine_cosine(Angle<Lanes>{y, LaneBits{}}, sine, cosine);
}

/// Builds kLanes bodies from `first` on. The lanes of bodies that this text does not serve are set in the result: a
/// momentum that is constant in the body, the second chart, and sizes far from each other.
template <class Real>
inline LaneBits build_lanes(const BlockInput& in, int first, BodyBlock& out) {
  using N = LaneNumbers<Real>;
  const auto lanes_of = [first](const double(&a)[kBlock]) { return load<Lanes>(a + first); };
  const auto put = [first](double(&a)[kBlock], Lanes lanes) { store<Lanes>(a + first, lanes); };
  Lanes i[3], m[3], q[4];
  for (int k = 0; k < 3; ++k) i[k] = lanes_of(in.moments[k]), m[k] = lanes_of(in.momentum[k]);
  for (int k = 0; k < 4; ++k) q[k] = lanes_of(in.q[k]);

  // Units in which all are near 1.
  const Lanes m_size = larger(larger(magnitude(m[0]), magnitude(m[1])), magnitude(m[2]));
  const Lanes q_size = larger(larger(magnitude(q[0]), magnitude(q[1])), larger(magnitude(q[2]), magnitude(q[3])));
  const PowerOfTwo m_unit = power_of_two(m_size), i_unit = power_of_two(i[2]), q_unit = power_of_two(q_size);
  LaneBits usual = m_unit.usual & i_unit.usual & q_unit.usual;
  for (int k = 0; k < 3; ++k) {
    i[k] = i[k] * i_unit.reciprocal;
    m[k] = m[k] * m_unit.reciprocal;
    usual &= (magnitude(m[k]) > 0x1p-200) | (m[k] == 0.0);
  }
  for (Lanes& component : q) {
    component = component * q_unit.reciprocal;
    usual &= magnitude(component) < 2.0;  // not NaN
  }
  usual &= (i[0] > 0x1p-40) & (i[0] <= i[1]) & (i[1] <= i[2]);
  const LaneBits still_12 = (m[0] == 0.0) | (m[1] == 0.0) | (i[0] == i[1]);
  const LaneBits still_23 = (m[1] == 0.0) | (m[2] == 0.0) | (i[1] == i[2]);
  const LaneBits still_13 = (m[0] == 0.0) | (m[2] == 0.0) | (i[0] == i[2]);
  usual &= ~(still_12 & still_23 & still_13);

  const CanonicalLanes<Real> c = canonical_lanes<Real>(i, m);
  const Real b31 = N::root(N::quotient(c.d1, c.i12 * c.j31));
  const Real b13 = N::root(N::quotient(c.d3, c.i23 * c.j31));
  const Real x = c.d1 * c.j32;
  const Real kp2 = N::quotient(c.d2 * c.j31, x);
  const Real kp = N::root(kp2), root_kp = N::root(kp);
  usual &= N::high(kp2) >= 0x1.e24cc8p-6;  // (sqrt 2 - 1)^4, where K = 2 K'
  const Real root_kp_1 = root_kp + 1.0;
  const Real square_1 = root_kp_1 * root_kp_1;
  const Real epsilon = N::scaled(N::quotient(c.d3 * c.j21, x * (kp + 1.0) * square_1), all<Lanes>(0.5));
  const Nome<Real> nome = nome_of<Real>(epsilon);
  const Real tau = N::quotient(b13, c.g + b31);
  const SeriesLanes<Real> s = series_lanes<Real>(nome.q, tau);

  // 1/K = (1 + sqrt k')^2 / (2 pi theta_3(q^4)^2)
  const Real over_2pi = N::constant(0x1.45f306dc9c883p-3, -0x1.6b01ec5417056p-57);
  const Real sum_squared = nome.sum * nome.sum;
  Real v_rate = N::quotient(N::root(x) * square_1, c.i123 * sum_squared) * over_2pi;  // lambda / K
  const LaneBits longs = c.long_axis_mode;
  v_rate = where(longs, -v_rate, v_rate);
  const Real bracket =
      N::quotient(N::quotient(where(longs, b31 * c.j31, c.d3), where(longs, N::of(c.i3), c.i123 * (c.g + b31))) + c.g,
                  where(longs, N::of(c.i1), N::of(c.i3)));
  const Real rho_rate = bracket * (over_2pi + over_2pi) - v_rate * s.ratio;
  const Lanes time_unit = m_unit.value * i_unit.reciprocal;
  put(out.v_quarters_per_s[0], N::high(v_rate) * time_unit);
  put(out.v_quarters_per_s[1], N::low(v_rate) * time_unit);
  put(out.rho_quarters_per_s[0], N::high(rho_rate) * time_unit);
  put(out.rho_quarters_per_s[1], N::low(rho_rate) * time_unit);

  // Coefficients of c = cos 2v, as in build.hpp: the first two of each with their low parts.
  const Real e1 = -s.second_sum, f1 = -s.second_difference;
  const Lanes e2 = s.sum[4], e3 = -s.sum[6], f2 = s.difference[4], f3 = -s.difference[6];
  const Lanes o1 = -s.sum[3], o2 = s.sum[5], o3 = -s.sum[7];
  const Lanes g1 = -s.difference[3], g2 = s.difference[5], g3 = -s.difference[7];
  const Real p0[4] = {N::sum(all<Lanes>(1.0), -e2), N::with_small(e1, -3.0 * e3), N::of(2.0 * e2), N::of(4.0 * e3)};
  const Real p1[4] = {s.first_sum + (o1 - o2 - o3), N::of(2.0 * o1 + 2.0 * o2 - 4.0 * o3), N::of(4.0 * o2 + 4.0 * o3),
                      N::of(8.0 * o3)};
  const Real p2[4] = {N::with_small(f1, -f3), N::of(2.0 * f2), N::of(4.0 * f3), N::of(Lanes{})};
  const Real p3[4] = {-(s.first_difference + (g3 - g1 - g2)), N::of(4.0 * g3 - 2.0 * g1 + 2.0 * g2),
                      N::of(4.0 * g3 - 4.0 * g2), N::of(-8.0 * g3)};
  const auto put_polynomial = [&](int which, const Real(&p)[4]) {
    put(out.polynomial[0][which], N::high(p[0]));
    for (int n = 1; n < 4; ++n) put(out.polynomial[n][which], worth_keeping(N::high(p[n])));
  };
  put_polynomial(0, p0);
  put_polynomial(1, p1);
  put_polynomial(2, p2);
  put_polynomial(3, p3);

  // v at t = 0, nearly: cn = m1/B13, dn = m3/B31, sn = m2/B23.
  const Lanes hb13 = N::high(b13), hb31 = N::high(b31);
  const Lanes hb23 = square_root(N::high(c.d3) / (N::high(c.i13) * N::high(c.j32)));
  const Lanes dn = c.m3 / hb31;
  const Lanes over_k = N::high(square_1) / N::high(sum_squared) * 0x1.45f306dc9c883p-3;
  const Lanes v = c.m2 / hb23 * rf_of_roots(c.m1 / hb13, dn) * over_k;
  const Lanes whole = nearest_integer(v);
  const Lanes y = v - whole;
  Real sine, cosine;
  sine_cosine_in_two_parts(y, sine, cosine);
  const LaneBits odd = whole != 0.0, negative = whole < 0.0;
  const Real sin_v = where(odd, where(negative, -cosine, cosine), sine);
  const Real cos_v = where(odd, where(negative, sine, -sine), cosine);
  const Real sin_2 = sin_v * cos_v, sin_sin = sin_v * sin_v;
  const Real sin_2v = sin_2 + sin_2, cos_2v = -(sin_sin + sin_sin) + 1.0;
  const Lanes c2 = N::high(cos_2v);
  const auto at = [&](const Real(&p)[4]) {
    return N::with_small(p[1] * cos_2v + p[0], c2 * c2 * multiply_add(N::high(p[3]), c2, N::high(p[2])));
  };
  const auto slope_at = [&](const Real(&p)[4]) {
    return multiply_add(multiply_add(3.0 * N::high(p[3]), c2, 2.0 * N::high(p[2])), c2, N::high(p[1]));
  };
  const Real at_1 = at(p1), at_2 = at(p2), at_3 = at(p3);
  Real re_alpha = at(p0), re_beta = sin_v * at_1, im_alpha = sin_2v * at_2, im_beta = cos_v * at_3;
  // The rest of v by the direction of (m1, m2), whose derivative by w is B13 B23 dn / (m1^2 + m2^2).
  const Real k1 = im_alpha * re_beta - re_alpha * im_beta, k2 = re_alpha * re_beta + im_alpha * im_beta;
  const Lanes turn = N::high(k1 * c.m2 - k2 * c.m1) / (N::high(k1) * c.m1 + N::high(k2) * c.m2);
  const Lanes v_step = turn * (c.m1 * c.m1 + c.m2 * c.m2) * over_k / (hb13 * hb23 * dn);
  put(out.v_whole_quarters_at_0, whole);
  put(out.v_quarters_at_0, y + v_step);
  const Lanes dv = v_step * kHalfPiHigh, sv = N::high(sin_v), cv = N::high(cos_v), s2 = N::high(sin_2v);
  const Lanes dc = -2.0 * s2 * dv;
  re_alpha = N::with_small(re_alpha, slope_at(p0) * dc);
  re_beta = N::with_small(re_beta, cv * dv * N::high(at_1) + sv * slope_at(p1) * dc);
  im_alpha = N::with_small(im_alpha, 2.0 * c2 * dv * N::high(at_2) + s2 * slope_at(p2) * dc);
  im_beta = N::with_small(im_beta, -sv * dv * N::high(at_3) + cv * slope_at(p3) * dc);

  // frame = q conj(X), with X the state at t = 0 in the body's axes.
  const auto signed_as = [&](Real a, int k) { return where(c.sign[k], -a, a); };
  const Real axis_1 = signed_as(re_beta, 0), axis_2 = signed_as(im_beta, 1), axis_3 = signed_as(im_alpha, 2);
  const Real w = re_alpha, x1 = where(longs, axis_3, axis_1), x2 = axis_2, x3 = where(longs, axis_1, axis_3);
  const Real state_2 = w * w + x1 * x1 + x2 * x2 + x3 * x3;
  const Real q_2 =
      (N::product(q[0], q[0]) + N::product(q[1], q[1])) + (N::product(q[2], q[2]) + N::product(q[3], q[3]));
  const Real scale = N::quotient(N::of(all<Lanes>(1.0)), N::root(state_2 * q_2));
  const Real frame[4] = {
      (w * q[0] + x1 * q[1]) + (x2 * q[2] + x3 * q[3]), (w * q[1] - x1 * q[0]) + (x2 * q[3] - x3 * q[2]),
      (w * q[2] - x2 * q[0]) + (x3 * q[1] - x1 * q[3]), (w * q[3] - x3 * q[0]) + (x1 * q[2] - x2 * q[1])};
  for (int k = 0; k < 4; ++k) put(out.frame[k], N::high(frame[k] * scale));
  const Lanes g = N::high(c.g) * m_unit.value;
  for (int k = 0; k < 3; ++k) {
    put(out.sign[k], flip(all<Lanes>(1.0), c.sign[k]));
    put(out.momentum_scale[k], flip(g, c.sign[k]));
  }
  put(out.long_axis_mode, where(longs, all<Lanes>(-1.0), all<Lanes>(1.0)));
  return ~usual;
}

/// Builds a block. Bit k of the result is set where body k is left to the build of one body.
template <class Real>
inline unsigned build_block(const BlockInput& in, BodyBlock& out) {
  unsigned left = 0;
  for (int first = 0; first < kBlock; first += kLanes) {
    const LaneBits unusual = build_lanes<Real>(in, first, out);
    for (int lane = 0; lane < kLanes; ++lane) left |= unusual[lane] != 0 ? 1U << (first + lane) : 0U;
  }
  return left;
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
