#include "polhode/motion/torqued_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/planner.hpp"
#include "rivals/extrapolated_motion.hpp"
#include "unit/satellite_under_gravity.hpp"

namespace polhode {
namespace {

using rivals::ExtrapolatedMotion;
using test::distance;
using test::gravity;
using test::kEarth;
using test::kRadius_m;
using test::reference;
using test::satellite;

TorquedOptions by(std::string_view method, TorquedOptions options) {
  options.method = method;
  return options;
}

// Closed forms.

TEST(TorquedMotion, DampedSphereSlowsExponentially) {
  const Vector3 moments(3, 3, 3), omega(0.2, -0.1, 0.4);
  const FreeBody body{moments, Quaternion::Identity(), 3.0 * omega};
  const TorquedMotion motion(body, Torques({LinearDamping{{0.06, 0.06, 0.06}}}), {1e-12, -100.0, 200.0});
  EXPECT_EQ(motion.outcome(), Outcome::done);
  for (const double t : {-100.0, -3.0, 0.0, 1.0, 77.0, 200.0}) {
    const double rate = 0.06 / 3.0, angle = omega.norm() * -std::expm1(-rate * t) / rate;
    const Quaternion q(Eigen::AngleAxisd(angle, omega.normalized()));
    EXPECT_LT(distance(motion.at(t), {q, 3.0 * omega * std::exp(-rate * t)}), 2e-12) << t;
  }
}

TEST(TorquedMotion, SphereUnderAnInertialTorqueGainsItLinearly) {
  const FreeBody body{{2, 2, 2}, Quaternion(0.5, 0.5, -0.5, 0.5), {0, 0, 0}};
  const Vector3 torque(0.01, -0.02, 0.03);
  const TorquedMotion motion(body, Torques({ConstantTorque{torque, ConstantTorque::Axes::inertial}}),
                             {1e-11, 0.0, 100.0});
  EXPECT_EQ(motion.outcome(), Outcome::done);
  for (const double t : {0.0, 10.0, 100.0}) {
    const Quaternion q =
        Quaternion(Eigen::AngleAxisd(0.25 * torque.norm() * t * t, torque.normalized())) * body.q_inertial_from_body;
    EXPECT_LT(rotation_angle_rad(motion.at(t).q_inertial_from_body, q), 1e-11) << t;
    EXPECT_LT((motion.at(t).q_inertial_from_body * motion.at(t).momentum_body - torque * t).norm(), 1e-11);
  }
}

TEST(TorquedMotion, PulsesAddTheirImpulse) {
  const FreeBody body{{1, 2, 3}, Quaternion::Identity(), {0, 0, 0.6}};
  const TorquedMotion motion(body,
                             Torques({ThrusterPulse{20.0, 4.0, {0, 0, 0.1}}, ThrusterPulse{-9.0, 2.0, {0, 0, -0.3}}}),
                             {1e-12, -30.0, 50.0});
  EXPECT_EQ(motion.outcome(), Outcome::done);
  const auto angle_and_spin = [&](double t) {  // by hand: about the third axis throughout
    if (t >= 24.0) return std::pair{0.2 * t + 0.1 / 3 * 8.0 + 0.4 / 3 * (t - 24.0), 1.0};
    if (t >= 20.0) return std::pair{0.2 * t + 0.1 / 3 * 0.5 * (t - 20.0) * (t - 20.0), 0.6 + 0.1 * (t - 20.0)};
    if (t >= -7.0) return std::pair{0.2 * t, 0.6};
    if (t >= -9.0) return std::pair{0.2 * t - 0.1 * 0.5 * (t + 7.0) * (t + 7.0), 0.6 - 0.3 * (t + 7.0)};
    return std::pair{0.2 * t - 0.2 + 0.2 * (t + 9.0), 1.2};
  };
  for (const double t : {-30.0, -8.0, 0.0, 20.0, 21.5, 24.0, 50.0}) {
    const auto [angle, spin] = angle_and_spin(t);
    EXPECT_LT(distance(motion.at(t), {Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitZ())), {0, 0, spin}}), 2e-12)
        << t;
  }
}

