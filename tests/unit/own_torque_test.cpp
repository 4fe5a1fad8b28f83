#include "polhode/torque/own_torque.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>

#include "polhode/base/error.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {
namespace {

/// Of a lambda, for the tests.
class OwnLambda final : public TorqueFunction {
 public:
  using Function = std::function<Vector3(const TorqueQuestion&)>;
  explicit OwnLambda(Function function, bool kinks = false, double bound = std::numeric_limits<double>::infinity())
      : function_(std::move(function)), kinks_(kinks), bound_(bound) {}
  Vector3 torque(const TorqueQuestion& at) const override { return function_(at); }
  bool has_kinks() const override { return kinks_; }
  double largest(double, double) const override { return bound_; }

 private:
  Function function_;
  bool kinks_;
  double bound_;
};

template <class... Rest>
OwnTorque own(OwnLambda::Function function, Rest... rest) {
  return OwnTorque(std::make_shared<const OwnLambda>(std::move(function), rest...));
}

const FreeBody kBody{{40.0, 70.0, 90.0}, Quaternion(0.3, -0.5, 0.7, 0.2).normalized(), {0.3, 0.9, 1.1}};

double worst_between_rad(const Motion& a, const Motion& b, double first_s, double last_s) {
  double worst = 0.0;
  for (int i = 0; i <= 300; ++i) {
    const double t_s = first_s + (last_s - first_s) * i / 300;
    const double angle = rotation_angle_rad(a.at(t_s).q_inertial_from_body, b.at(t_s).q_inertial_from_body);
    if (!(angle <= worst)) worst = angle;
  }
  return worst;
}

TEST(OwnTorque, IsAsGoodAsTheLibrarysOwn) {
  const double mu = 3.986004418e14;
  const Trajectory way(KeplerElements{mu, 6.9e6, 0.1, 0.0, {1, 0, 0}, {0, 0.5, 0.8}});
  const OwnTorque pull(std::make_shared<const OwnLambda>([mu](const TorqueQuestion& at) {
                         const Vector3 r = at.q_inertial_from_body.conjugate() * at.orbit->position_m;
                         const Vector3 I = kBody.principal_moments;
                         return Vector3(3.0 * mu / std::pow(r.norm(), 5) * r.cross(I.cwiseProduct(r)));
                       }),
                       way);
  const OwnTorque damping = own([](const TorqueQuestion& at) { return Vector3(-1e-3 * at.omega_rad_s); });
  const OwnTorque pushed = own([](const TorqueQuestion& at) {
    return Vector3(0.0, 1e-5, 2e-5 * std::cos(0.003 * at.t_s) + 0.0 * at.momentum_body[0]);
  });
  const OwnTorque half =
      own([](const TorqueQuestion& at) { return Vector3(0.0, 0.0, 1e-5 * std::cos(0.003 * at.t_s)); });
  struct Pair {
    Torques own, known;
  };
  for (const Pair& pair : {Pair{Torques({pull}), Torques({GravityGradient(mu, way)})},
                           Pair{Torques({damping}), Torques({LinearDamping(Vector3::Constant(1e-3))})},
                           Pair{Torques({pushed}), Torques({half, half, ConstantTorque{{0.0, 1e-5, 0.0}}})}}) {
    for (const double tolerance_rad : {1e-4, 1e-7, 1e-9}) {
      const TorquedOptions options{tolerance_rad, -3000.0, 9000.0};
      const TorquedMotion a(kBody, pair.own, options), b(kBody, pair.known, {1e-11, -3000.0, 9000.0});
      EXPECT_EQ(a.outcome(), Outcome::done);
      EXPECT_EQ(a.method(), "dormand-prince");
      EXPECT_LE(worst_between_rad(a, b, -3000.0, 9000.0), a.error_rad() + b.error_rad()) << tolerance_rad;
    }
  }
}

TEST(OwnTorque, IsToldTheNamedAxes) {
  Matrix3 cycle;
  cycle << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  FreeBody body = kBody;
  body.named_from_principal = cycle;
  const Torques own_axes({own([&](const TorqueQuestion& at) {
    EXPECT_NEAR((at.momentum_body - Vector3(70.0, 90.0, 40.0).cwiseProduct(at.omega_rad_s)).norm(), 0.0, 1e-12);
    return Vector3(-1e-3 * at.omega_rad_s[0], 1e-4, 1e-4 * (at.q_inertial_from_body.conjugate() * Vector3::UnitX())[1]);
  })});
  const Torques principal({own([&](const TorqueQuestion& at) {
    const Vector3 omega = cycle * at.omega_rad_s;
    const Vector3 x = cycle * (at.q_inertial_from_body.conjugate() * Vector3::UnitX());
    return Vector3(cycle.transpose() * Vector3(-1e-3 * omega[0], 1e-4, 1e-4 * x[1]));
  })});
  const TorquedOptions options{1e-9, 0.0, 5000.0};
  const TorquedMotion a(body, own_axes, options), b(kBody, principal, options);
  EXPECT_EQ(a.outcome(), Outcome::done);
  EXPECT_LT(worst_between_rad(a, b, 0.0, 5000.0), 2e-9);
}

/// A function that jumps, again and again: what is claimed holds all the same.
TEST(OwnTorque, KinksLowerThePromise) {
  const auto law = [](const TorqueQuestion& at) {
    const Vector3 x = at.q_inertial_from_body.conjugate() * Vector3::UnitX();
    return Vector3(x[1] > 0.2 ? 2e-4 : 0.0, -3e-3 * std::abs(at.omega_rad_s[0]),
                   std::fmod(at.t_s, 700.0) < 90.0 ? 1e-4 : 0.0);
  };
  const TorquedMotion truth(kBody, Torques({own(law, true)}), {1e-7, 0.0, 6000.0});
  ASSERT_LE(truth.error_rad(), 1e-6);
  for (const double tolerance_rad : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const TorquedMotion motion(kBody, Torques({own(law, true)}), {tolerance_rad, 0.0, 6000.0});
    const double worst = worst_between_rad(motion, truth, 0.0, 6000.0);
    std::printf("jumps to %g rad: off by %.1e, claimed %.1e, %zu evaluations, %s\n", tolerance_rad, worst,
                motion.error_rad(), motion.torque_evaluations(), std::string(outcome_name(motion.outcome())).c_str());
    EXPECT_LE(worst, motion.error_rad() + truth.error_rad());
    if (tolerance_rad >= 1e-4) {
      EXPECT_EQ(motion.outcome(), Outcome::done);
    }
  }
}

TEST(OwnTorque, WhatIsNoTorqueIsRefused) {
  const TorquedOptions options{1e-6, 0.0, 1000.0};
  const auto gives = [&](double number) {
    return [&, number] {
      const Torques torques(
          {own([number](const TorqueQuestion& at) { return Vector3(0.0, at.t_s > 500.0 ? number : 0.0, 0.0); })});
      const TorquedMotion motion(kBody, torques, options);
    };
  };
  EXPECT_NO_THROW(gives(0.0)());
  for (const double number : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    try {
      gives(number)();
      ADD_FAILURE();
    } catch (const InputError& problem) {
      EXPECT_NE(std::string(problem.what()).find("finite numbers are wanted"), std::string::npos) << problem.what();
    }
  }
  EXPECT_THROW(OwnTorque(nullptr), InputError);
  struct Mine {};
  const Torques throws({own([](const TorqueQuestion&) -> Vector3 { throw Mine(); })});
  EXPECT_THROW(TorquedMotion(kBody, throws, options), Mine);
}

TEST(OwnTorque, APlanKeepsWhatItCannotBound) {
  const auto tiny = [](const TorqueQuestion&) { return Vector3(1e-12, 0.0, 0.0); };
  const Plan unknown = plan_motion(kBody, Torques({own(tiny)}), 0.0, 3000.0, 1e-3);
  EXPECT_TRUE(unknown.effects.front().kept);
  EXPECT_FALSE(unknown.effects.front().secular_rad);
  const Plan known = plan_motion(kBody, Torques({own(tiny, false, 1e-12)}), 0.0, 3000.0, 1e-3);
  EXPECT_FALSE(known.effects.front().kept);
  EXPECT_LT(known.effects.front().secular_rad.value(), 1e-5);
}

}  // namespace
}  // namespace polhode
