// P. Leroy, "On an Article by Celledoni et al." (2020): its corrections and formulas, each against something that does
// not know them: Euler's equations, numerical quadrature, Boost's elliptic functions. And the approaches that it gives
// up.

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/ellint_3.hpp>
#include <boost/math/special_functions/ellint_rj.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "polhode/motion/legendre.hpp"
#include "rivals/celledoni.hpp"

namespace polhode {
namespace {

using rivals::EulerSolution;
using rivals::make_cfsz_quaternion;
using rivals::make_matrix_basis;

using boost::math::ellint_1;
using boost::math::ellint_3;
using boost::math::jacobi_cn;
using boost::math::jacobi_dn;
using boost::math::jacobi_sn;

const Quaternion kAttitude(0.5, -0.5, 0.1, 0.7);

double quadrature(const std::function<double(double)>& f, double from, double to) {
  double sum = 0.0;
  for (int i = 0; i < 16; ++i) {
    const double a = std::lerp(from, to, i / 16.0), b = std::lerp(from, to, (i + 1) / 16.0);
    sum += boost::math::quadrature::gauss_kronrod<double, 31>::integrate(f, a, b, 0);
  }
  return sum;
}

/// Bodies of each case in every octant; case (iii) has Delta_2 = 0 exactly.
std::vector<FreeBody> bodies(EulerSolution::Case which) {
  std::vector<FreeBody> result;
  for (const double s1 : {1.0, -1.0}) {
    for (const double s2 : {1.0, -1.0}) {
      for (const double s3 : {1.0, -1.0}) {
        const Vector3 s(s1, s2, s3);
        switch (which) {
          case EulerSolution::Case::i:
            result.push_back({{1.0, 2.0, 2.5}, kAttitude, Vector3(1.5, 0.7, 0.6).cwiseProduct(s)});
            break;
          case EulerSolution::Case::ii:
            result.push_back({{1.0, 1.3, 2.0}, kAttitude, Vector3(0.4, 0.7, 1.6).cwiseProduct(s)});
            break;
          case EulerSolution::Case::iii:
            result.push_back({{3.0, 6.0, 8.0}, kAttitude, Vector3(1.0, 0.5, 2.0).cwiseProduct(s)});
            break;
        }
      }
    }
  }
  return result;
}

constexpr EulerSolution::Case kCases[] = {EulerSolution::Case::i, EulerSolution::Case::ii, EulerSolution::Case::iii};

Vector3 euler_rate(const FreeBody& b, const Vector3& m) { return m.cross(m.cwiseQuotient(b.principal_moments)); }

TEST(Leroy, SignsOfLambdaAndOfCaseThreeSatisfyEulersEquations) {
  for (const auto which : kCases) {
    for (const FreeBody& body : bodies(which)) {
      const EulerSolution e(body);
      ASSERT_EQ(e.which, which);
      // m1 and m3 of either sign are reached in case (iii), which CFSZ07 with its one sign does not.
      EXPECT_LE((e.at(0.0).m - body.momentum_body).norm(), 1e-15 * e.G);
      for (const double t : {-3.0, 0.0, 0.4, 2.0, 11.0}) {
        constexpr double kStep = 1e-4;
        const auto m = [&](double dt) { return e.at(t + dt).m; };
        const Vector3 rate = (8.0 * (m(kStep) - m(-kStep)) - (m(2 * kStep) - m(-2 * kStep))) / (12.0 * kStep);
        const Vector3 wanted = euler_rate(body, m(0.0));
        EXPECT_LE((rate - wanted).norm(), 1e-10 * e.G) << "t=" << t;
        EXPECT_LE(std::abs(m(0.0).norm() - e.G), 1e-14 * e.G);
      }
      // With CFSZ07's sign of lambda the body would move backwards.
      const Vector3 backwards = (e.at(-1e-5).m - e.at(1e-5).m) / 2e-5;
      EXPECT_GT((backwards - euler_rate(body, body.momentum_body)).norm(), 0.1 * e.G);
    }
  }
}

TEST(Leroy, IntegralFive) {
  for (const double k : {0.0, 0.3, 0.9, 0.999}) {
    for (const double a : {0.0, 0.2, 0.8, 0.99}) {
      for (const double u : {0.1, 0.9, 1.4}) {  // below K, where am u < pi/2 and arctg is on its main branch
        const double am = std::atan2(jacobi_sn(k, u), jacobi_cn(k, u));
        const double q = (a * a * (k * k - 1) + 1) / (1 - a * a);
        const double closed =
            (ellint_3(k, a * a * k * k / (a * a - 1), am) - a / std::sqrt(q) * std::atan(std::sqrt(q) * std::tan(am))) /
            (1 - a * a);
        const double wanted = quadrature([&](double x) { return 1 / (1 + a * jacobi_dn(k, x)); }, 0.0, u);
        EXPECT_NEAR(closed, wanted, 2e-13) << "k=" << k << " a=" << a << " u=" << u;
      }
    }
  }
}

TEST(Leroy, IntegralSix) {
  for (const double a : {0.0, 0.2, 0.8, 0.99}) {
    for (const double u : {-2.0, 0.1, 5.0, 30.0}) {
      const double root = std::sqrt(1 - a * a);
      const double closed = u + 2 * a / root * std::atan((a - 1) / root * std::tanh(u / 2));
      const double wanted = quadrature([&](double x) { return 1 / (1 + a / std::cosh(x)); }, 0.0, u);
      EXPECT_NEAR(closed, wanted, 2e-13 * (1 + std::abs(u))) << "a=" << a << " u=" << u;
    }
  }
}

TEST(Leroy, NOfPiInTheMatrixForm) {
  for (const auto which : {EulerSolution::Case::i, EulerSolution::Case::ii}) {
    for (const FreeBody& body : bodies(which)) {
      const EulerSolution e(body);
      const bool case_i = which == EulerSolution::Case::i;
      const double k = std::sqrt(1 - e.kc * e.kc), b = case_i ? e.B23 : e.B21, other = case_i ? e.B21 : e.B23;
      const auto psi_rate = [&](double t) {
        const double m2 = e.at(t).m[1];
        return e.Delta2 / (e.G * e.I[1]) / (1 - e.G * e.G / (e.B21 * e.B21 * e.B23 * e.B23) * m2 * m2);
      };
      // From m2 = 0, t = nu / lambda, over less than a quarter period.
      const double start = e.nu / e.lambda, span = 0.8 * ellint_1(k) / std::abs(e.lambda);
      const double u = e.lambda * span, am = std::atan2(jacobi_sn(k, u), jacobi_cn(k, u));
      const auto closed = [&](double n) { return e.Delta2 / (e.lambda * e.G * e.I[1]) * ellint_3(k, n, am); };
      const double wanted = quadrature(psi_rate, start, start + span);
      EXPECT_NEAR(closed(e.G * e.G / (b * b)), wanted, 1e-12);
      EXPECT_GT(std::abs(closed(e.G * e.G / (b * b * other * other)) - wanted), 1e-3);  // the factor of m2^2 itself
    }
  }
}

TEST(Leroy, SignOfF) {
  for (const FreeBody& body : bodies(EulerSolution::Case::i)) {
    const EulerSolution e(body);
    const double k = std::sqrt(1 - e.kc * e.kc), a = e.B31 / e.G;
    for (const double u : {0.5, 1.2}) {
      const double am = std::atan2(jacobi_sn(k, u), jacobi_cn(k, u));
      const double f = -e.B31 * e.B13 / e.B21 * std::atan(e.B21 / e.B13 * jacobi_sn(k, u) / jacobi_dn(k, u));
      const double Pi = ellint_3(k, -e.B31 * e.B31 / (e.B13 * e.B13), am);
      const double factor = e.G * e.G / (e.B13 * e.B13);
      const double wanted = quadrature([&](double x) { return 1 / (1 + a * jacobi_cn(k, x)); }, 0.0, u);
      EXPECT_NEAR(factor * (Pi + f / e.G), wanted, 1e-12);
      EXPECT_GT(std::abs(factor * (Pi - f / e.G) - wanted), 0.1);
    }
  }
}

TEST(Leroy, PsiOfTheAlternativeQuaternionicSolution) {
  for (const auto which : kCases) {
    // m1 and m3 positive, as the rotation S makes them.
    const FreeBody body = bodies(which).front();
    const EulerSolution e(body);
    const double I1 = e.I[0], I2 = e.I[1], I3 = e.I[2], I21 = I2 - I1, I31 = I3 - I1, I32 = I3 - I2;
    const double k = std::sqrt(1 - e.kc * e.kc);
    for (const double w : {-0.9, 0.3, 1.1}) {  // lambda t - nu, from 0
      const double t0 = e.nu / e.lambda, t = w / e.lambda;
      const auto wanted = [&](int d) {
        return quadrature(
            [&](double s) {
              const double m = e.at(s).m[d];
              return (e.twice_energy + e.G * m / e.I[d]) / (e.G + m);
            },
            t0, t0 + t);
      };
      const double am = std::atan2(jacobi_sn(k, w), jacobi_cn(k, w));
      switch (which) {
        case EulerSolution::Case::i:
          EXPECT_NEAR(e.G / I1 * t - e.G * I31 / (e.lambda * I1 * I3) * ellint_3(k, -I1 * I32 / (I3 * I21), am) -
                          std::atan(std::sqrt(I2 * I31 / (I3 * I21)) * std::tan(am)),
                      wanted(0), 1e-12);
          break;
        case EulerSolution::Case::ii:
          EXPECT_NEAR(e.G / I3 * t + e.G * I31 / (e.lambda * I1 * I3) * ellint_3(k, -I3 * I21 / (I1 * I32), am) +
                          std::atan(std::sqrt(I2 * I31 / (I1 * I32)) * std::tan(am)),
                      wanted(2), 1e-12);
          break;
        case EulerSolution::Case::iii:
          EXPECT_NEAR(e.G / I2 * t - 2 * std::atan((e.B13 - e.G) / e.B31 * std::tanh(w / 2)), wanted(0), 1e-12);
          EXPECT_NEAR(e.G / I2 * t + 2 * std::atan((e.B31 - e.G) / e.B13 * std::tanh(w / 2)), wanted(2), 1e-12);
          break;
      }
    }
  }
}

TEST(LegendreDerivation, TheInterchangeOfParameterIsTheSameIntegral) {  // legendre.md, section 2
  for (const double k : {0.0, 0.5, 0.99}) {
    for (const double a : {0.05, 0.6, 0.999}) {
      for (const double x : {0.01, 0.5, 0.97}) {
        const double kc = std::sqrt(1 - k * k), K = ellint_1(k), u = x * K;
        const double w = std::sqrt(1 + a * a * k * k / (1 - a * a)), g = w * (1 - a * a);  // N = a^2 k^2 / (1 - a^2)
        const double sn = jacobi_sn(k, u), cn = jacobi_cn(k, u), dn = jacobi_dn(k, u);
        const auto H = [&](double from, double to) {
          return quadrature([&](double y) { return g * jacobi_dn(k, y) / (1 + a * jacobi_dn(k, y)); }, from, to);
        };
        const double rj = boost::math::ellint_rj(sn * sn, 1.0, dn * dn / (kc * kc), sn * sn + a * a * cn * cn);
        const double Z = std::atan(w * sn * cn * (1 - a * dn) / (a * dn * cn * cn + w * w * sn * sn));
        EXPECT_NEAR(H(u, K), g * a / 3 * cn * cn * cn / kc * rj + Z, 1e-12) << "k=" << k << " a=" << a << " x=" << x;
      }
    }
  }
}

double difference(const Motion& a, const Motion& b, double t) {
  const State x = a.at(t), y = b.at(t);
  return rotation_angle_rad(x.q_inertial_from_body, y.q_inertial_from_body) +
         (x.momentum_body - y.momentum_body).norm() / y.momentum_body.norm();
}

TEST(EarlierApproaches, AgreeWithLegendreWhereTheyAreValid) {
  for (const auto which : kCases) {
    for (const FreeBody& body : bodies(which)) {
      const auto legendre = make_legendre(body), basis = make_matrix_basis(body), cfsz = make_cfsz_quaternion(body);
      for (const double t : {0.0, -0.3, 1.0, 7.0, -20.0}) {
        EXPECT_LE(difference(*basis, *legendre, t), 1e-11) << "t=" << t;
        EXPECT_LE(difference(*cfsz, *legendre, t), 1e-11) << "t=" << t;
      }
    }
  }
}

TEST(EarlierApproaches, MatrixBasisIsLostWhereTheMomentumStandsStill) {
  // dm/dt = 0 at all times: no basis at all.
  for (int axis = 0; axis < 3; ++axis) {
    const FreeBody body{{1.0, 1.5, 2.0}, kAttitude, Vector3::Unit(axis)};
    EXPECT_FALSE(make_matrix_basis(body)->at(1.0).q_inertial_from_body.coeffs().allFinite());
    EXPECT_TRUE(make_legendre(body)->at(1.0).q_inertial_from_body.coeffs().allFinite());
  }
  // dm/dt tends to 0 on the separatrix: once it is below the last digits of m its direction is noise, then nothing.
  const FreeBody body = bodies(EulerSolution::Case::iii).front();
  const auto basis = make_matrix_basis(body), legendre = make_legendre(body);
  EXPECT_LE(difference(*basis, *legendre, 10.0), 1e-10);
  EXPECT_FALSE(basis->at(1e5).q_inertial_from_body.coeffs().allFinite());
  EXPECT_LE((legendre->at(1e5).momentum_body - Vector3(0, body.momentum_body.norm(), 0)).norm(), 1e-14);
}

TEST(EarlierApproaches, CfszQuaternionIsLostWhereTheMomentumIsOppositeToE3) {
  // Beside -e3, G + m3 cancels: half of the digits are gone at 1e-5, all at 1e-9.
  const auto worst = [](double transverse) {
    const FreeBody body{{1.0, 1.5, 2.0}, kAttitude, {transverse, 0.5 * transverse, -1.0}};
    const auto cfsz = make_cfsz_quaternion(body), legendre = make_legendre(body);
    double largest = 0.0;
    for (int i = 1; i < 20; ++i)
      largest = std::fmax(largest, std::abs(cfsz->at(i * 0.7).q_inertial_from_body.norm() - 1.0));
    return largest;
  };
  EXPECT_LE(worst(0.3), 1e-13);
  EXPECT_GT(worst(1e-5), 1e-8);
  const FreeBody lost{{1.0, 1.5, 2.0}, kAttitude, {1e-9, 0.5e-9, -1.0}};
  EXPECT_FALSE(make_cfsz_quaternion(lost)->at(1.0).q_inertial_from_body.coeffs().allFinite());
  // The same state turned by pi about e1, as the document's S does, is harmless.
  const FreeBody turned{{1.0, 1.5, 2.0}, kAttitude, {1e-9, -0.5e-9, 1.0}};
  EXPECT_LE(difference(*make_cfsz_quaternion(turned), *make_legendre(turned), 1.0), 1e-12);
}

}  // namespace
}  // namespace polhode
