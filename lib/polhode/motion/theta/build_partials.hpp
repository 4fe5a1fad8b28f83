#pragma once

// The constants of the partial derivatives from those of the motion. Formulas and letters: partials.md.

#include "polhode/motion/theta/build.hpp"
#include "polhode/motion/theta/partials.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

/// kappa_k = 1/I_j - 1/I_i for (k, i, j) cyclic, from the exact difference of the moments.
template <class Real>
void shape_of(const double (&moments)[3], double (&kappa)[3]) {
  for (int k = 0; k < 3; ++k) {
    const double i = moments[(k + 1) % 3], j = moments[(k + 2) % 3];
    kappa[k] = nearest((Real(i) - j) / (Real(i) * j));
  }
}

/// How the columns are made.
struct ColumnForm {
  bool by_r = false;                   ///< off the diagonal, of m: by R, or else by sigma
  bool by_ratio[3] = {};               ///< for which components c_k is the ratio m_k / m_k(0)
  double m_sign[3] = {1.0, 1.0, 1.0};  ///< from the canonical m_k, already in the body's order, to the body's
  double r_sign[3] = {1.0, 1.0, 1.0};  ///< the same of R_k
};

template <class Real>
void build_partials_frame(const Input& in, int moment_exponent, int momentum_exponent, const ColumnForm& form,
                          PartialsFrame& f) {
  double moments[3], m[3], kappa[3], j[3];
  for (int k = 0; k < 3; ++k) {
    moments[k] = ldexp(in.moments[k], -moment_exponent);
    m[k] = ldexp(in.momentum[k], -momentum_exponent);
    j[k] = 1.0 / moments[k];
  }
  shape_of<Real>(moments, kappa);
  f = {};
  f.time_scale = ldexp(1.0, momentum_exponent - moment_exponent);
  f.momentum_scale = ldexp(1.0, -momentum_exponent);
  const Quaternion4<Real> q0 = initial_attitude<Real>(in);
  f.q0[0] = nearest(q0.w), f.q0[1] = nearest(q0.x), f.q0[2] = nearest(q0.y), f.q0[3] = nearest(q0.z);
  const double g2 = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
  const bool at_rest = g2 == 0.0;
  const double over_g2 = at_rest ? 0.0 : f.momentum_scale / g2;
  // D_2 = -Delta_2 / I_2: its terms cancel beside the separatrix
  const Real i1 = moments[0], i2 = moments[1], i3 = moments[2];
  const double d2 = -nearest(delta2_i1_i3<Real>(moments, i2 - i1, i3 - i2, m[0], m[2]) / (i1 * i2 * i3));
  for (int l = 0; l < 3; ++l) {
    const int next = (l + 1) % 3, last = (l + 2) % 3;
    const double m_over_g2 = m[l] * over_g2;
    // D_l = 2 T - G^2 / I_l = sum of (1/I_k - 1/I_l) m_k^2
    const double d = l == 1 ? d2 : kappa[last] * m[next] * m[next] - kappa[next] * m[last] * m[last];
    f.turn[next][l] = m[last] * over_g2;
    f.turn[last][l] = -m[next] * over_g2;
    f.of_tm[l][l] = j[l] * m_over_g2;
    f.of_sigma[l][l] = at_rest ? j[l] * f.momentum_scale : -d * over_g2;
    for (int i = 1; i < 3; ++i) {
      const int k = (l + i) % 3, other = (l + 3 - i) % 3;
      const double sign = i == 1 ? -1.0 : 1.0;
      f.of_c[k][l] = sign * m[other] * over_g2;
      if (form.by_r) {
        f.of_tm[k][l] = j[l] * m_over_g2;
        f.of_r[k][l] = -sign * kappa[other] * kappa[k] * m_over_g2;
      } else {
        f.of_tm[k][l] = j[k] * m_over_g2;
        f.of_sigma[k][l] = form.by_ratio[k] ? -m_over_g2 * d / m[k] : sign * kappa[other] * m[l] * m[k] * over_g2;
      }
    }
    const double by_moment = -ldexp(j[l] * j[l], -moment_exponent);  // d(1/I_l)/dI_l
    f.of_tm[l][3 + l] = by_moment;
    for (int k = 0; k < 3; ++k) f.of_r[k][3 + l] = -0.5 * kappa[l] * by_moment;
  }
  for (int k = 0; k < 3; ++k) {
    for (int column = 0; column < 6; ++column) {
      f.of_tm[k][column] *= form.m_sign[k];
      f.of_r[k][column] *= form.r_sign[k];
    }
  }
}

