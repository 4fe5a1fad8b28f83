#include "polhode/motion/legendre.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "polhode/base/double_double.hpp"
#include "polhode/elliptic/jacobi.hpp"
#include "polhode/elliptic/legendre_forms.hpp"

// "Leroy" is P. Leroy, "On an Article by Celledoni et al." (2020); the derivations of what is not literally there stand
// in legendre.md beside this file.

namespace polhode {
namespace {

// The body in the unit of its own size: moments and momentum scaled by powers of two (exactly), axes turned by S.
struct PreferredBody {
  Vector3 I;          // largest in [1, 2)
  Vector3 m;          // largest component in [1, 2); m1, m3 >= 0
  Quaternion s;       // preferred axes from the body's: v_p = s v s*
  Vector3 body_sign;  // m_body = body_sign * m_p * 2^momentum_exponent, component by component
  int momentum_exponent, rate_exponent;
  Quaternion q_inertial_from_body;  // unit
};

Vector3 scaled(const Vector3& v, int exponent) {
  return {std::ldexp(v[0], exponent), std::ldexp(v[1], exponent), std::ldexp(v[2], exponent)};
}

Quaternion normalized(const Quaternion& q) {
  const double largest = q.coeffs().cwiseAbs().maxCoeff();
  const int exponent = std::ilogb(largest);
  Eigen::Vector4d c = q.coeffs();
  for (double& x : c) x = std::ldexp(x, -exponent);
  return Quaternion(Eigen::Vector4d(c / c.norm()));
}

// Leroy, "An alternative quaternionic solution": the rotation S makes positive what must not change its sign, m1 in
// case (i), m3 in case (ii), both in case (iii). Both is always possible, so one rule serves all cases, and the phase
// then starts within a quarter period of 0.
PreferredBody preferred(const FreeBody& body) {
  PreferredBody p;
  const int inertia_exponent = std::ilogb(body.principal_moments[2]);
  const double largest = body.momentum_body.cwiseAbs().maxCoeff();
  p.momentum_exponent = largest > 0.0 ? std::ilogb(largest) : 0;
  p.rate_exponent = p.momentum_exponent - inertia_exponent;
  p.I = scaled(body.principal_moments, -inertia_exponent);
  p.m = scaled(body.momentum_body, -p.momentum_exponent);
  const bool flip1 = p.m[0] < 0.0, flip3 = p.m[2] < 0.0;
  if (flip1 && flip3) {
    p.s = Quaternion(0, 0, 1, 0);
    p.body_sign = {-1, 1, -1};
  } else if (flip1) {
    p.s = Quaternion(0, 0, 0, 1);
    p.body_sign = {-1, -1, 1};
  } else if (flip3) {
    p.s = Quaternion(0, 1, 0, 0);
    p.body_sign = {1, -1, -1};
  } else {
    p.s = Quaternion::Identity();
    p.body_sign = {1, 1, 1};
  }
  p.m = p.m.cwiseProduct(p.body_sign);
  p.q_inertial_from_body = normalized(body.q_inertial_from_body);
  return p;
}

// A phase that grows evenly: revolutions, reduced by whole ones while the product with time is still exact to 106 bits.
class Clock {
 public:
  Clock() = default;
  Clock(DoubleDouble revolutions_per_s, double at_zero) : rate_(revolutions_per_s), at_zero_(at_zero) {}

  /// Revolutions at t = high + low seconds, modulo 1, from -1/2 to 1/2.
  double at(double t_high, double t_low) const {
    const DoubleDouble product = two_product(rate_.high, t_high);
    const double rest = rate_.low * t_high + rate_.high * t_low;
    const double whole = std::nearbyint(product.high), whole_low = std::nearbyint(product.low);
    const double phase =
        (product.high - whole) + ((product.low - whole_low) + (rest - std::nearbyint(rest)) + at_zero_);
    return phase - std::nearbyint(phase);
  }