// Balances: the definition of each torque against the motion that came out.

TEST(TorquedMotion, EnergyChangesByThePowerOfTheTorques) {
  Matrix3 M = Vector3(931500, 1059000, 1059000).asDiagonal();
  const FreeBody body = satellite();
  const Torques torques(
      {GravityGradient(kEarth, KeplerElements{kEarth, kRadius_m, 0.01, 0.0, {1, 0, 0}, {0, 0.6, 0.8}}),
       EddyCurrents{100.0 * M, Vector3::UnitZ(), 7.8e15,
                    KeplerElements{kEarth, kRadius_m, 0.01, 0.0, {1, 0, 0}, {0, 0.6, 0.8}}},
       LinearDamping{{3.0, 5.0, 2.0}}});
  for (const char* method : {"series", "dormand-prince"}) {
    const TorquedMotion motion(body, torques, by(method, {1e-10, 0.0, 5000.0}));
    EXPECT_EQ(motion.outcome(), Outcome::done) << method;
    const auto energy = [&](double t) {
      const Vector3 m = motion.at(t).momentum_body;
      return 0.5 * m.dot(m.cwiseQuotient(body.principal_moments));
    };
    for (const double t : {30.0, 777.0, 4321.0}) {
      const double h = 0.5;
      const double rate =
          (8.0 * (energy(t + h) - energy(t - h)) - (energy(t + 2 * h) - energy(t - 2 * h))) / (12.0 * h);
      const State s = motion.at(t);
      const Vector3 omega = s.momentum_body.cwiseQuotient(body.principal_moments);
      const double power = torques.at(t, s.q_inertial_from_body, body.principal_moments).torque(omega).dot(omega);
      EXPECT_NEAR(rate, power, 1e-6 * std::abs(power)) << method << " " << t;
    }
  }
}

TEST(TorquedMotion, InternalDissipationKeepsTheMomentumAndEndsInShortAxisRotation) {
  const Vector3 moments(1, 2, 3);
  const FreeBody body{moments, Quaternion::Identity(), {0.95, 0.2, 0.25}};  // about the long axis
  const double G = body.momentum_body.norm();
  const Torques torques({InternalDissipation::from_quality_factor(5.0, moments, G)});
  const double k = std::get<InternalDissipation>(torques.list()[0]).relaxation;
  for (const char* method : {"series", "dormand-prince"}) {
    const TorquedMotion motion(body, torques, by(method, {1e-8, 0.0, 400.0}));
    EXPECT_EQ(motion.outcome(), Outcome::done) << method;
    const auto energy = [&](double t) {
      const Vector3 m = motion.at(t).momentum_body;
      return 0.5 * m.dot(m.cwiseQuotient(moments));
    };
    for (const double t : {0.0, 20.0, 150.0, 400.0}) {
      const State s = motion.at(t);
      EXPECT_LT((s.q_inertial_from_body * s.momentum_body - body.momentum_body).norm(), 1e-8 * G) << method << t;
    }
    const double t = 20.0, h = 0.05;
    const Vector3 m = motion.at(t).momentum_body;
    const double loss = k * m.cross(m.cwiseQuotient(moments)).squaredNorm();
    EXPECT_NEAR((energy(t + h) - energy(t - h)) / (2 * h), -loss, 1e-3 * loss) << method;
    EXPECT_GT(energy(0.0), 1.2 * G * G / 6.0);
    EXPECT_NEAR(energy(400.0), G * G / 6.0, 1e-3 * G * G);
  }
}

// Both engines, against extrapolation in long double.

