#include "rivals/celledoni.hpp"

#include <cmath>
#include <numbers>

#include "polhode/elliptic/legendre_forms.hpp"

namespace polhode::rivals {

// Leroy, "Notation", "The quantity Delta_j" and "The elliptic modulus".
EulerSolution::EulerSolution(const FreeBody& body) : I(checked(body).principal_moments) {
  const Vector3& m = body.momentum_body;
  const double I21 = I[1] - I[0], I31 = I[2] - I[0], I32 = I[2] - I[1], product = I[0] * I[1] * I[2];
  const double m1 = m[0] * m[0], m2 = m[1] * m[1], m3 = m[2] * m[2];
  G = m.norm();
  twice_energy = m1 / I[0] + m2 / I[1] + m3 / I[2];
  Delta1 = m2 * I21 / I[1] + m3 * I31 / I[2];
  Delta2 = -m1 * I21 / I[0] + m3 * I32 / I[2];
  Delta3 = -m1 * I31 / I[0] - m2 * I32 / I[1];
  B13 = std::sqrt(-I[0] * Delta3 / I31);
  B31 = std::sqrt(I[2] * Delta1 / I31);
  B21 = std::sqrt(I[1] * Delta1 / I21);
  B23 = std::sqrt(-I[1] * Delta3 / I32);
  which = Delta2 < 0.0 ? Case::i : (Delta2 > 0.0 ? Case::ii : Case::iii);
  sigma = std::copysign(1.0, which == Case::i ? m[0] : m[2]);
  sigma_one = std::copysign(1.0, m[0]);
  switch (which) {
    case Case::i:
      kc = std::sqrt(Delta2 * I31 / (Delta3 * I21));
      lambda = -sigma * std::sqrt(-Delta3 * I21 / product);
      break;
    case Case::ii:
      kc = std::sqrt(Delta2 * I31 / (Delta1 * I32));
      lambda = -sigma * std::sqrt(Delta1 * I32 / product);
      break;
    case Case::iii:
      lambda = sigma_one * sigma / G * std::sqrt(-Delta1 * Delta3 / (I[0] * I[2]));
      break;
  }
  jacobi_ = Jacobi(kc);
  nu = phase(m);
}

// Leroy, "Phase and initial value".
double EulerSolution::phase(const Vector3& m0) const {
  if (which == Case::iii) return -std::atanh(m0[1] / G);
  const double amplitude =
      which == Case::i ? std::atan2(m0[1] * B31, m0[2] * B21) : std::atan2(m0[1] * B13, m0[0] * B23);
  const double turns = std::nearbyint(amplitude / std::numbers::pi);
  const double rest = amplitude - turns * std::numbers::pi;
  return 2.0 * jacobi_.quarter_period() * turns +
         std::copysign(incomplete_f(std::abs(std::sin(rest)), std::abs(std::cos(rest)), kc), rest);
}

EulerSolution::Sample EulerSolution::at(double t_s) const {
  Sample s{};
  s.w = lambda * t_s - nu;
  if (which == Case::iii) {
    const double sech = 1.0 / std::cosh(s.w);
    s.m = {sigma_one * B13 * sech, G * std::tanh(s.w), sigma * B31 * sech};
    return s;
  }
  const double x = s.w / (2.0 * jacobi_.quarter_period());
  s.half_periods = std::nearbyint(x);
  s.reduced = jacobi_.at_half_period_fraction(x - s.half_periods);
  const double sign = std::fmod(s.half_periods, 2.0) == 0.0 ? 1.0 : -1.0;
  const double sn = sign * s.reduced.sn, cn = sign * s.reduced.cn, dn = s.reduced.dn;
  s.m = which == Case::i ? Vector3(sigma * B13 * dn, -B21 * sn, B31 * cn)
                         : Vector3(B13 * cn, -B23 * sn, sigma * B31 * dn);
  return s;
}

double EulerSolution::third_kind(const Sample& s, double n, double one_minus_n) const {
  const double complete = complete_integral(kc, std::sqrt(one_minus_n), 1.0, 1.0);
  return 2.0 * s.half_periods * complete +
         std::copysign(incomplete_pi(std::abs(s.reduced.sn), s.reduced.cn, n, one_minus_n, kc), s.reduced.sn);
}

double EulerSolution::arctg_sc(const Sample& s, double c) {
  return std::numbers::pi * s.half_periods + std::atan2(c * s.reduced.sn, s.reduced.cn);
}

namespace {

// Leroy, "Integration of the rotation matrix".
class MatrixBasis final : public Motion {
 public:
  explicit MatrixBasis(const FreeBody& body) : euler_(body) {
    const EulerSolution::Sample start = euler_.at(0.0);
    psi0_ = psi(start, 0.0);
    r_ = body.q_inertial_from_body.normalized().toRotationMatrix() * basis(body.momentum_body).transpose();
  }