 private:
  DoubleDouble rate_;
  double at_zero_ = 0.0;
};

Quaternion about(const Vector3& axis, double half_angle) {
  Quaternion q;
  q.w() = std::cos(half_angle);
  q.vec() = std::sin(half_angle) * axis;
  return q;
}

DoubleDouble square(double a) { return two_product(a, a); }
DoubleDouble difference(double a, double b) { return two_sum(a, -b); }
// (I_j - I_h) / I_j m_j^2, the terms of the sums for Delta_h.
DoubleDouble delta_term(double m, double Ij, double Ih) { return square(m) * difference(Ij, Ih) / Ij; }

// m x omega = 0, told from the factors since products underflow: m stays and the body turns evenly about it. Rest,
// spheres, every principal axis including the middle one, symmetric tops about or across their axis.
bool momentum_is_constant(const Vector3& I, const Vector3& m) {
  const auto vanishes = [&](int i, int j) { return m[i] == 0.0 || m[j] == 0.0 || I[i] == I[j]; };
  return vanishes(0, 1) && vanishes(1, 2) && vanishes(2, 0);
}

class ConstantMomentum final : public Motion {
 public:
  explicit ConstantMomentum(const PreferredBody& p, const Vector3& momentum_body)
      : q0_(p.q_inertial_from_body), momentum_body_(momentum_body) {
    const Vector3 omega = p.m.cwiseQuotient(p.I).cwiseProduct(p.body_sign);
    DoubleDouble square_sum = 0.0;
    for (int i = 0; i < 3; ++i) {
      const DoubleDouble rate = DoubleDouble(p.m[i]) / p.I[i];
      square_sum = square_sum + rate * rate;
    }
    if (omega.isZero(0.0)) return;
    axis_ = omega.normalized();
    half_turn_ = Clock(ldexp(sqrt(square_sum) / (kPi * 4.0), p.rate_exponent), 0.0);
  }

  State at(double t_high_s, double t_low_s) const override {
    const double half_angle = 2.0 * std::numbers::pi * half_turn_.at(t_high_s, t_low_s);
    return {(q0_ * about(axis_, half_angle)).normalized(), momentum_body_};
  }

 private:
  Quaternion q0_;
  Vector3 momentum_body_;
  Vector3 axis_ = Vector3::UnitZ();
  Clock half_turn_;  // of the half angle
};

// What all three cases share: Q_t = R Y_t P_t S (Leroy, "An alternative quaternionic solution"). P_t turns m onto the
// axis e_d whose component stays positive, Y_t turns by psi about it, R is fixed by the attitude at t = 0.
class Frames {
 public:
  Frames(const PreferredBody& p, int d)
      : d_(d), s_(p.s), body_sign_(p.body_sign), momentum_exponent_(p.momentum_exponent) {
    r_ = p.q_inertial_from_body * s_.conjugate() * onto_axis(p.m, p.m.norm()).conjugate();
  }

  State state(const Vector3& m, double G, double half_psi) const {
    const Quaternion y = about(Vector3::Unit(d_), half_psi);
    const Quaternion q = r_ * y * onto_axis(m, G) * s_;
    return {q.normalized(), scaled(m.cwiseProduct(body_sign_), momentum_exponent_)};
  }

 private:
  // Leroy, "Case (i)" and "Case (ii)": p0 = sqrt((1 + m_d/G)/2), the vector part along m x e_d, p_d = 0.
  Quaternion onto_axis(const Vector3& m, double G) const {
    Quaternion p;
    p.w() = G + m[d_];
    p.vec() = m.cross(Vector3::Unit(d_));
    return p.normalized();
  }