TEST(TorquedMotion, FollowsEveryKindOfBodyAtAnyTime) {
  const KeplerElements orbit{kEarth, kRadius_m, 0.1, 100.0, {1, 0, 0}, {0, 0.6, 0.8}};
  const Matrix3 magnetic = Vector3(931500, 1059000, 1059000).asDiagonal();
  const Torque gravity_gradient = GravityGradient(kEarth, orbit);
  const Torque eddies = EddyCurrents{100.0 * magnetic, Vector3::UnitZ(), 7.8e15, orbit};
  const Quaternion q = Quaternion(0.3, -0.5, 0.7, 0.2).normalized();
  struct {
    const char* name;
    Vector3 moments, omega_rad_s;
    std::vector<Torque> torques;
  } const bodies[] = {
      {"triaxial", {17000, 124800, 129200}, {0.02, 0.01, 0.04}, {gravity_gradient}},
      {"long-axis mode", {17000, 124800, 129200}, {0.06, 0.001, 0.002}, {gravity_gradient}},
      {"beside the middle axis", {17000, 90000, 129200}, {1e-5, 0.04, 1e-6}, {gravity_gradient}},
      {"beside the short axis", {17000, 90000, 129200}, {1e-9, 1e-9, 0.04}, {gravity_gradient}},
      {"on the short axis", {17000, 90000, 129200}, {0, 0, 0.04}, {gravity_gradient}},
      {"on the long axis", {17000, 90000, 129200}, {0.06, 0, 0}, {gravity_gradient}},
      {"oblate", {90000, 90000, 129200}, {0.02, 0.01, 0.04}, {gravity_gradient}},
      {"prolate", {17000, 90000, 90000}, {0.03, 0.01, 0.03}, {gravity_gradient}},
      {"sphere", {90000, 90000, 90000}, {0.03, 0.01, 0.03}, {ConstantTorque{{0.02, 0.01, -0.03}}, eddies}},
      {"eddy currents and damping",
       {17000, 124800, 129200},
       {0.02, 0.01, 0.04},
       {gravity_gradient, eddies, LinearDamping{{1.0, 5.0, 2.0}}}},
      {"dissipation",
       {17000, 90000, 129200},
       {0.05, 0.01, 0.02},
       {gravity_gradient, InternalDissipation::from_quality_factor(300.0, {17000, 90000, 129200}, 3000.0)}},
      {"an inertial torque, beside two masses",
       {17000, 90000, 129200},
       {0.02, 0.01, 0.03},
       {gravity_gradient, ConstantTorque{{0.01, -0.02, 0.03}, ConstantTorque::Axes::inertial},
        GravityGradient(4.9e12, KeplerElements{4.9e12, 4e6, 1.3, 900.0, {0, 1, 0}, {0, 0, 1}})}},
      {"two masses",
       {17000, 90000, 129200},
       {0.02, 0.01, 0.03},
       {gravity_gradient, GravityGradient(4.9e12, KeplerElements{4.9e12, 4e6, 0.2, 900.0, {0, 1, 0}, {0, 0, 1}})}},
      {"damping on an orbit", {17000, 90000, 129200}, {0.02, 0.01, 0.03}, {gravity_gradient, LinearDamping{{1, 5, 2}}}},
      {"spin-up through the separatrix",
       {17000, 90000, 129200},
       {0.05, 0.01, 0.01},
       {ConstantTorque{{0.1, 0.8, -0.3}}}},
  };
  for (const auto& b : bodies) {
    const FreeBody body{b.moments, q, b.moments.cwiseProduct(b.omega_rad_s)};
    const Torques torques(b.torques);
    for (const double end_s : {3000.0, -3000.0}) {
      const ExtrapolatedMotion truth(body, torques, {1e-12, std::min(0.0, end_s), std::max(0.0, end_s)});
      ASSERT_LE(truth.error_rad(), 1e-12) << b.name;
      for (const double tolerance : {1e-5, 1e-9}) {
        for (const std::string_view method : {"series", "dormand-prince"}) {
          const TorquedMotion motion(body, torques, {tolerance, std::min(0.0, end_s), std::max(0.0, end_s), method});
          // Beside the middle axis roundings in double grow to more than 1e-9.
          EXPECT_TRUE(motion.outcome() == Outcome::done || (method == "dormand-prince" && motion.error_rad() > 1e-9))
              << b.name << " by " << method;
          double worst = 0.0;
          for (int i = 0; i <= 200; ++i) {  // between the points, too
            const double t = end_s * i / 200.0, off = distance(motion.at(t), truth.at(t));
            worst = off <= worst ? worst : off;
          }
          const double promised_rad = motion.outcome() == Outcome::done ? tolerance : motion.error_rad();
          EXPECT_LE(worst, promised_rad) << b.name << " to " << end_s << " s at " << tolerance << " by " << method;
        }
      }
    }
  }
}