template <class Real>
void build_fixed_axis_partials(const Input& in, int moment_exponent, int momentum_exponent, PartialsSolution& out) {
  FixedAxisPartials& f = out.fixed_axis;
  f = {};
  Real kappa[3];
  double m[3];
  for (int k = 0; k < 3; ++k) {
    const double i = ldexp(in.moments[(k + 1) % 3], -moment_exponent);
    const double j = ldexp(in.moments[(k + 2) % 3], -moment_exponent);
    kappa[k] = (Real(i) - j) / (Real(i) * j);
    m[k] = ldexp(in.momentum[k], -momentum_exponent);
  }
  Real h = 0.0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    f.products[k] = m[i] * m[j];
    // m_k'' = h m_k with h = kappa_k (kappa_i m_j^2 + kappa_j m_i^2); the same, or 0, for all k
    const Real own = kappa[k] * (kappa[i] * m[j] * m[j] + kappa[j] * m[i] * m[i]);
    f.varies[k] = nearest(own) != 0.0;
    if (f.varies[k]) h = own;
  }
  if (nearest(h) == 0.0) {
    f.kind = FixedAxisPartials::Kind::linear;
    return;
  }
  const Real rate = sqrt(abs(h));
  f.reciprocal_rate = nearest(1.0 / rate);
  const int time_exponent = momentum_exponent - moment_exponent;
  if (nearest(h) < 0.0) {
    f.kind = FixedAxisPartials::Kind::circular;
    f.rate_per_s = scaled(rate * 2.0 / RealTraits<Real>::pi(), time_exponent);
  } else {
    f.kind = FixedAxisPartials::Kind::hyperbolic;
    f.rate_per_s = scaled(rate, time_exponent);
  }
}

/// A body in canonical axes as the partials need it, in plain doubles.
struct CanonicalPartials {
  double m[3], kappa[3], d1, d2, d3, lambda;
};

template <class Real>
CanonicalPartials canonical_partials(const Canonical<Real>& c, double lambda) {
  const double(&i)[3] = c.moments;
  const double side = c.long_axis_mode ? 1.0 : -1.0;
  CanonicalPartials p;
  // Beside the middle axis m_1 and m_3 may be below what has a reciprocal.
  const auto with_reciprocal = [](double a) {
    constexpr double least = 0x1p-1000;
    return a != 0.0 && __builtin_fabs(a) < least ? __builtin_copysign(least, a) : a;
  };
  p.m[0] = with_reciprocal(ldexp(c.m[0], c.exponent_13));
  p.m[1] = c.m[1];
  p.m[2] = with_reciprocal(ldexp(c.m[2], c.exponent_13));
  p.kappa[0] = side * nearest(c.j32) / (i[1] * i[2]);
  p.kappa[1] = -side * nearest(c.j31) / (i[0] * i[2]);
  p.kappa[2] = side * nearest(c.j21) / (i[0] * i[1]);
  const double root_d1 = ldexp(nearest(c.root_d1.value), c.root_d1.exponent);
  p.d1 = side * root_d1 * root_d1 / i[0];
  p.d2 = side * ldexp(nearest(c.d2_13), 2 * c.exponent_13) / i[1];
  p.d3 = -side * nearest(c.d3) / i[2];
  p.lambda = lambda;
  // As good as 0, so that its powers remain numbers.
  constexpr double smallest = 0x1p-230;
  if (__builtin_fabs(lambda) < smallest) {
    p.lambda = __builtin_copysign(smallest, lambda);
    p.d1 = p.lambda * p.lambda / p.kappa[0];
  }
  return p;
}