  int d_;
  Quaternion s_, r_;
  Vector3 body_sign_;
  int momentum_exponent_;
};

// The invariants, in double-double. Each pair of components is scaled by its own power of two, so that squares of tiny
// components do not underflow.
struct Invariants {
  DoubleDouble G, twice_energy;  // |m|, and 2 T rad^2
  DoubleDouble root_delta[3];    // sqrt |Delta_j|; Delta_1 > 0 > Delta_3
  DoubleDouble I21, I31, I32;
  int sign_delta2;  // which case: -1 (i), 1 (ii), 0 (iii)
};

Invariants invariants(const PreferredBody& p) {
  const double I1 = p.I[0], I2 = p.I[1], I3 = p.I[2];
  // Leroy, "The quantity Delta_j": sums of terms of one sign for Delta_1 and -Delta_3, and Delta_2 with two signs.
  struct Pair {
    double a, b;
    int exponent;
  };
  // m_i and m_j of the terms that differ from 0, scaled: (I_i - I_h) and (I_j - I_h) may vanish for symmetric tops.
  const auto pair = [&](int i, int j, int h) {
    const double a = p.I[i] == p.I[h] ? 0.0 : p.m[i], b = p.I[j] == p.I[h] ? 0.0 : p.m[j];
    const double largest = std::max(std::abs(a), std::abs(b));
    const int exponent = largest > 0.0 ? std::ilogb(largest) : 0;
    return Pair{std::ldexp(a, -exponent), std::ldexp(b, -exponent), exponent};
  };
  Invariants v;
  v.I21 = difference(I2, I1);
  v.I31 = difference(I3, I1);
  v.I32 = difference(I3, I2);
  v.G = sqrt(square(p.m[0]) + square(p.m[1]) + square(p.m[2]));
  v.twice_energy = square(p.m[0]) / I1 + square(p.m[1]) / I2 + square(p.m[2]) / I3;
  const Pair m23 = pair(1, 2, 0), m12 = pair(0, 1, 2), m13 = pair(0, 2, 1);
  v.root_delta[0] = ldexp(sqrt(delta_term(m23.a, I2, I1) + delta_term(m23.b, I3, I1)), m23.exponent);
  v.root_delta[2] = ldexp(sqrt(-(delta_term(m12.a, I1, I3) + delta_term(m12.b, I2, I3))), m12.exponent);
  const DoubleDouble negative = delta_term(m13.a, I1, I2), positive = delta_term(m13.b, I3, I2);
  const DoubleDouble delta2 = positive + negative;
  // Below the rounding of double-double the two sides of the separatrix cannot be told apart, nor from the separatrix.
  const bool resolved = abs(delta2).high > 0x1p-98 * (positive - negative).high;
  v.sign_delta2 = !resolved ? 0 : (delta2.high > 0.0 ? 1 : -1);
  v.root_delta[1] = ldexp(sqrt(abs(delta2)), m13.exponent);
  return v;
}

// Cases (i) and (ii). They differ in which axis d carries dn: 1 in case (i), 3 in case (ii); o is the other one, which
// carries cn. With u = nu - lambda t of Leroy (his lambda is -lambda_3 or -lambda_1 here, sigma being +1 after S):
//   m_d = B_d dn u,  m_2 = B_2 sn u,  m_o = B_o cn u.
class Libration final : public Motion {
 public:
  Libration(const PreferredBody& p, const Invariants& v)
      : d_(v.sign_delta2 < 0 ? 0 : 2), o_(2 - d_), frames_(p, d_), kc_(complementary_modulus(v)), jacobi_(kc_.high) {
    const DoubleDouble I_d = p.I[d_], I_o = p.I[o_], I_2 = p.I[1];
    const DoubleDouble I_d2 = d_ == 2 ? v.I32 : v.I21;
    const DoubleDouble root_delta_d = v.root_delta[d_], root_delta_o = v.root_delta[o_];

    // Leroy, "Notation": B_13 and B_31 divided by G, B_21 or B_23.
    const DoubleDouble a = root_delta_o * sqrt(I_d / v.I31) / v.G;
    const DoubleDouble b_o = root_delta_d * sqrt(I_o / v.I31) / v.G;
    G_ = v.G.high;
    a_ = a.high;
    b_o_ = b_o.high;
    b_2_ = (root_delta_d * sqrt(I_2 / I_d2) / v.G).high;

    // The coefficient under Leroy's arctg, "Case (i)" and "Case (ii)": sqrt(I2 I31 / (I_o I_d2)).
    const DoubleDouble w = sqrt(I_2 * v.I31 / (I_o * I_d2));
    w_ = w.high;
    const DoubleDouble g = w * b_o * b_o;
    g_ = g.high;

    // legendre.md (3): H(K), K and the mean rates.
    const DoubleDouble H_quarter = g / a * complete_integral(kc_, 1.0 / a, DoubleDouble(1.0), DoubleDouble(0.0));
    const DoubleDouble K = complete_integral(kc_, DoubleDouble(1.0), DoubleDouble(1.0), DoubleDouble(1.0));
    const DoubleDouble lambda = root_delta_o * sqrt(I_d2 / (I_d * I_o * I_2));
    H_quarter_ = H_quarter.high;
    side_ = d_ == 2 ? -1.0 : 1.0;
    const double x0 = initial_half_period_fraction(p.m);
    const DoubleDouble mean_rate = v.twice_energy / v.G + lambda / K * H_quarter * side_;
    polhode_ = Clock(ldexp(lambda / (K * 4.0), p.rate_exponent), 0.5 * x0);
    half_psi_ = Clock(ldexp(mean_rate / (kPi * 4.0), p.rate_exponent), 0.0);
    periodic_at_zero_ = periodic(x0, jacobi_.at_half_period_fraction(x0));
  }