// Control.

TEST(TorquedMotion, IsWithinTheTolerance) {
  const FreeBody body = satellite({0.002, 0.001, 0.006});
  const Torques torques = gravity(0.3);
  const State truth = reference(body, torques, 20000.0);
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    const TorquedMotion motion(body, torques, {tolerance, 0.0, 20000.0});
    EXPECT_EQ(motion.outcome(), Outcome::done);
    EXPECT_LT(rotation_angle_rad(motion.at(20000.0).q_inertial_from_body, truth.q_inertial_from_body), tolerance);
    EXPECT_LE(motion.error_rad(), tolerance);
  }
}

/// What an account says is what ran, and what it promises holds, by whichever method.
TEST(TorquedMotion, EveryMethodAccountsForWhatRan) {
  const FreeBody body = satellite({0.002, 0.001, 0.006});
  const Torques torques = gravity(0.3);
  constexpr double span_s = 20000.0;
  const ExtrapolatedMotion truth(body, torques, {1e-13, 0.0, span_s});
  ASSERT_LE(truth.error_rad(), 1e-13);
  int promises = 0;
  for (const std::string_view method : torqued_motion_methods()) {
    for (const double tolerance : {1e-3, 1e-7, 1e-10}) {
      const TorquedMotion motion(body, torques, by(method, {tolerance, 0.0, span_s}));
      const MotionAccount account = motion.account();
      EXPECT_EQ(account.method, method == "auto" ? "series" : method);
      EXPECT_EQ(account.torque_evaluations, motion.torque_evaluations()) << method;
      EXPECT_GT(account.torque_evaluations, 0U) << method;
      EXPECT_EQ(account.max_error_rad.has_value(), motion.outcome() == Outcome::done) << method;
      EXPECT_FALSE(account.error_meaning.empty()) << method;
      if (!account.max_error_rad) continue;
      ++promises;
      EXPECT_EQ(*account.max_error_rad, tolerance) << method;
      for (int i = 0; i <= 100; ++i) {
        const double t_s = span_s * i / 100.0;
        const double off_rad =
            rotation_angle_rad(motion.at(t_s).q_inertial_from_body, truth.at(t_s).q_inertial_from_body);
        EXPECT_LE(off_rad, tolerance) << method << " at " << t_s;
      }
    }
  }
  EXPECT_EQ(promises, 3 * static_cast<int>(torqued_motion_methods().size()));
}

TEST(TorquedMotion, BetweenStepsIsAsGoodAsAtTheirEnds) {
  const FreeBody body = satellite();
  const TorquedMotion motion(body, gravity(0.1), {1e-8, -3000.0, 3000.0});
  const ExtrapolatedMotion exact(body, gravity(0.1), {1e-12, -3000.0, 3000.0});
  for (double t = -3000.0; t <= 3000.0; t += 7.3) {
    EXPECT_LT(rotation_angle_rad(motion.at(t).q_inertial_from_body, exact.at(t).q_inertial_from_body), 1e-8) << t;
  }
}

/// All runs together count; a step is finished.
TEST(TorquedMotion, KeepsToTheLimitOfEvaluations) {
  constexpr std::size_t window = 400;
  for (const double part : {0.01, 1.0, 100.0}) {
    for (const double tolerance_rad : {1e-6, 1e-9, 1e-13}) {
      for (const std::size_t most : {1U, 3000U, 20000U, 60000U}) {
        TorquedOptions options{tolerance_rad, -2e4, 1e5};
        options.max_torque_evaluations = most;
        const TorquedMotion motion(satellite(), gravity(part), options);
        EXPECT_LE(motion.torque_evaluations(), most + window) << part << " " << tolerance_rad << " " << most;
        // What it says that it reached it answers.
        for (const double t_s :
             {motion.first_s(), 0.5 * motion.first_s(), 0.0, 0.5 * motion.last_s(), motion.last_s()}) {
          EXPECT_TRUE(motion.at(t_s).momentum_body.allFinite()) << part << " " << tolerance_rad << " " << most;
        }
      }
    }
  }
}

