// Torques are given in the axes that the body's file names, whatever the principal axes are: a plain integration in the
// named axes, with the whole inertia tensor, is what every propagator must agree with.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/kicked_motion.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/motion/splitting.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/read/body.hpp"
#include "rivals/torqued_methods.hpp"

namespace polhode {
namespace {

constexpr double kEarth = 3.986004418e14;

Body envisat() { return read_body(POLHODE_DATA_DIR "/bodies/envisat.toml"); }

/// Torques whose numbers are told in body axes; larger than they are for Envisat, so that a wrong axis shows.
Torques torques_in_named_axes() {
  const KeplerElements orbit{kEarth, 7.146e6, 0.01, 100.0, {1, 0, 0}, {0, 0.6, 0.8}};
  Matrix3 tensor;
  tensor << 3e6, 1e5, 0, 1e5, 4e6, -2e5, 0, -2e5, 5e6;
  return Torques({ConstantTorque{{3.0, -1.0, 2.0}, ConstantTorque::Axes::body},
                  ConstantTorque{{0.5, 0.5, -0.7}, ConstantTorque::Axes::inertial},
                  ThrusterPulse{20.0, 30.0, {-4.0, 6.0, 10.0}}, LinearDamping{{2.0, 90.0, 30.0}},
                  EddyCurrents{tensor, Vector3(0.1, -0.2, 1).normalized(), 7.8e16, orbit}});
}

/// Kutta's method on q' = q (0, omega)/2 and I omega' = torque - omega x I omega, in the named axes.
NamedState integrated(const Body& body, const Torques& torques, double last_s, int steps) {
  const Inertia& inertia = *body.inertia;
  const Matrix3 tensor =
      inertia.named_from_principal * inertia.principal_moments.asDiagonal() * inertia.named_from_principal.transpose();
  using Y = Eigen::Matrix<double, 7, 1>;
  const auto rate = [&](double t, const Torques& on, const Y& y) {
    const Quaternion q = from_scalar_first(y.head<4>());
    const Vector3 omega = y.tail<3>();
    const Vector3 torque = on.at(t, q.normalized(), Vector3(1, 1, 1)).torque(omega);
    const Vector3 omega_rate = tensor.inverse() * (torque - omega.cross(tensor * omega));
    Y out;
    out << 0.5 * scalar_first(q * Quaternion(0.0, omega[0], omega[1], omega[2])), omega_rate;
    return out;
  };
  Y y;
  y << scalar_first(*body.state->q_frame_from_named), *body.state->omega_named_rad_s;
  const double h = last_s / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = h * i;
    const Torques on = torques.during(t + 0.5 * h);
    const Y k1 = rate(t, on, y), k2 = rate(t + 0.5 * h, on, y + 0.5 * h * k1),
            k3 = rate(t + 0.5 * h, on, y + 0.5 * h * k2), k4 = rate(t + h, on, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  const Vector3 omega = y.tail<3>();
  return {from_scalar_first(y.head<4>()).normalized(), omega, tensor * omega};
}

double off_rad(const NamedState& a, const NamedState& b) {
  return std::max(rotation_angle_rad(a.q_inertial_from_named, b.q_inertial_from_named),
                  (a.momentum_named - b.momentum_named).norm() / b.momentum_named.norm());
}

TEST(BodyAxes, TorquesAreInTheNamedAxesOfTheBodyForEveryPropagator) {
  const Body body = envisat();
  const FreeBody free = free_body(body, body.state->frame);
  const double apart_rad = rotation_angle_rad(Quaternion(free.named_from_principal), Quaternion::Identity());
  EXPECT_GT(apart_rad, 0.02);
  const double last_s = 200.0;
  const Torques torques = torques_in_named_axes();
  const NamedState truth = integrated(body, torques, last_s, 4000);  // ends and begins of the pulse are ends of steps
  // Taken in the principal axes, they would turn the body to elsewhere.
  FreeBody mistaken = free;
  mistaken.named_from_principal = Matrix3::Identity();
  const TorquedMotion elsewhere(mistaken, torques, {1e-9, 0.0, last_s});
  EXPECT_GT(off_rad(named_state(free, elsewhere.at(last_s)), truth), 1e-3);

  for (const std::string_view method : torqued_motion_methods()) {
    const TorquedMotion motion(free, torques, {1e-9, 0.0, last_s, method});
    EXPECT_LT(off_rad(named_state(free, motion.at(last_s)), truth), 1e-7) << method;
  }
  const Plan plan = plan_motion(free, torques, 0.0, last_s, 1e-8);
  EXPECT_LT(off_rad(named_state(free, planned_motion(plan, free, 0.0, last_s).motion->at(last_s)), truth), 1e-7);
  for (const rivals::TorquedMethod& method : rivals::torqued_methods()) {
    if (method.kind != "general") continue;
    const rivals::IntegratedMotion motion(free, torques, {.tolerance = 1e-12}, method.run, method.scheme);
    EXPECT_LT(off_rad(named_state(free, motion.at(last_s)), truth), 1e-6) << method.name;
  }
  const Torques steady({torques.list()[0], torques.list()[3]});
  SplittingRun run(free, 0.0, steady, kNear1064);
  for (int i = 0; i < 100; ++i) run.step(2.0);
  EXPECT_LT(off_rad(named_state(free, run.state()), integrated(body, steady, last_s, 4000)), 1e-7);
}

TEST(BodyAxes, StatesAreGivenBackInTheNamedAxes) {
  const Body body = envisat();
  const FreeBody free = free_body(body, body.state->frame);
  const NamedState start = named_state(free, {free.q_inertial_from_body, free.momentum_body});
  EXPECT_LT(rotation_angle_rad(start.q_inertial_from_named, *body.state->q_frame_from_named), 1e-15);
  EXPECT_LT((start.omega_named_rad_s - *body.state->omega_named_rad_s).norm(), 1e-16);
}

TEST(BodyAxes, TheMeshOfSunlightIsInTheNamedAxes) {
  TriangleMesh plate;
  plate.vertices = {{3, 0, 0}, {3, 1, 9}, {2, 7, 0}};
  plate.facets = {{0, 1, 2}, {0, 2, 1}};
  const KeplerElements sun{1.32712440018e20, 1.496e11, 0.0, 0.0, {0.3, -0.8, 0.2}, {0, 0.25, 1}};
  const Sunlight light(plate, {0.2, 0.5}, sun);
  const Matrix3 R = envisat().inertia->named_from_principal;
  const Torques turned = Torques({light}).in_principal_axes(R);
  const Vector3 to_sun_named(0.5e11, -1.2e11, 0.4e11);
  const Vector3 named = light.torque(to_sun_named),
                principal = std::get<Sunlight>(turned.list()[0]).torque(R.transpose() * to_sun_named);
  EXPECT_LT((R * principal - named).norm(), 1e-14 * named.norm());
  EXPECT_GT((principal - named).norm(), 1e-2 * named.norm());
}

TEST(BodyAxes, TorquesOfABodyWhoseAxesAreThePrincipalOnesKeepTheirBits) {
  const Torques torques = torques_in_named_axes();
  const Torques same = torques.in_principal_axes(Matrix3::Identity());
  EXPECT_EQ(std::get<EddyCurrents>(same.list()[4]).magnetic_tensor_s_m4,
            std::get<EddyCurrents>(torques.list()[4]).magnetic_tensor_s_m4);
  EXPECT_THROW(torques.in_principal_axes(2.0 * Matrix3::Identity()), InputError);
  EXPECT_THROW(torques.in_principal_axes(-Matrix3::Identity()), InputError);
  EXPECT_THROW(torques.in_principal_axes(Matrix3::Constant(std::nan(""))), InputError);
}

}  // namespace
}  // namespace polhode