inline AdditionConstants addition_constants(const CanonicalPartials& p) {
  const double(&m)[3] = p.m;
  const double(&kappa)[3] = p.kappa;
  const double lambda = p.lambda, a2 = m[1] * m[1];
  AdditionConstants a;
  a.lambda = lambda;
  a.reciprocal_lambda = 1.0 / lambda;
  a.k2 = kappa[2] == 0.0 ? 0.0 : -kappa[2] * p.d3 / (kappa[0] * p.d1);
  a.kp2 = kappa[2] == 0.0 ? 1.0 : -kappa[1] * p.d2 / (kappa[0] * p.d1);
  a.reciprocal_k2 = 1.0 / a.k2;
  a.reciprocal_kp2 = 1.0 / a.kp2;
  const double kappa3_over_d1 = kappa[2] == 0.0 ? 0.0 : kappa[2] / p.d1;
  a.g0 = kappa3_over_d1 * m[1];
  a.g1 = kappa3_over_d1 * kappa[1] * m[0] * m[2] / lambda;
  a.m3 = m[2];
  a.n3 = kappa[2] * m[0] * m[1];
  a.e = kappa[0] * kappa[2] * a2;
  a.r1_c = kappa[2] * m[0] * a2;
  a.r1_d = m[1] * m[2];
  a.r1_periodic = m[0] / (kappa[0] * lambda);
  a.r2_cd = m[1] / kappa[1];
  a.r2_s = m[0] * m[2];
  a.r2_periodic = m[1] / (kappa[1] * lambda);
  a.r3_d = kappa[0] * m[2] * a2;
  a.r3_c = m[0] * m[1];
  a.r3_psi = m[2] * p.d3 / (lambda * lambda * lambda);
  a.r3_upsilon = m[1] * m[2] / (p.d1 * lambda);
  return a;
}

/// Polynomial coefficients in sin^2 v of (sum of weight_n f_n(v)) / (the same at v = 0), minus its 1; f_n a multiple
/// angle over its first member: rows are n, columns powers of sin^2 v.
inline void series_in_sine2(const double (&weight)[5], const double (&multiples)[5][5], double (&out)[4][5],
                            int column) {
  double at_0 = 0.0;
  for (int n = 0; n < 5; ++n) at_0 += weight[n] * multiples[n][0];
  for (int power = 1; power < 5; ++power) {
    double sum = 0.0;
    for (int n = 0; n < 5; ++n) sum += weight[n] * multiples[n][power];
    out[power - 1][column] = sum / at_0;
  }
}

// With s = sin^2 v up to s^4; what multiplies s^5 and more has a nome below 2^-56 before it.
// cos 2 n v
inline constexpr double kCosine2n[5][5] = {
    {1, 0, 0, 0, 0}, {1, -2, 0, 0, 0}, {1, -8, 8, 0, 0}, {1, -18, 48, -32, 0}, {1, -32, 160, -256, 128}};
// sin (2 n + 1) v / sin v
inline constexpr double kSine2n1[5][5] = {
    {1, 0, 0, 0, 0}, {3, -4, 0, 0, 0}, {5, -20, 16, 0, 0}, {7, -56, 112, -64, 0}, {9, -120, 432, -576, 256}};
// cos (2 n + 1) v / cos v
inline constexpr double kCosine2n1[5][5] = {
    {1, 0, 0, 0, 0}, {1, -4, 0, 0, 0}, {1, -12, 16, 0, 0}, {1, -24, 80, -64, 0}, {1, -40, 240, -448, 256}};
// sin 2 n v / sin 2 v, n = 1, 2, ...
inline constexpr double kSine2n[5][5] = {
    {1, 0, 0, 0, 0}, {2, -4, 0, 0, 0}, {3, -16, 16, 0, 0}, {4, -40, 96, -64, 0}, {5, -80, 336, -512, 256}};