/// A pulse divides a way into legs; those that were not begun are not reached.
TEST(TorquedMotion, StopsWhereItWasStopped) {
  const Torques pulsed({gravity().list()[0], ThrusterPulse{5e4, 10.0, {1e-3, 0, 0}}});
  for (const std::string_view name : {"series", "dormand-prince"}) {
    TorquedOptions few = by(name, {1e-9, -1e5, 1e5});
    few.max_torque_evaluations = 3000;
    const TorquedMotion stopped(satellite(), pulsed, few);
    EXPECT_EQ(stopped.outcome(), Outcome::stopped);
    EXPECT_LT(stopped.last_s(), 5e4) << name;
    EXPECT_EQ(stopped.first_s(), 0.0) << name;
    EXPECT_THROW(stopped.at(6e4), InputError);
    EXPECT_THROW(stopped.at(-1.0), InputError);
  }
}

/// A spin that is damped for so long that nothing of its momentum is left.
TEST(TorquedMotion, DampingMayTakeAllMomentum) {
  const FreeBody body = satellite();
  for (const std::string_view name : {"series", "dormand-prince"}) {
    TorquedOptions options = by(name, {1e-6, 0.0, 0.0});
    options.last_s = 400.0 * body.principal_moments[2];
    const TorquedMotion motion(body, Torques({LinearDamping{Vector3::Ones()}}), options);
    const State end = motion.at(options.last_s);
    EXPECT_NEAR(end.q_inertial_from_body.norm(), 1.0, 1e-14) << name;
    EXPECT_LT(end.momentum_body.norm(), 1e-9 * body.momentum_body.norm()) << name;
  }
}

TEST(TorquedMotion, SaysWhenItStopsOrCannotReachTheTolerance) {
  const FreeBody body = satellite();
  TorquedOptions few{1e-9, 0.0, 1e5};
  few.max_torque_evaluations = 5000;
  const TorquedMotion stopped(body, gravity(), few);
  EXPECT_EQ(stopped.outcome(), Outcome::stopped);
  EXPECT_GT(stopped.last_s(), 0.0);
  EXPECT_LT(stopped.last_s(), 1e5);
  EXPECT_TRUE(stopped.at(0.5 * stopped.last_s()).momentum_body.allFinite());
  EXPECT_THROW(stopped.at(1e5), InputError);
  // Doubles cannot give 1e-15 over a hundred turns, and this method must not claim it.
  const TorquedMotion rounding(body, gravity(), by("dormand-prince", {1e-15, 0.0, 2e4}));
  EXPECT_EQ(rounding.outcome(), Outcome::tolerance_not_reachable);
  EXPECT_GT(rounding.error_rad(), 1e-15);
  EXPECT_TRUE(rounding.at(2e4).momentum_body.allFinite());
}

TEST(TorquedMotion, RefusesWrongOptions) {
  const FreeBody body = satellite();
  EXPECT_THROW(TorquedMotion(body, gravity(), {0.0, 0.0, 1.0}), InputError);
  EXPECT_THROW(TorquedMotion(body, gravity(), {std::nan(""), 0.0, 1.0}), InputError);
  EXPECT_THROW(TorquedMotion(body, gravity(), {1e-9, 1.0, 2.0}), InputError);
  EXPECT_THROW(TorquedMotion(body, gravity(), {1e-9, 0.0, INFINITY}), InputError);
  EXPECT_THROW(TorquedMotion(body, gravity(), {1e-9, 0.0, 1.0, "rk4"}), InputError);
  EXPECT_THROW(TorquedMotion(body, gravity(), {1e-9, 0.0, 1.0, "strang"}), InputError);  // a scheme is none
}