  State at(double t_high_s, double t_low_s) const override {
    const double t = t_high_s + t_low_s;
    const EulerSolution::Sample s = euler_.at(t);
    const Eigen::AngleAxisd y(psi(s, t) - psi0_, Vector3::UnitX());
    return {Quaternion(Matrix3(r_ * y * basis(s.m))), s.m};
  }

 private:
  // P_t: rows m, dm/dt and m x dm/dt, each of length 1.
  Matrix3 basis(const Vector3& m) const {
    const Vector3 first = m / euler_.G;
    const Vector3 rate = m.cross(m.cwiseQuotient(euler_.I));
    const Vector3 second = rate / rate.norm();  // 0 / 0 where the basis is lost
    Matrix3 p;
    p << first.transpose(), second.transpose(), first.cross(second).transpose();
    return p;
  }

  double psi(const EulerSolution::Sample& s, double t) const {
    const auto& e = euler_;
    const double even = e.twice_energy / e.G * t;
    if (e.which == EulerSolution::Case::iii) return even;  // Delta_2 = 0
    // 1 - n without its subtraction: -I3 Delta_2 / (I2 |Delta_3|) and I1 Delta_2 / (I2 Delta_1).
    const bool case_i = e.which == EulerSolution::Case::i;
    const double b = case_i ? e.B23 : e.B21;
    const double one_minus_n =
        case_i ? e.I[2] * e.Delta2 / (e.I[1] * e.Delta3) : e.I[0] * e.Delta2 / (e.I[1] * e.Delta1);
    return even + e.Delta2 / (e.lambda * e.G * e.I[1]) * e.third_kind(s, (e.G / b) * (e.G / b), one_minus_n);
  }

  EulerSolution euler_;
  double psi0_;
  Matrix3 r_;
};

// Leroy, "Integration of the quaternion" and, for case (ii), "An alternative quaternionic solution" without its
// rotation S.
class CfszQuaternion final : public Motion {
 public:
  explicit CfszQuaternion(const FreeBody& body) : euler_(body) {
    psi0_ = psi(euler_.at(0.0), 0.0);
    r_ = body.q_inertial_from_body.normalized() * onto_e3(body.momentum_body).conjugate();
  }

  State at(double t_high_s, double t_low_s) const override {
    const double t = t_high_s + t_low_s;
    const EulerSolution::Sample s = euler_.at(t);
    const double half = 0.5 * (psi(s, t) - psi0_);
    return {r_ * Quaternion(std::cos(half), 0.0, 0.0, std::sin(half)) * onto_e3(s.m), s.m};
  }

 private:
  Quaternion onto_e3(const Vector3& m) const {
    const double root = std::sqrt(2.0 * euler_.G * (euler_.G + m[2]));
    return {(euler_.G + m[2]) / root, m[1] / root, -m[0] / root, 0.0};
  }

  // psi' = G/I3 - Delta_3 / (G I3) / (1 + m3/G).
  double psi(const EulerSolution::Sample& s, double t) const {
    const auto& e = euler_;
    const double coefficient = -e.Delta3 / (e.lambda * e.G * e.I[2]);
    const double g2_b2 = (e.G / e.B13) * (e.G / e.B13);  // 1 / (1 - a^2) with a = B31 / G
    const double ratio = e.B31 / e.B13;
    double integral = 0.0;  // of dw / (1 + m3/G)
    switch (e.which) {
      case EulerSolution::Case::i: {  // [BF54] 361.54 and the document's sign of f
        const double sd = (std::fmod(s.half_periods, 2.0) == 0.0 ? 1.0 : -1.0) * s.reduced.sn / s.reduced.dn;
        const double f = -e.B31 * (e.B13 / e.B21) * std::atan(e.B21 / e.B13 * sd);
        integral = g2_b2 * (e.third_kind(s, -ratio * ratio, g2_b2) + f / e.G);
        break;
      }
      case EulerSolution::Case::ii: {  // equation (5)
        const double n = -e.I[2] * (e.I[1] - e.I[0]) / (e.I[0] * (e.I[2] - e.I[1]));
        const double Pi = e.third_kind(s, n, 1.0 - n);
        integral = g2_b2 * (Pi - e.sigma * e.B31 / e.G * (e.B13 / e.B23) * EulerSolution::arctg_sc(s, e.B23 / e.B13));
        break;
      }
      case EulerSolution::Case::iii:  // equation (6)
        integral = s.w + 2.0 * e.sigma * ratio * std::atan((e.sigma * e.B31 - e.G) / e.B13 * std::tanh(0.5 * s.w));
        break;
    }
    return e.G / e.I[2] * t + coefficient * integral;
  }

  EulerSolution euler_;
  double psi0_;
  Quaternion r_;
};

}  // namespace

std::unique_ptr<Motion> make_matrix_basis(const FreeBody& body) { return std::make_unique<MatrixBasis>(body); }

std::unique_ptr<Motion> make_cfsz_quaternion(const FreeBody& body) { return std::make_unique<CfszQuaternion>(body); }

}  // namespace polhode::rivals
