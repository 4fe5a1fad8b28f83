// Oracles: Boost.Math at 50 and 100 digits by other algorithms, Boost's quadrature, and limits where neither reaches.

#include "polhode/elliptic/legendre_forms.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/ellint_3.hpp>
#include <boost/math/special_functions/ellint_rj.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "polhode/elliptic/jacobi.hpp"

namespace polhode {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;
using Quad = boost::multiprecision::cpp_bin_float_quad;
constexpr double kUlp = 0x1p-53;

/// The largest relative error seen, with where; NaN counts as infinite.
struct Worst {
  double error = 0.0;
  std::string where = "nowhere";

  void see(const Exact& found, const Exact& truth, const std::string& at) {
    const double e = truth == 0 ? static_cast<double>(found) : static_cast<double>(Exact(abs((found - truth) / truth)));
    if (!(e <= error)) error = std::isnan(e) ? std::numeric_limits<double>::infinity() : e, where = at;
  }
};

Exact modulus(double kc) { return sqrt((1 - Exact(kc)) * (1 + Exact(kc))); }

const double kComplements[] = {1.0, 1.0 - 0x1p-53, 0.9999, 0.9, 0.5, 0.1, 1e-3, 1e-7, 1e-10, 1e-16, 1e-20};

TEST(Jacobi, KeepsRelativeAccuracyOverTheWholePeriod) {
  Worst sn, cn, dn, K;
  for (const double kc : kComplements) {
    const Jacobi jacobi(kc);
    const Exact exact_K = boost::math::ellint_1(modulus(kc));
    K.see(jacobi.quarter_period(), exact_K, "kc=" + std::to_string(kc));
    for (const double x : {1e-300, 1e-9, 0.01, 0.1, 0.2, 0.25, 0.26, 0.3, 0.4, 0.49, 0.5 - 0x1p-30, 0.5 - 0x1p-50}) {
      Exact exact_cn, exact_dn;
      const Exact exact_sn = boost::math::jacobi_elliptic(modulus(kc), Exact(2 * exact_K * x), &exact_cn, &exact_dn);
      const std::string at = "kc=" + std::to_string(std::log10(kc)) + " (log10) x=" + std::to_string(x);
      const JacobiValues v = jacobi.at_half_period_fraction(x);
      sn.see(v.sn, exact_sn, at);
      // cn and dn fall like e^-u up to K/2: the rounding of u = 2 K x shows u times larger.
      const double u = static_cast<double>(Exact(2 * exact_K * x));
      cn.see(exact_cn + (v.cn - exact_cn) / (1 + u), exact_cn, at);
      dn.see(exact_dn + (v.dn - exact_dn) / (1 + u), exact_dn, at);
      const JacobiValues w = jacobi.at_half_period_fraction(-x);
      EXPECT_EQ(w.sn, -v.sn);
      EXPECT_EQ(w.cn, v.cn);
      EXPECT_EQ(w.dn, v.dn);
    }
  }
  EXPECT_LE(K.error, 4 * kUlp) << K.where;
  EXPECT_LE(sn.error, 8 * kUlp) << sn.where;
  EXPECT_LE(cn.error, 12 * kUlp) << cn.where;
  EXPECT_LE(dn.error, 12 * kUlp) << dn.where;
  std::printf("K %.1f ulp, sn %.1f (%s), cn %.1f (%s), dn %.1f (%s)\n", K.error / kUlp, sn.error / kUlp,
              sn.where.c_str(), cn.error / kUlp, cn.where.c_str(), dn.error / kUlp, dn.where.c_str());
}

TEST(Jacobi, IsHyperbolicAtTheSeparatrixAndMirroredBesideTheMiddleAxis) {
  const double kc = 1e-160;
  const Jacobi jacobi(kc);
  const double K = jacobi.quarter_period();
  EXPECT_NEAR(K, std::log(4.0) + 160 * std::log(10.0), 16 * kUlp * K);  // DLMF 19.12.1
  for (const double u : {1e-20, 0.3, 1.0, 5.0, 40.0, 150.0}) {
    const double slack = (16 + 4 * K) * kUlp;  // K x is rounded at the size of K
    const JacobiValues inner = jacobi.at_half_period_fraction(u / (2 * K));
    EXPECT_NEAR(inner.sn, std::tanh(u), slack * std::tanh(u));
    EXPECT_NEAR(inner.cn, 1 / std::cosh(u), slack / std::cosh(u));
    EXPECT_NEAR(inner.dn, 1 / std::cosh(u), slack / std::cosh(u));
    if (u < 0.1) continue;
    const JacobiValues outer = jacobi.at_half_period_fraction(0.5 - u / (2 * K));  // DLMF 22.4.3
    EXPECT_NEAR(outer.sn, 1.0, 6 * kUlp);
    EXPECT_NEAR(outer.cn / kc, std::sinh(u), 2 * slack * std::cosh(u));
    EXPECT_NEAR(outer.dn / kc, std::cosh(u), 2 * slack * std::cosh(u));
  }
}

TEST(Jacobi, IsTrigonometricForTheSymmetricTop) {
  const Jacobi jacobi(1.0);
  EXPECT_EQ(jacobi.quarter_period(), std::acos(-1.0) / 2);
  for (const double x : {0.0, 0.1, 0.3, 0.5}) {
    const JacobiValues v = jacobi.at_half_period_fraction(x);
    EXPECT_NEAR(v.sn, std::sin(std::acos(-1.0) * x), 2 * kUlp);
    EXPECT_NEAR(v.cn, std::sin(std::acos(-1.0) * (0.5 - x)), 2 * kUlp);
    EXPECT_EQ(v.dn, 1.0);
  }
}

TEST(CarlsonRJ, AgreesWithBoostOnEveryPatternOfArguments) {
  Worst worst;
  using Digits = boost::multiprecision::cpp_bin_float_50;
  const double roots[] = {0.0, 1e-40, 1e-3, 1.0, 1.0000001, 1e30};
  int compared = 0;
  for (const double x : roots) {
    for (const double y : roots) {
      for (const double z : roots) {
        if ((x == 0) + (y == 0) + (z == 0) > 1) continue;
        for (const double p : {1e-20, 1e-3, 0.7, 2.0, 1e5}) {
          const double e = (p - x) / (p + x) * ((p - y) / (p + y)) * ((p - z) / (p + z));
          if (e < -0.99) continue;  // outside the stated range
          ++compared;
          const auto square = [](double r) { return Digits(r) * r; };
          const Exact truth(Digits(boost::math::ellint_rj(square(x), square(y), square(z), square(p))));
          worst.see(carlson_rj_of_roots(x, y, z, p), truth,
                    std::to_string(x) + ' ' + std::to_string(y) + ' ' + std::to_string(z) + ' ' + std::to_string(p));
        }
      }
    }
  }
  EXPECT_GE(compared, 500);
  EXPECT_LE(worst.error, 16 * kUlp) << worst.where;
  std::printf("R_J %.1f ulp (%s)\n", worst.error / kUlp, worst.where.c_str());
}

TEST(IncompleteIntegrals, AgreeWithBoost) {
  Worst first, third;
  for (const double kc : kComplements) {
    for (const double phi : {1e-8, 0.1, 0.7, 1.2, 1.5}) {
      const double sine = std::sin(phi), cosine = std::cos(phi);
      const Exact amplitude = atan2(Exact(sine), Exact(cosine));
      const std::string at = "kc=" + std::to_string(kc) + " phi=" + std::to_string(phi);
      first.see(incomplete_f(sine, cosine, kc), boost::math::ellint_1(modulus(kc), amplitude), at);
      for (const double n : {-3.0, -0.5, -1e-9, 0.3}) {  // negative n is the case of the free body
        third.see(incomplete_pi(sine, cosine, n, 1 - n, kc), boost::math::ellint_3(modulus(kc), Exact(n), amplitude),
                  at + " n=" + std::to_string(n));
      }
    }
  }
  EXPECT_LE(first.error, 8 * kUlp) << first.where;
  EXPECT_LE(third.error, 16 * kUlp) << third.where;
}

TEST(IncompleteIntegrals, AtQuarterPeriodAreTheCompleteOnes) {
  for (const double kc : kComplements) {
    const double K = complete_integral(kc, 1.0, 1.0, 1.0);
    EXPECT_NEAR(incomplete_f(1.0, 0.0, kc), K, 8 * kUlp * K);
    const double Pi = complete_integral(kc, std::sqrt(3.5), 1.0, 1.0);  // n = 1 - p = -2.5
    EXPECT_NEAR(incomplete_pi(1.0, 0.0, -2.5, 3.5, kc), Pi, 32 * kUlp * K);
  }
}

TEST(CompleteIntegral, InDoubleDoubleAgreesWithQuadrature) {
  // In s = tan theta the integrand is smooth on a logarithmic scale, however near the separatrix.
  boost::math::quadrature::tanh_sinh<Quad> quadrature(9);
  Worst in_double, in_double_double;
  for (const double kc : {1.0, 1e-2, 1e-12}) {
    for (const double root_p : {1.0, 30.0}) {
      for (const double b : {0.0, 1.0}) {
        const Quad p = Quad(root_p) * root_p;
        const auto f = [&](const Quad& y) {
          const Quad s = sinh(y), s2 = s * s;
          return Quad((1 + b * s2) / ((1 + p * s2) * sqrt(1 + Quad(kc) * kc * s2)) * cosh(y) / sqrt(1 + s2));
        };
        const Quad truth = quadrature.integrate(f, Quad(0), Quad(1)) + quadrature.integrate(f, Quad(1), Quad(10)) +
                           quadrature.integrate(f, Quad(10), Quad(40)) + quadrature.integrate(f, Quad(40), Quad(120));
        const std::string at = "kc=" + std::to_string(std::log10(kc)) + " (log10) root_p=" + std::to_string(root_p);
        const auto both = complete_integral(DoubleDouble(kc), DoubleDouble(root_p), DoubleDouble(1.0), DoubleDouble(b));
        in_double.see(complete_integral(kc, root_p, 1.0, b), Exact(truth), at);
        in_double_double.see(Exact(both.high) + both.low, Exact(truth), at);
      }
    }
  }
  EXPECT_LE(in_double.error, 8 * kUlp) << in_double.where;
  EXPECT_LE(in_double_double.error, 1e-29) << in_double_double.where;
  std::printf("complete integral: double %.1f ulp, double-double %.1e\n", in_double.error / kUlp,
              in_double_double.error);
}

}  // namespace
}  // namespace polhode