TEST(TorquedMotion, GoesOnForAsLongAsTimeScalesDiffer) {
  for (const std::string_view method : {"series", "dormand-prince"}) {
    for (const double last_s : {3000.0, 0.0}) {
      const TorquedMotion motion(satellite(), gravity(), by(method, {1e-9, last_s - 3000.0, last_s}));
      const TorquedMotion longer(satellite(), gravity(), by(method, {1e-9, last_s - 3001.0, last_s + 1.0}));
      for (const double t_s : {last_s - 3000.0 - 3e-3, last_s + 3e-3}) {
        EXPECT_LT(rotation_angle_rad(motion.at(t_s).q_inertial_from_body, longer.at(t_s).q_inertial_from_body), 2e-9)
            << method << " at " << t_s;
      }
      EXPECT_THROW(motion.at(last_s + 0.1), InputError);
      EXPECT_THROW(motion.at(last_s - 3000.1), InputError);
    }
  }
}

TEST(TorquedMotion, EmptySpanIsTheStart) {
  const FreeBody body = satellite();
  const TorquedMotion motion(body, gravity(), {1e-9, 0.0, 0.0});
  EXPECT_EQ(motion.outcome(), Outcome::done);
  EXPECT_LT(distance(motion.at(0.0), {body.q_inertial_from_body, body.momentum_body}), 1e-15);
}

/// A prism of nine sides with pointed ends, 36 facets, off its centre of mass.
TriangleMesh prism() {
  TriangleMesh mesh;
  constexpr unsigned sides = 9;
  for (const double end : {1.0, -1.0}) {
    for (unsigned i = 0; i < sides; ++i) {
      const double a = 2.0 * std::numbers::pi * static_cast<double>(i) / sides;
      mesh.vertices.emplace_back((1.7 + 0.3 * end) * std::cos(a) + 0.4, 1.2 * std::sin(a) - 0.1,
                                 1.3 * end + 0.2 * std::cos(2.0 * a));
    }
  }
  mesh.vertices.emplace_back(0.5, -0.2, 2.2);
  mesh.vertices.emplace_back(0.3, 0.0, -1.9);
  for (unsigned i = 0; i < sides; ++i) {
    const unsigned j = (i + 1) % sides;
    mesh.facets.push_back({i, j, 2 * sides});
    mesh.facets.push_back({sides + j, sides + i, 2 * sides + 1});
    mesh.facets.push_back({i, sides + i, sides + j});
    mesh.facets.push_back({i, sides + j, j});
  }
  return mesh;
}

TEST(Torqued, FacetsPromiseWhatTheirKinksLetThemReach) {
  const Vector3 moments(1000, 1500, 1900), omega(0.3 / 57.3, 0.2 / 57.3, 0.8 / 57.3);
  const FreeBody body{moments, Quaternion(1.0, 0.2, 0.3, 0.1), moments.cwiseProduct(omega)};
  const Torques torques(
      {Sunlight(prism(), {0.3, 0.5}, KeplerElements{1.327e20, 1.47e11, 0.0167, 0.0, {1, 0, 0}, {0, -0.4, 0.917}})});
  EXPECT_FALSE(torques.smooth());
  constexpr double last_s = 20000.0;
#ifdef NDEBUG
  const std::vector<double> tolerances_rad{1e-4, 1e-5, 3e-6};
  const double finest_rad = 1e-10;
#else  // for its time
  const std::vector<double> tolerances_rad{1e-3, 1e-4};
  const double finest_rad = 1e-6;
#endif
  const ExtrapolatedMotion truth(body, torques, {finest_rad, 0.0, last_s});
  ASSERT_LT(truth.error_rad(), 0.5 * tolerances_rad.back());
  for (const double tolerance_rad : tolerances_rad) {
    const TorquedMotion motion(body, torques, {tolerance_rad, 0.0, last_s});
    double worst = 0.0;
    for (int i = 0; i <= 100; ++i) {
      const double t_s = last_s * i / 100.0;
      worst =
          std::max(worst, rotation_angle_rad(motion.at(t_s).q_inertial_from_body, truth.at(t_s).q_inertial_from_body));
    }
    std::printf("facets to %g rad: %s, off by %.1e, error said to be %.1e\n", tolerance_rad,
                std::string(outcome_name(motion.outcome())).c_str(), worst, motion.error_rad());
    EXPECT_LE(worst, motion.error_rad() + truth.error_rad());
    ASSERT_EQ(motion.outcome(), Outcome::done);
    EXPECT_LE(worst, tolerance_rad + truth.error_rad());
    EXPECT_EQ(motion.account().max_error_rad, tolerance_rad);
  }
}