template <class Real>
void build_fourier_partials(const CanonicalPartials& p, const Common<Real>& s, const TwoPart& v_quarters_per_s,
                            double time_scale, FourierPartials& f) {
  const double q = __builtin_exp(-(kPi.high * nearest(s.k_prime) * nearest(s.reciprocal_k)));
  const double q2 = q * q, q3 = q2 * q, q4 = q2 * q2, q6 = q4 * q2, q8 = q4 * q4, q9 = q8 * q, q12 = q6 * q6,
               q15 = q12 * q3, q16 = q8 * q8, q20 = q16 * q4, q24 = q12 * q12;
  series_in_sine2({1.0, -2.0 * q, 2.0 * q4, -2.0 * q9, 2.0 * q16}, kCosine2n, f.polynomial, 0);
  series_in_sine2({1.0, -q2, q6, -q12, q20}, kSine2n1, f.polynomial, 1);
  series_in_sine2({1.0, q2, q6, q12, q20}, kCosine2n1, f.polynomial, 2);
  series_in_sine2({1.0, 2.0 * q, 2.0 * q4, 2.0 * q9, 2.0 * q16}, kCosine2n, f.polynomial, 3);
  series_in_sine2({1.0, -2.0 * q3, 3.0 * q8, -4.0 * q15, 5.0 * q24}, kSine2n, f.polynomial, 4);
  const double theta3 = 1.0 + 2.0 * (q + q4 + q9 + q16), theta4 = 1.0 + 2.0 * (q4 - q - q9 + q16);
  const double half_theta2 = 1.0 + q2 + q6 + q12 + q20;  // over q^(1/4)
  const double half_theta2_4 = half_theta2 * half_theta2 * half_theta2 * half_theta2;
  f.delta_per_v = theta3 * theta3;
  // the mean of sn^2, times Delta per v
  f.xi_scale = f.delta_per_v * (1.0 - 4.0 * q3 + 9.0 * q8 - 16.0 * q15 + 25.0 * q24) / (2.0 * theta4 * half_theta2_4);
  f.quarters_per_s = v_quarters_per_s;
  f.addition = addition_constants(p);
  for (int k = 0; k < 3; ++k) f.period_sigma[k] = f.period_c[k] = f.period_r[k] = 0.0;
  if (p.lambda != nearest(s.lambda)) {  // no half turn ever
    f.quarters_per_s = {p.lambda / f.delta_per_v * (2.0 / kPi.high) * time_scale, 0.0};
    return;
  }
  const double mean = f.xi_scale / f.delta_per_v;  // of sn^2
  const double period = kPi.high * f.delta_per_v / p.lambda;
  const double(&m)[3] = p.m;
  const double(&kappa)[3] = p.kappa;
  const double over_d1 = kappa[2] == 0.0 ? 0.0 : kappa[2] / p.d1;
  const double per_period[3] = {-period * (1.0 - mean) * kappa[2] / p.d2, period * mean * over_d1,
                                period * kappa[0] * (1.0 - f.addition.k2 * mean) / p.d2};
  for (int k = 0; k < 3; ++k) {
    f.period_sigma[k] = per_period[k] * m[k];
    f.period_c[k] = -per_period[k] * kappa[k] * m[(k + 1) % 3] * m[(k + 2) % 3];
  }
  f.period_r[0] = period * (m[2] * m[2] - kappa[2] / kappa[0] * mean * m[0] * m[0]) / p.d2;
  f.period_r[1] = period * (1.0 - mean * over_d1 * m[1] * m[1]) / kappa[1];
  f.period_r[2] = -period * (m[0] * m[0] + mean * p.d3 / p.d1 * m[2] * m[2]) / p.d2;
}

