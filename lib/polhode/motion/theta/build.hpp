#pragma once

// From a body at t = 0 to the constants of its motion. One text for double and DoubleDouble. Formulas: theta.md.

#include "polhode/base/double_double.hpp"
#include "polhode/elliptic/carlson.hpp"
#include "polhode/motion/theta/series.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

template <class Real>
TwoPart two_part(Real a) {
  return {RealTraits<Real>::high(a), RealTraits<Real>::low(a)};
}

template <class Real>
TwoPart scaled(Real a, int exponent) {
  return two_part(ldexp(a, exponent));
}

template <class Real>
double nearest(Real a) {
  return RealTraits<Real>::high(a);
}

/// Hamilton product, scalar first.
template <class Real>
struct Quaternion4 {
  Real w, x, y, z;
  friend Quaternion4 operator*(const Quaternion4& a, const Quaternion4& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
  Quaternion4 conjugate() const { return {w, -x, -y, -z}; }
};

/// Stands for infinity, with which double-double arithmetic would give NaN.
inline constexpr double kInfinite = 1e300;

inline int exponent_of(double a) { return a == 0.0 || !__builtin_isfinite(a) ? -2000 : __builtin_ilogb(a); }

/// a 2^-exponent, its size raised to 2^-400 unless it is zero: changes no answer by more than 1e-120, and keeps it and
/// its square from underflowing.
inline double raised(double a, int exponent) {
  if (a == 0.0 || !__builtin_isfinite(a) || exponent_of(a) - exponent >= -400) return ldexp(a, -exponent);
  return __builtin_copysign(0x1p-400, a);
}

/// A number times a power of two that a double's range may not hold.
template <class Real>
struct Scaled {
  Real value;
  int exponent;
};

template <class Real>
int exponent_of(const Scaled<Real>& a) {
  return exponent_of(nearest(a.value)) + a.exponent;
}

/// R_F of the roots a, b and 1. Far below 1 it is ln(4 / (a + b)) (DLMF 19.27.2).
template <class Real>
Real rf_near_one(const Scaled<Real>& a, const Scaled<Real>& b) {
  const int ea = exponent_of(a), eb = exponent_of(b);
  const int exponent = ea > eb ? ea : eb;
  if (exponent > -60) {
    return carlson_rf_of_roots<Real>(ldexp(a.value, a.exponent), ldexp(b.value, b.exponent), 1.0);
  }
  const Real sum = ldexp(a.value, a.exponent - exponent) + ldexp(b.value, b.exponent - exponent);
  return log(4.0 / sum) - RealTraits<Real>::ln2() * static_cast<double>(exponent);
}

/// Momentum and moments in canonical axes: turned so that the momentum circles +e3, in units in which both are near 1.
template <class Real>
struct Canonical {
  double moments[3];  // ascending in short-axis mode, descending in long-axis mode
  double m[3];        // m[0] and m[2] times 2^exponent_13
  int exponent_13;
  bool long_axis_mode;
  double sign[3];  // canonical component k is sign[k] times the body's component k, after the exchange
  Quaternion4<Real> q_canonical_from_body;
  Real j21, j31, j32;    // |I_jh|
  Scaled<Real> root_d1;  // sqrt |Delta_1|
  Real d3;               // |Delta_3|
  Real d2_13;            // |Delta_2| 2^(-2 exponent_13)
  Real g;
};

template <class Real>
Real full(double a, int exponent) {
  return ldexp(Real(a), exponent < -400 ? -400 : exponent);
}

/// Delta_2 I1 I3 / 2^(2 exponent), the seed's sum, "The quantity Delta_j". Only its difference may cancel.
template <class Real>
Real delta2_i1_i3(const double moments[3], const Real& i21, const Real& i32, double m1, double m3) {
  return Real(m3) * Real(m3) * i32 * moments[0] - Real(m1) * Real(m1) * i21 * moments[2];
}

template <class Real>
Canonical<Real> canonical(const Input& in, int moment_exponent, int momentum_exponent) {
  Canonical<Real> c;
  double moments[3], m[3];
  for (int k = 0; k < 3; ++k) {
    moments[k] = ldexp(in.moments[k], -moment_exponent);
    m[k] = in.momentum[k];
  }
  // m2 relative to the largest component; m1 and m3 relative to the larger of the two, which may be tiny.
  const int e1 = exponent_of(m[0]), e3 = exponent_of(m[2]);
  const int exponent = e1 > e3 ? e1 : e3;
  m[0] = raised(m[0], exponent);
  m[1] = raised(m[1], momentum_exponent);
  m[2] = raised(m[2], exponent);
  c.exponent_13 = exponent - momentum_exponent;

  const Real i21 = Real(moments[1]) - moments[0];
  const Real i31 = Real(moments[2]) - moments[0];
  const Real i32 = Real(moments[2]) - moments[1];
  const Real delta2 = delta2_i1_i3<Real>(moments, i21, i32, m[0], m[2]) / (Real(moments[0]) * moments[2]);
  c.long_axis_mode = nearest(delta2) < 0.0;
  c.d2_13 = abs(delta2);

  const Real half_root = sqrt(Real(0.5));
  c.q_canonical_from_body = {1.0, 0.0, 0.0, 0.0};
  for (double& s : c.sign) s = 1.0;
  if (c.long_axis_mode) {  // e1' = e3, e2' = -e2, e3' = e1
    for (int k = 0; k < 3; ++k) {
      c.moments[k] = moments[2 - k];
      c.m[k] = m[2 - k];
    }
    c.m[1] = -c.m[1];
    c.sign[1] = -1.0;
    c.j21 = i32, c.j31 = i31, c.j32 = i21;
    c.q_canonical_from_body = {0.0, half_root, 0.0, half_root};
  } else {
    for (int k = 0; k < 3; ++k) {
      c.moments[k] = moments[k];
      c.m[k] = m[k];
    }
    c.j21 = i21, c.j31 = i31, c.j32 = i32;
  }
  const auto turn_by_pi = [&c](int axis) {
    for (int k = 0; k < 3; ++k) {
      if (k == axis) continue;
      c.m[k] = -c.m[k];
      c.sign[k] = -c.sign[k];
    }
    const Quaternion4<Real> about{0.0, axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
    c.q_canonical_from_body = about * c.q_canonical_from_body;
  };
  if (c.m[2] < 0.0) turn_by_pi(0);
  if (c.m[0] < 0.0) turn_by_pi(2);

  const Real m1 = full<Real>(c.m[0], c.exponent_13), m2 = c.m[1], m3 = full<Real>(c.m[2], c.exponent_13);
  // Delta_1 may be the square of a tiny m3 alone, for a symmetric top.
  const double part_2 = __builtin_fabs(c.m[1]) * __builtin_sqrt(nearest(c.j21) / c.moments[1]);
  const double part_3 = __builtin_fabs(c.m[2]) * __builtin_sqrt(nearest(c.j31) / c.moments[2]);
  const int exponent_2 = exponent_of(part_2), exponent_3 = exponent_of(part_3) + c.exponent_13;
  c.root_d1.exponent = exponent_2 > exponent_3 ? exponent_2 : exponent_3;
  const Real m2_scaled = nearest(c.j21) == 0.0 ? Real(0.0) : ldexp(m2, -c.root_d1.exponent);
  const Real m3_scaled = ldexp(Real(c.m[2]), c.exponent_13 - c.root_d1.exponent);
  c.root_d1.value = sqrt(m2_scaled * m2_scaled * c.j21 / c.moments[1] + m3_scaled * m3_scaled * c.j31 / c.moments[2]);
  c.d3 = m1 * m1 * c.j31 / c.moments[0] + m2 * m2 * c.j32 / c.moments[1];
  c.g = sqrt(m1 * m1 + m2 * m2 + m3 * m3);
  return c;
}

/// The initial attitude, normalised.
template <class Real>
Quaternion4<Real> initial_attitude(const Input& in) {
  int exponent = -2000;
  for (double component : in.q) {
    const int e = exponent_of(component);
    if (e > exponent) exponent = e;
  }
  Real q[4];
  Real norm2 = 0.0;
  for (int k = 0; k < 4; ++k) {
    q[k] = ldexp(in.q[k], -exponent);
    norm2 = norm2 + q[k] * q[k];
  }
  const Real norm = sqrt(norm2);
  return {q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
}

/// Momentum constant in the body: rest, spheres, principal axes, symmetric tops about or across their axis.
template <class Real>
void build_fixed_axis(const Input& in, int moment_exponent, int momentum_exponent, Solution& out) {
  Real omega[3];
  Real rate2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    omega[k] = Real(ldexp(in.momentum[k], -momentum_exponent)) / ldexp(in.moments[k], -moment_exponent);
    rate2 = rate2 + omega[k] * omega[k];
  }
  const Real rate = sqrt(rate2);
  const bool at_rest = nearest(rate) == 0.0;
  const Quaternion4<Real> q0 = initial_attitude<Real>(in);
  Quaternion4<Real> axis{0.0, 0.0, 0.0, 1.0};
  if (!at_rest) axis = {0.0, omega[0] / rate, omega[1] / rate, omega[2] / rate};
  const Quaternion4<Real> turned = q0 * axis;
  out.chart = Chart::fixed_axis;
  out.fixed_axis = {scaled(rate / RealTraits<Real>::pi(), momentum_exponent - moment_exponent),
                    {nearest(q0.w), nearest(q0.x), nearest(q0.y), nearest(q0.z)},
                    {nearest(turned.w), nearest(turned.x), nearest(turned.y), nearest(turned.z)},
                    {in.momentum[0], in.momentum[1], in.momentum[2]}};
}

/// The constant part of attitude(t) = R (Re alpha, Re beta, Im beta, Im alpha) C / sqrt(N): R from the state at t = 0.
template <class Real>
OutputFrame frame_of(const Input& in, const Canonical<Real>& c, int momentum_exponent,
                     const Quaternion4<Real>& state_at_0) {
  const Quaternion4<Real>& cc = c.q_canonical_from_body;
  const Real norm2 = state_at_0.w * state_at_0.w + state_at_0.x * state_at_0.x + state_at_0.y * state_at_0.y +
                     state_at_0.z * state_at_0.z;
  const Real root = sqrt(norm2);
  const Quaternion4<Real> s{state_at_0.w / root, state_at_0.x / root, state_at_0.y / root, state_at_0.z / root};
  const Quaternion4<Real> r = initial_attitude<Real>(in) * (s * cc).conjugate();
  OutputFrame frame;
  const Quaternion4<Real> r_times_unit[4] = {// r, r i, r j, r k
                                             r,
                                             {-r.x, r.w, r.z, -r.y},
                                             {-r.y, -r.z, r.w, r.x},
                                             {-r.z, r.y, -r.x, r.w}};
  for (int column = 0; column < 4; ++column) {
    const Quaternion4<Real> q = r_times_unit[column] * cc;
    const Real entries[4] = {q.w, q.x, q.y, q.z};
    for (int row = 0; row < 4; ++row) frame.frame[column][row] = nearest(entries[row]);
  }
  const double g = ldexp(nearest(c.g), momentum_exponent);
  for (int k = 0; k < 3; ++k) frame.momentum_scale[k] = g * c.sign[k];
  frame.exchange_1_3 = c.long_axis_mode;
  return frame;
}

/// Least degree that keeps all coefficients of at least 2^-62.
inline int least_degree(const double (&polynomials)[kMaxDegree + 1][4]) {
  for (int n = kMaxDegree; n > 0; --n) {
    for (double coefficient : polynomials[n]) {
      if (__builtin_fabs(coefficient) > 0x1p-62) return n;
    }
  }
  return 0;
}

/// Value of polynomial i.
template <class Real>
Real horner(const Real (&a)[kMaxDegree + 1][4], int i, const Real& x) {
  Real sum = a[kMaxDegree][i];
  for (int n = kMaxDegree - 1; n >= 0; --n) sum = sum * x + a[n][i];
  return sum;
}

template <class Real>
void round_to_nearest(const Real (&a)[kMaxDegree + 1][4], double (&rounded)[kMaxDegree + 1][4]) {
  for (int n = 0; n <= kMaxDegree; ++n) {
    for (int i = 0; i < 4; ++i) rounded[n][i] = nearest(a[n][i]);
  }
}

/// Constants that both charts need.
template <class Real>
struct Common {
  Real lambda;        // signed, in units of 2^(momentum_exponent - moment_exponent)
  Real half_bracket;  // of rho
  Real w0;            // F(phi_0)
  Real y, y_prime;    // y is kInfinite for a symmetric top
  Real k_prime;
  Real reciprocal_k;
};

template <class Real>
Common<Real> common(const Canonical<Real>& c) {
  const Real i1 = c.moments[0], i2 = c.moments[1], i3 = c.moments[2];
  const int e1 = c.root_d1.exponent;
  const Real b31_scaled = sqrt(i3 / c.j31) * c.root_d1.value;
  const Real b31 = ldexp(b31_scaled, e1);
  const Real b13 = sqrt(i1 * c.d3 / c.j31);
  const Real b23 = sqrt(i2 * c.d3 / c.j32);
  Common<Real> s;
  s.lambda = ldexp(sqrt(c.j32 / (i1 * i2 * i3)) * c.root_d1.value, e1);
  if (c.long_axis_mode) {
    s.lambda = -s.lambda;
    s.half_bracket = (c.g / i1 + b31 * c.j31 / (i1 * i3)) * 0.5;
  } else {
    s.half_bracket = (c.g / i3 + b13 * b13 * c.j31 / ((c.g + b31) * i1 * i3)) * 0.5;
  }
  // cn = m1/B13, dn = m3/B31, sn = m2/B23 at t = 0
  s.w0 =
      c.m[1] == 0.0
          ? Real(0.0)
          : c.m[1] / b23 * rf_near_one<Real>({c.m[0] / b13, c.exponent_13}, {c.m[2] / b31_scaled, c.exponent_13 - e1});
  s.y = nearest(c.j21) == 0.0
            ? Real(kInfinite)
            : sqrt(i1 * c.j32) * carlson_rf_of_roots<Real>(sqrt(i3 * c.j21),
                                                           ldexp(c.g * sqrt(c.j21 * c.j31) / c.root_d1.value, -e1),
                                                           sqrt(i2 * c.j31));
  s.y_prime = b31 * carlson_rf_of_roots<Real>(b13, b23, c.g);
  s.k_prime = s.y + s.y_prime;
  const Scaled<Real> kc{sqrt(c.d2_13 * c.j31 / c.j32) / c.root_d1.value, c.exponent_13 - e1};
  if (nearest(kc.value) == 0.0) {
    s.reciprocal_k = 0.0;
  } else if (exponent_of(kc) > -60) {
    s.reciprocal_k = reciprocal_complete_k<Real>(ldexp(kc.value, kc.exponent));
  } else {
    s.reciprocal_k = 1.0 / rf_near_one<Real>({0.0, 0}, kc);
  }
  return s;
}

template <class Real>
void build_fourier(const Input& in, const Canonical<Real>& c, const Common<Real>& s, int moment_exponent,
                   int momentum_exponent, Solution& out) {
  const Real half_pi_over_k = RealTraits<Real>::pi() * s.reciprocal_k * 0.5;
  const Real p = exp(-(half_pi_over_k * s.y_prime));
  const Real r = exp(-(half_pi_over_k * s.y));

  // T_j + T_-j and T_j - T_-j at v = 0, from T_j = p^(j^2) r^(j (j - 1)), by their ratios.
  const Real p2 = p * p, r2 = r * r;
  FourierChart& f = out.fourier;
  Real even_sum[kMaxDegree + 1], even_difference[kMaxDegree + 1], odd_sum[kMaxDegree + 1],
      odd_difference[kMaxDegree + 1];
  Real a0 = 1.0, a1 = 0.0;
  Real t_plus = 1.0, t_minus = 1.0;           // T_j, T_-j
  Real plus_ratio = p, minus_ratio = p * r2;  // T_(j+1)/T_j = p^(2j+1) r^(2j), T_-(j+1)/T_-j = p^(2j+1) r^(2j+2)
  even_sum[0] = 1.0;
  even_difference[0] = 0.0;
  for (int j = 1;; ++j) {
    t_plus = t_plus * plus_ratio;
    t_minus = t_minus * minus_ratio;
    plus_ratio = plus_ratio * p2 * r2;
    minus_ratio = minus_ratio * p2 * r2;
    const int k = j / 2;
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    const Real sum = (t_plus + t_minus) * sign, difference = (t_plus - t_minus) * sign;
    if (j % 2 == 0) {
      a0 = a0 + sum;
      a1 = a1 + difference * static_cast<double>(j);
    }
    if (k <= kMaxDegree) {
      (j % 2 == 0 ? even_sum : odd_sum)[k] = sum;
      (j % 2 == 0 ? even_difference : odd_difference)[k] = difference;
    }
    if (j > 2 * kMaxDegree && !(j * nearest(t_plus) >= 0.01 * RealTraits<Real>::epsilon)) break;  // ends on NaN too
  }
  const Real nu = s.lambda * half_pi_over_k;
  const Real rho = s.half_bracket - nu * a1 / a0;

  // Multiples of v to powers of c = cos 2v: T_k, U_(k-1), U_k + U_(k-1), U_k - U_(k-1) (DLMF 18.5).
  static constexpr double kT[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {-1, 0, 2, 0}, {0, -3, 0, 4}};
  static constexpr double kU[4][4] = {{1, 0, 0, 0}, {0, 2, 0, 0}, {-1, 0, 4, 0}, {0, -4, 0, 8}};
  Real poly[kMaxDegree + 1][4];
  for (int n = 0; n <= kMaxDegree; ++n) {
    for (Real& coefficient : poly[n]) coefficient = 0.0;
    for (int k = n; k <= kMaxDegree; ++k) {
      const double u_previous = k == 0 ? 0.0 : kU[k - 1][n];
      poly[n][0] = poly[n][0] + even_sum[k] * kT[k][n];
      poly[n][1] = poly[n][1] + odd_sum[k] * (kU[k][n] + u_previous);
      poly[n][2] = poly[n][2] + even_difference[k] * u_previous;
      poly[n][3] = poly[n][3] - odd_difference[k] * (kU[k][n] - u_previous);
    }
  }
  round_to_nearest(poly, f.polynomial);
  f.degree = least_degree(f.polynomial);

  const int time_exponent = momentum_exponent - moment_exponent;
  const Real v_turns_at_0 = s.w0 * s.reciprocal_k * 0.25;
  f.v_whole_quarters_at_0 = __builtin_rint(nearest(v_turns_at_0 * 4.0));
  f.v_quarters_at_0 = nearest(v_turns_at_0 * 4.0 - f.v_whole_quarters_at_0);
  f.v_quarters_per_s = scaled(s.lambda * s.reciprocal_k, time_exponent);
  f.rho_quarters_per_s = scaled(rho * 2.0 / RealTraits<Real>::pi(), time_exponent);
  Real sin_v, cos_v;
  sincos_turns(v_turns_at_0, sin_v, cos_v);
  const Real cos_2v = 1.0 - sin_v * sin_v * 2.0, sin_2v = sin_v * cos_v * 2.0;
  f.frame = frame_of<Real>(in, c, momentum_exponent,
                           {horner(poly, 0, cos_2v), sin_v * horner(poly, 1, cos_2v), cos_v * horner(poly, 3, cos_2v),
                            sin_2v * horner(poly, 2, cos_2v)});
  out.chart = Chart::fourier;
}

template <class Real>
void build_hyperbolic(const Input& in, const Canonical<Real>& c, const Common<Real>& s, int moment_exponent,
                      int momentum_exponent, Solution& out) {
  const Real pi = RealTraits<Real>::pi();
  const Real pi_over_k_prime = pi / s.k_prime;
  const bool closed = nearest(s.reciprocal_k) > 0.0;
  const Real x_period = closed ? pi_over_k_prime / s.reciprocal_k : Real(kInfinite);
  const Real q = exp(-(x_period * 0.5));  // Q
  const Real z0_turns = s.y / (s.k_prime * 8.0);

  HyperbolicChart& h = out.hyperbolic;
  Real growing[kMaxDegree + 1][4], falling[kMaxDegree + 1][4];
  Real s0 = 0.0, s1 = 0.0;
  Real q_to_2n = 1.0, c_n = 1.0, q_to_n2 = 1.0;  // Q^(2n), Q^(n(n+1)), Q^(n^2)
  Real sin_1, cos_1;
  sincos_turns(z0_turns, sin_1, cos_1);
  const Real cos_2 = 1.0 - sin_1 * sin_1 * 2.0, sin_2 = sin_1 * cos_1 * 2.0;
  Real sin_n = sin_1, cos_n = cos_1;
  for (int n = 0;; ++n) {
    s0 = s0 + c_n * cos_n;
    s1 = s1 + c_n * sin_n * (2.0 * n + 1.0);
    if (n <= kMaxDegree) {
      const double sign = n % 2 == 0 ? 1.0 : -1.0;
      growing[n][0] = cos_n * q_to_n2;
      growing[n][1] = cos_n * q_to_n2 * sign;
      growing[n][2] = -(sin_n * q_to_n2);
      growing[n][3] = -(sin_n * q_to_n2 * sign);
      falling[n][0] = cos_n * c_n;
      falling[n][1] = -(cos_n * c_n * sign);
      falling[n][2] = sin_n * c_n;
      falling[n][3] = -(sin_n * c_n * sign);
    }
    q_to_n2 = q_to_n2 * q_to_2n * q;
    q_to_2n = q_to_2n * q * q;
    c_n = c_n * q_to_2n;
    const Real next = cos_n * cos_2 - sin_n * sin_2;
    sin_n = sin_n * cos_2 + cos_n * sin_2;
    cos_n = next;
    if (n >= kMaxDegree && !(n * nearest(c_n) >= 0.01 * RealTraits<Real>::epsilon)) break;  // ends on NaN too
  }
  const Real quarter = pi_over_k_prime * s.lambda * 0.25;  // pi lambda / (4 K')
  const Real rho = s.half_bracket - quarter * s.y * s.reciprocal_k + quarter * s1 / s0;

  round_to_nearest(growing, h.growing);
  round_to_nearest(falling, h.falling);
  const int growing_degree = least_degree(h.growing), falling_degree = least_degree(h.falling);
  h.degree = growing_degree > falling_degree ? growing_degree : falling_degree;

  const int time_exponent = momentum_exponent - moment_exponent;
  const Real x_at_0 = pi_over_k_prime * s.w0 * 0.5;
  const Real x_to_turns = s.y * s.reciprocal_k / (pi * 4.0);
  h.x_at_0 = two_part(x_at_0);
  h.x_per_s = scaled(pi_over_k_prime * s.lambda * 0.5, time_exponent);
  h.x_period = two_part(x_period);
  h.reciprocal_x_period = closed ? nearest(1.0 / x_period) : 0.0;
  h.root_of_nome = nearest(q);
  h.x_to_quarters = nearest(x_to_turns * 4.0);
  h.rho_quarters_per_s = scaled(rho * 2.0 / pi, time_exponent);

  // State at t = 0, as the evaluation has it: |x_at_0| <= x_period / 2 up to rounding.
  const double side = nearest(x_at_0) < 0.0 ? -1.0 : 1.0;
  const Real e = exp(-abs(x_at_0));
  const Real big_y = closed ? exp(abs(x_at_0) - x_period * 0.5) : Real(0.0);
  Real at_0[4];
  for (int i = 0; i < 4; ++i) at_0[i] = horner(growing, i, big_y) + e * horner(falling, i, e);
  const Real re_alpha = at_0[0], re_beta = at_0[1] * side, im_alpha = at_0[2] * side, im_beta = at_0[3];
  Real sin_p, cos_p;
  sincos_turns(x_at_0 * x_to_turns, sin_p, cos_p);
  h.frame = frame_of<Real>(in, c, momentum_exponent,
                           {re_alpha * cos_p - im_alpha * sin_p, re_beta * cos_p - im_beta * sin_p,
                            re_beta * sin_p + im_beta * cos_p, re_alpha * sin_p + im_alpha * cos_p});
  out.chart = Chart::hyperbolic;
}

/// For those who need no more than the solution.
struct NoFurther {
  template <class... Constants>
  void operator()(const Constants&...) const {}
};

/// Calls `further` with the exponents of the units, and with the canonical and the common constants where there are.
template <class Real, class Further = NoFurther>
void build(const Input& in, Solution& out, const Further& further = {}) {
  int momentum_exponent = -2000;
  for (double component : in.momentum) {
    const int e = exponent_of(component);
    if (e > momentum_exponent) momentum_exponent = e;
  }
  const int moment_exponent = exponent_of(in.moments[2]);
  const double(&i)[3] = in.moments;
  const double(&m)[3] = in.momentum;
  // m x omega = 0, tested by factors since products underflow (theta.md, "Canonical axes").
  if ((m[0] == 0.0 || m[1] == 0.0 || i[0] == i[1]) && (m[1] == 0.0 || m[2] == 0.0 || i[1] == i[2]) &&
      (m[0] == 0.0 || m[2] == 0.0 || i[0] == i[2])) {
    if (momentum_exponent == -2000) momentum_exponent = 0;
    build_fixed_axis<Real>(in, moment_exponent, momentum_exponent, out);
    further(moment_exponent, momentum_exponent);
    return;
  }
  const Canonical<Real> c = canonical<Real>(in, moment_exponent, momentum_exponent);
  const Common<Real> s = common<Real>(c);
  out.long_axis_mode = c.long_axis_mode;
  // The choice of chart, T = 2 K'/K. Either works within a factor of two of 1.
  if (nearest(s.k_prime) * nearest(s.reciprocal_k) >= 0.5) {
    build_fourier<Real>(in, c, s, moment_exponent, momentum_exponent, out);
  } else {
    build_hyperbolic<Real>(in, c, s, moment_exponent, momentum_exponent, out);
  }
  further(moment_exponent, momentum_exponent, c, s);
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