/// A ball with hills, 1196 facets.
TriangleMesh ball() {
  TriangleMesh mesh;
  constexpr unsigned bands = 24, around = 26;
  for (unsigned i = 0; i <= bands; ++i) {
    for (unsigned j = 0; j < around; ++j) {
      const double a = std::numbers::pi * i / bands, b = 2.0 * std::numbers::pi * j / around;
      const double r = 2.0 + 0.3 * std::sin(3.0 * b + 2.0 * a) * std::sin(a);
      mesh.vertices.emplace_back(r * std::sin(a) * std::cos(b) + 0.2, r * std::sin(a) * std::sin(b),
                                 1.5 * r * std::cos(a));
    }
  }
  for (unsigned i = 0; i < bands; ++i) {
    for (unsigned j = 0; j < around; ++j) {
      const unsigned a = i * around + j, b = i * around + (j + 1) % around;
      if (i > 0) mesh.facets.push_back({a, a + around, b});
      if (i < bands - 1) mesh.facets.push_back({b, a + around, b + around});
    }
  }
  return mesh;
}

/// Many facets put no tolerance out of reach, no plan claims to know what they cost, and a state between two steps
/// asks none of them.
TEST(Torqued, ManyFacetsAreReachedAndAnsweredAtOnce) {
  const TriangleMesh mesh = ball();
  ASSERT_EQ(mesh.facets.size(), 1196U);
  const Vector3 moments(1000, 1500, 1900), omega(0.3 / 57.3, 0.2 / 57.3, 0.8 / 57.3);
  const FreeBody body{moments, Quaternion(1.0, 0.2, 0.3, 0.1), moments.cwiseProduct(omega)};
  const Torques torques(
      {Sunlight(mesh, {0.3, 0.5}, KeplerElements{1.327e20, 1.47e11, 0.0167, 0.0, {1, 0, 0}, {0, -0.4, 0.917}})});
#ifdef NDEBUG
  constexpr double last_s = 20000.0;
#else  // for its time
  constexpr double last_s = 2000.0;
#endif
  const TorquedMotion truth(body, torques, {1e-7, 0.0, last_s});
  ASSERT_EQ(truth.outcome(), Outcome::done);
  for (const double tolerance_rad : {1e-4, 1e-5, 1e-6}) {
    const TorquedMotion motion(body, torques, {tolerance_rad, 0.0, last_s});
    EXPECT_EQ(motion.outcome(), Outcome::done) << tolerance_rad;
    constexpr int count = 300;
    std::vector<State> states;
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i <= count; ++i) states.push_back(motion.at(last_s * i / count));
    const std::chrono::duration<double, std::micro> each = (std::chrono::steady_clock::now() - begin) / states.size();
    double worst = 0.0;
    for (int i = 0; i <= count; ++i) {
      worst = std::max(worst, rotation_angle_rad(states[static_cast<std::size_t>(i)].q_inertial_from_body,
                                                 truth.at(last_s * i / count).q_inertial_from_body));
    }
    EXPECT_LE(worst, motion.error_rad() + truth.error_rad()) << tolerance_rad;
    std::printf("1196 facets to %g rad: off by %.1e, error said to be %.1e, %.1f us for a state\n", tolerance_rad,
                worst, motion.error_rad(), each.count());
#ifdef NDEBUG
    EXPECT_LT(each.count(), 200.0) << tolerance_rad;  // 4 where nothing else runs; it was 650 to 8000
#endif
    const Plan plan = plan_motion(body, torques, 0.0, last_s, tolerance_rad);
    if (plan.torque_evaluations) {
      const auto used = static_cast<double>(planned_motion(plan, body, 0.0, last_s).account.torque_evaluations);
      EXPECT_TRUE(used / 2.0 < *plan.torque_evaluations && *plan.torque_evaluations < 2.0 * used) << plan.cost_why;
    }
  }
}

}  // namespace
}  // namespace polhode