inline void build_hyperbolic_partials(const CanonicalPartials& p, const HyperbolicChart& chart, bool by_ratio,
                                      HyperbolicPartials& h) {
  const double root = chart.root_of_nome;  // Q; the nome is q = Q^2
  const double q = root * root, q2 = q * q, q3 = q2 * q, q4 = q2 * q2, q8 = q4 * q4;
  const double theta3 = 1.0 + 2.0 * (q + q4), theta4 = 1.0 + 2.0 * (q4 - q);
  const double half_theta2 = 1.0 + q2;
  const double half_theta2_4 = half_theta2 * half_theta2 * half_theta2 * half_theta2;
  h.addition = addition_constants(p);
  h.by_ratio = by_ratio;
  h.n1 = p.kappa[0] * p.m[1] * p.m[2];
  h.growth[0] = by_ratio ? p.kappa[0] * p.m[1] * p.m[2] / p.m[0] : 0.0;
  h.growth[1] = p.kappa[2] * p.m[0] * p.m[1] / p.m[2];
  h.delta_per_x = theta3 * theta3;
  h.sinh1 = -4.0 * q2 / (1.0 - 3.0 * q2);
  h.cosh1 = 4.0 * q2 / (1.0 + q2);
  h.theta4[0] = (-4.0 * q + 16.0 * q4) / theta4;
  h.theta4[1] = 16.0 * q4 / theta4;
  h.theta3[0] = (4.0 * q + 16.0 * q4) / theta3;
  h.theta3[1] = 16.0 * q4 / theta3;
  h.integral1 = 8.0 * q3 / (1.0 + 4.0 * q3);
  h.s0 = (1.0 - 4.0 * q3 + 9.0 * q8) / (2.0 * theta4 * half_theta2_4);
  h.s1 = theta3 * theta3 / (4.0 * half_theta2_4);
  h.psi_scale = (1.0 - h.s0) * h.delta_per_x;

  h.nome = q;
  h.nome2 = q2;
  h.cn_scale = 2.0 * half_theta2 / theta4;
  h.dn_scale = 2.0 * half_theta2 / theta3;
  const double x0 = chart.x_at_0.high;
  h.e0 = __builtin_exp(-(__builtin_fabs(x0) < 690.0 ? __builtin_fabs(x0) : 690.0));
  const double e2 = h.e0 * h.e0, e4 = e2 * e2, y = root * (1.0 / h.e0), y2 = y * y;
  const double m0 =
      ((1.0 - e4) + 2.0 * q2 * y2 * (1.0 - e4 * e4)) / (1.0 + y2 * (1.0 + e4) + q2 * y2 * y2 * (1.0 + e4 * e4));
  h.e0_m0 = __builtin_copysign(0.5 / h.e0 * m0, x0);
  h.reciprocal_root = root > 0x1p-1000 ? 1.0 / root : 0.0;
  h.jump = h.e0 * 0.5 * h.reciprocal_root;
  h.kp2_scale = 16.0 * half_theta2_4 / (theta3 * theta3 * theta3 * theta3) * (root / h.e0);
  h.b13 = __builtin_sqrt(p.d3 / p.kappa[1]);
  h.reciprocal_b23 = __builtin_sqrt(-p.kappa[0] / p.d3);
  h.b31 = __builtin_sqrt(-p.d1 / p.kappa[1]);
  h.cn = p.m[0] / h.b13;
  h.sn = p.m[1] * h.reciprocal_b23;
  h.dn = p.m[2] / h.b31;
  h.cn_e = h.cn / h.e0;
  h.dn_e = h.dn / h.e0;
  h.cn_over_dn = h.cn / h.dn;
  h.sn_cn_dn = h.sn * h.cn_over_dn;
  for (int k = 0; k < 3; ++k) {
    h.m[k] = p.m[k];
    h.reciprocal_kappa_lambda[k] = 1.0 / (p.kappa[k] * p.lambda);
  }
}

template <class Real>
void build_with_partials(const Input& in, Solution& out, PartialsSolution& partials) {
  struct Further {
    const Input& in;
    const Solution& solution;
    PartialsSolution& partials;

    void operator()(int moment_exponent, int momentum_exponent) const {
      partials = {};
      build_partials_frame<Real>(in, moment_exponent, momentum_exponent, {}, partials.frame);
      build_fixed_axis_partials<Real>(in, moment_exponent, momentum_exponent, partials);
    }
    void operator()(int moment_exponent, int momentum_exponent, const Canonical<Real>& c, const Common<Real>& s) const {
      partials = {};
      const CanonicalPartials p = canonical_partials(c, nearest(s.lambda));
      partials.exchange_1_3 = c.long_axis_mode;
      const bool fourier = solution.chart == Chart::fourier;
      // Beside the separatrix D_2 is small, and so is what m_2 does: then by ratios, unless m_1 is small as well.
      const bool ratio_1 = __builtin_fabs(p.d2) < __builtin_fabs(p.kappa[2]) * p.m[0] * p.m[0];
      ColumnForm form;
      form.by_r = fourier;
      for (int k = 0; k < 3; ++k) {
        const int own = c.long_axis_mode ? 2 - k : k;  // the body's component
        partials.sign[k] = form.m_sign[own] = c.sign[k];
        form.r_sign[own] = c.long_axis_mode ? -c.sign[k] : c.sign[k];
        form.by_ratio[own] = k == 2 || (k == 0 && ratio_1);
      }
      build_partials_frame<Real>(in, moment_exponent, momentum_exponent, form, partials.frame);
      if (fourier) {
        partials.fourier = {};
        build_fourier_partials(p, s, solution.fourier.v_quarters_per_s, partials.frame.time_scale, partials.fourier);
      } else {
        partials.hyperbolic = {};
        build_hyperbolic_partials(p, solution.hyperbolic, ratio_1, partials.hyperbolic);
      }
    }
  };
  build<Real>(in, out, Further{in, out, partials});
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