  State at(double t_high_s, double t_low_s) const override {
    double x = 2.0 * polhode_.at(t_high_s, t_low_s);  // u / 2K, modulo 2
    double sign = 1.0;
    if (std::abs(x) > 0.5) {
      x -= std::copysign(1.0, x);
      sign = -1.0;
    }
    const JacobiValues j = jacobi_.at_half_period_fraction(x);
    Vector3 m;
    m[d_] = G_ * a_ * j.dn;
    m[o_] = sign * G_ * b_o_ * j.cn;
    m[1] = sign * G_ * b_2_ * j.sn;
    const double half_psi =
        2.0 * std::numbers::pi * half_psi_.at(t_high_s, t_low_s) + 0.5 * side_ * (periodic(x, j) - periodic_at_zero_);
    return frames_.state(m, G_, half_psi);
  }

 private:
  // Leroy, "The elliptic modulus": m_c = Delta_2 I31 / (Delta_3 I21) in case (i), Delta_2 I31 / (Delta_1 I32) in (ii).
  DoubleDouble complementary_modulus(const Invariants& v) const {
    return v.root_delta[1] / v.root_delta[o_] * sqrt(v.I31 / (d_ == 2 ? v.I32 : v.I21));
  }

  // u / 2K at t = 0, from the quotient of the components that cn and sn carry (Leroy, "Phase and initial value").
  double initial_half_period_fraction(const Vector3& m) const {
    double sine = std::abs(m[1]), cosine = w_ * m[o_];
    const double K = jacobi_.quarter_period(), kc = kc_.high;
    const double length = std::hypot(sine, cosine);
    sine /= length;
    cosine /= length;
    double x;
    if (sine * sine * kc < cosine * cosine) {
      x = 0.5 * incomplete_f(sine, cosine, kc) / K;
    } else {  // nearer to K: by K - u, whose tangent of the amplitude is 1 / (kc tan) (DLMF 19.7.16 and 22.4.3)
      const double complement_length = std::hypot(cosine, kc * sine);
      x = 0.5 - 0.5 * incomplete_f(cosine / complement_length, kc * sine / complement_length, kc) / K;
    }
    return std::copysign(x, m[1]);
  }

