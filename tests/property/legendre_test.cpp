// The classical closed form over random bodies, extreme ones included, and against the theta series.

#include "polhode/motion/legendre.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "polhode/motion/theta.hpp"

namespace polhode {
namespace {

class RandomBodies {
 public:
  double uniform(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(random_() >> 11), -53);
  }
  Quaternion attitude() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }

  FreeBody generic() {
    const double I3 = uniform(0.7, 1.3);
    const double I2 = uniform(0.5, 1.0) * I3, I1 = std::fmin(I2, (I3 - I2) + uniform(0.01, 1.0) * I2);
    return {{I1, I2, I3}, attitude(), {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}};
  }

  /// Equal or nearly equal moments, components down to 1e-200 of the largest, any unit.
  FreeBody extreme(int n) {
    const auto tiny = [&](double decades) { return std::pow(10.0, uniform(-decades, 0.0)); };
    const double I2 = 1.0 + (n % 3 == 0 ? tiny(15) : uniform(0.0, 1.0));
    const double I3 = I2 + (n % 3 == 1 ? tiny(15) : (n % 5 == 0 ? 0.0 : uniform(0.0, 1.0)));
    Vector3 m(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    if (n % 4 == 1) m[n % 3] *= tiny(200);
    if (n % 4 == 2) m[0] *= tiny(170), m[2] *= tiny(170);
    if (n % 4 == 3) {  // beside the separatrix
      const double slope = std::sqrt((I2 - 1.0) * I3 / (I3 - I2));
      if (std::isfinite(slope)) m[2] = m[0] * slope * (1.0 + tiny(17));
    }
    const double inertia_unit = std::pow(10.0, uniform(-140, 140)), momentum_unit = std::pow(10.0, uniform(-140, 140));
    return {Vector3(1.0, I2, I3) * inertia_unit, attitude(), m * momentum_unit};
  }

 private:
  std::mt19937_64 random_{20200602};
};

double momentum_difference(const Vector3& found, const Vector3& wanted) {
  return (found - wanted).norm() / wanted.norm();
}

TEST(LegendreProperty, ExtremeBodiesStartAsGivenAndStayFiniteAndUnit) {
  RandomBodies random;
  for (int n = 0; n < 5000; ++n) {
    const FreeBody body = random.extreme(n);
    const auto motion = make_legendre(body);
    const State start = motion->at(0.0);
    ASSERT_LE(rotation_angle_rad(start.q_inertial_from_body, body.q_inertial_from_body.normalized()), 4e-15) << n;
    ASSERT_LE(momentum_difference(start.momentum_body, body.momentum_body), 4e-15) << n;
    const double scale = body.principal_moments[1] / body.momentum_body.norm();
    for (const double turns : {0.3, -2.0, 1e3, -1e9}) {
      const State s = motion->at(turns * scale);
      ASSERT_NEAR(s.q_inertial_from_body.norm(), 1.0, 1e-15) << n;
      ASSERT_NEAR(s.momentum_body.norm() / body.momentum_body.norm(), 1.0, 4e-15) << n;
    }
  }
}

TEST(LegendreProperty, TinyAxialMomentumOfAProlateTopIsNoPrincipalAxis) {
  // I2 = I3 and m1 = 1e-163: m2 and m3 stand still, the body turns about them; m1^2 underflows.
  const FreeBody body{{1.0, 2.0, 2.0}, Quaternion::Identity(), {1e-163, 3.0, 4.0}};
  for (const double t : {1.0, -7.0, 1000.0}) {
    const State s = make_legendre(body)->at(t);
    const double half = 0.5 * std::remainder(2.5 * t, 4.0 * std::acos(-1.0));
    const Quaternion wanted(std::cos(half), 0.0, 0.6 * std::sin(half), 0.8 * std::sin(half));
    EXPECT_LE(rotation_angle_rad(s.q_inertial_from_body, wanted), 1e-12);
    EXPECT_LE(momentum_difference(s.momentum_body, body.momentum_body), 4e-15);
  }
}

TEST(LegendreProperty, AgreesWithTheta) {  // no formula in common
  RandomBodies random;
  double worst = 0.0;
  for (int n = 0; n < 3000; ++n) {
    const FreeBody body = random.generic();
    const auto legendre = make_legendre(body);
    const ThetaMotion theta(body);
    for (const double t : {0.0, 0.7, -30.0, 1e5}) {
      const State a = legendre->at(t), b = theta.at(t);
      const double d = rotation_angle_rad(a.q_inertial_from_body, b.q_inertial_from_body) +
                       momentum_difference(a.momentum_body, b.momentum_body);
      ASSERT_LE(d, 1e-13) << n << " t=" << t;
      worst = std::fmax(worst, d);
    }
  }
  std::printf("worst difference %.2e\n", worst);
}

}  // namespace
}  // namespace polhode
