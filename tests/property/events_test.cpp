// Events of free motions, found on bodies of all kinds: flips, mean rates, passes of a direction.
#include "polhode/motion/events.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "polhode/motion/state_rates.hpp"
#include "polhode/motion/theta.hpp"
#include "property/any_bodies.hpp"

namespace polhode {
namespace {

using test::Bodies;
using test::fastest;
using test::kEps;
using test::momentum_error;

TEST(ThetaEvents, FlipsAreWhereTheMiddleMomentumVanishes) {
  Bodies bodies;
  for (int n = 0; n < 500; ++n) {
    const FreeBody b = bodies.next();
    const ThetaMotion motion(b);
    const MeanRates rates = mean_rates(motion);
    double t = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double next = next_flip_s(motion, t);
      if (!std::isfinite(next)) break;
      ASSERT_GT(next, t) << n;
      if (k > 0) {
        ASSERT_NEAR(next - t, rates.polhode_period_s / 2, 1e-12 * next) << n;
      }
      const double rate = std::abs(state_rates(b.principal_moments, motion.at(next)).omega_rate_body_rad_s2[1]) *
                          b.principal_moments[1];
      ASSERT_LE(std::abs(motion.at(next).momentum_body[1]), 8 * kEps * (b.momentum_body.norm() + rate * next)) << n;
      t = next;
    }
  }
  const FreeBody top{Vector3(1, 2, 3), Quaternion(1, 0, 0, 0), Vector3(0, 0, 1)};
  EXPECT_EQ(next_flip_s(ThetaMotion(top), 0.0), std::numeric_limits<double>::infinity());
}

TEST(ThetaEvents,
     MeanRatesAreThoseOfTheMotion) {  // after one polhode period the attitude has turned about the momentum
  Bodies bodies;
  for (int n = 0; n < 400; ++n) {
    const FreeBody b = bodies.next();
    const ThetaMotion motion(b);
    const MeanRates rates = mean_rates(motion);
    const double period = rates.polhode_period_s;
    if (!std::isfinite(period) || period * fastest(b) > 1e5) continue;
    const State start = motion.at(0.0), end = motion.at(period);
    ASSERT_LE(momentum_error(end, start), 1e-10) << n;
    const Vector3 l = (start.q_inertial_from_body * start.momentum_body).normalized();
    for (double rate : {rates.long_axis_precession_rad_s, rates.short_axis_precession_rad_s}) {
      const Quaternion turn(Eigen::AngleAxisd(rate * period, l));
      ASSERT_LE(rotation_angle_rad(turn * start.q_inertial_from_body, end.q_inertial_from_body), 1e-9) << n;
    }
  }
}

TEST(ThetaEvents, PassesAreFound) {
  const FreeBody b{Vector3(1, 2, 2.7), Quaternion(1, -2, 0.3, 4), Vector3(1, 0.4, 0.3)};
  const ThetaMotion motion(b);
  const Vector3 direction = motion.at(123.456).q_inertial_from_body * Vector3::UnitX();
  const auto pass = next_pass(motion, b, Vector3::UnitX(), direction, 0.01, 0.0, 1000.0);
  ASSERT_TRUE(pass.has_value());
  EXPECT_LE(pass->time_s, 123.456);
  EXPECT_NEAR(pass->angle_rad, 0.01, 2e-9);
  for (double t = 0; t < pass->time_s; t += 1e-3) {  // none before
    ASSERT_GT(std::acos((motion.at(t).q_inertial_from_body * Vector3::UnitX()).dot(direction)), 0.01 - 1e-8) << t;
  }
  EXPECT_FALSE(next_pass(motion, b, Vector3::UnitX(), direction, 0.01, 0.0, pass->time_s * 0.99).has_value());
}

}  // namespace
}  // namespace polhode