  // The part of psi that returns with the period of the polhode: legendre.md (4).
  double periodic(double x, const JacobiValues& j) const {
    const double sn = std::abs(j.sn), kc = kc_.high;
    const double h = std::sqrt(kc / j.dn);
    const double rj = carlson_rj_of_roots(sn * h, h, 1.0 / h, std::hypot(sn, a_ * j.cn) * h) * h * h * h;
    const double rest_of_third_kind = g_ * a_ * j.cn * j.cn * (j.cn / kc) * rj / 3.0;
    const double transverse_square = b_o_ * b_o_ * j.cn * j.cn + b_2_ * b_2_ * sn * sn;  // 1 - a^2 dn^2
    const double elementary = std::atan2(w_ * sn * j.cn * transverse_square,
                                         (1.0 + a_ * j.dn) * (a_ * j.dn * j.cn * j.cn + w_ * w_ * sn * sn));
    return std::copysign(H_quarter_ * (1.0 - 2.0 * std::abs(x)) - rest_of_third_kind - elementary, x);
  }

  int d_, o_;
  Frames frames_;
  DoubleDouble kc_;
  Jacobi jacobi_;
  double G_, a_, b_o_, b_2_, w_, g_, H_quarter_, side_, periodic_at_zero_;
  Clock polhode_, half_psi_;
};

// Case (iii), the separatrix: hyperbolic functions (Leroy, "Case (iii)" in all three sections; sigma' = sigma'' = 1
// after S).
class Separatrix final : public Motion {
 public:
  Separatrix(const PreferredBody& p, const Invariants& v)
      : b_13_((v.root_delta[2] * sqrt(p.I[0] / v.I31)).high),
        b_31_((v.root_delta[0] * sqrt(p.I[2] / v.I31)).high),
        d_(b_13_ < b_31_ ? 0 : 2),  // "we rotate onto e1 if and only if B13 < B31"
        frames_(p, d_),
        G_(v.G.high) {
    const double b_d = d_ == 0 ? b_13_ : b_31_, b_o = d_ == 0 ? b_31_ : b_13_;
    // (G - B_d) / B_o without its subtraction, and the sign of the arctg.
    coefficient_ = (d_ == 0 ? 1.0 : -1.0) * b_o / (G_ + b_d);
    const double lambda_2 = (v.root_delta[0] * v.root_delta[2] / v.G / sqrt(DoubleDouble(p.I[0]) * p.I[2])).high;
    lambda_ = std::ldexp(lambda_2, p.rate_exponent);
    u0_ = std::asinh(p.m[1] / std::hypot(p.m[0], p.m[2]));  // argth(m2 / G)
    half_psi_ = Clock(ldexp(v.G / p.I[1] / (kPi * 4.0), p.rate_exponent), 0.0);
  }

  State at(double t_high_s, double t_low_s) const override {
    const double u = u0_ + (lambda_ * t_high_s + lambda_ * t_low_s);
    const double sech = 1.0 / std::cosh(u);
    const Vector3 m(b_13_ * sech, G_ * std::tanh(u), b_31_ * sech);
    const double half_psi = 2.0 * std::numbers::pi * half_psi_.at(t_high_s, t_low_s) + arc(u) - arc(u0_);
    return frames_.state(m, G_, half_psi);
  }

 private:
  double arc(double u) const { return std::atan(coefficient_ * std::tanh(0.5 * u)); }

  double b_13_, b_31_;
  int d_;
  Frames frames_;
  double G_, coefficient_, lambda_, u0_;
  Clock half_psi_;
};

}  // namespace

std::unique_ptr<Motion> make_legendre(const FreeBody& body) {
  const PreferredBody p = preferred(checked(body));
  if (momentum_is_constant(p.I, p.m)) return std::make_unique<ConstantMomentum>(p, body.momentum_body);
  const Invariants v = invariants(p);
  if (v.sign_delta2 == 0) return std::make_unique<Separatrix>(p, v);
  return std::make_unique<Libration>(p, v);
}

}  // namespace polhode
