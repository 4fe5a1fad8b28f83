// The rival integrators under torques: that all converge to one motion, and their orders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/motion/torqued_motion.hpp"
#include "rivals/extrapolated_motion.hpp"
#include "rivals/integrated_motion.hpp"
#include "rivals/registry.hpp"
#include "rivals/torqued_methods.hpp"

namespace polhode::rivals {
namespace {

/// Every kind of term that a torque can have, and a jump at 40 s and 70 s.
Torques all_kinds_of_torques() {
  return Torques({GravityGradient(3.986e14, KeplerElements{3.986e14, 7e6, 0.1, 100.0, {1, 0, 0}, {0, 0.6, 0.8}}),
                  LinearDamping{{0.2, 0.5, 0.1}}, InternalDissipation{1e-5},
                  ThrusterPulse{40.0, 30.0, {0.02, -0.05, 0.03}}});
}
FreeBody satellite() {
  const Vector3 moments(600.0, 1000.0, 1300.0);
  return {moments, Quaternion(0.3, -0.5, 0.7, 0.2).normalized(), moments.cwiseProduct(Vector3(0.05, 0.04, -0.07))};
}

/// Greatest difference from extrapolation in long double, on both sides of t = 0.
double torqued_error(const TorquedMethod& method, const Torques& torques, const StepControl& control) {
  const FreeBody body = satellite();
  const std::vector<double> times{25.0, -60.0, 40.0, 55.0, 140.0, 200.0, 0.0};
  static const std::vector<State> truth = [&] {
    const ExtrapolatedMotion reference(body, torques, {1e-15, -60.0, 200.0});
    std::vector<State> states;
    states.reserve(times.size());
    for (const double t : times) states.push_back(reference.at(t));
    return states;
  }();
  const IntegratedMotion motion(body, torques, control, method.run, method.scheme);
  double worst = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const State one = motion.at(times[i]);
    const double error = rotation_angle_rad(one.q_inertial_from_body.normalized(), truth[i].q_inertial_from_body) +
                         (one.momentum_body - truth[i].momentum_body).norm() / truth[i].momentum_body.norm();
    if (!(error <= worst)) worst = error;
    if (std::isnan(error)) return error;
  }
  return worst;
}

TEST(TorquedRivals, AllConvergeToTheMotionUnderEveryKindOfTorque) {
  const Torques torques = all_kinds_of_torques();
  for (const TorquedMethod& method : torqued_methods()) {
    if (!method.fixed_step) {
      EXPECT_LT(torqued_error(method, torques, {.tolerance = 1e-9}), 1e-6) << method.name;
      EXPECT_LT(torqued_error(method, torques, {.tolerance = 1e-12}), 1e-9) << method.name;
      continue;
    }
    const bool second_order = method.name.ends_with("strang") || method.name.starts_with("three-rotations");
    const StepControl control{.step_s = 0.25, .free_step_s = second_order ? 0.002 : 0.25};
    EXPECT_LT(torqued_error(method, torques, control), second_order ? 3e-6 : 3e-8) << method.name;
  }
}

TEST(TorquedRivals, HaveTheirOrder) {
  const Torques torques = all_kinds_of_torques();
  const auto order_of = [&](std::string_view name, double step_s) {
    const auto method = std::find_if(torqued_methods().begin(), torqued_methods().end(),
                                     [&](const TorquedMethod& m) { return m.name == name; });
    const double coarse = torqued_error(*method, torques, {.step_s = step_s, .free_step_s = step_s});
    const double fine = torqued_error(*method, torques, {.step_s = step_s / 2, .free_step_s = step_s / 2});
    std::printf("%-28s measured %6.3f  (%.2e -> %.2e)\n", std::string(name).c_str(), std::log2(coarse / fine), coarse,
                fine);
    return std::log2(coarse / fine);
  };
  for (const std::string_view kernel : {"theta", "three-rotations", "top-rotation", "dmv", "dmv-6", "dmv-10"}) {
    EXPECT_NEAR(order_of(std::string(kernel) + " strang", 0.25), 2.0, 0.2) << kernel;
  }
  EXPECT_NEAR(order_of("rk4", 0.5), 4.0, 0.2);
  EXPECT_NEAR(order_of("dmv-6 near-10-6-4", 2.0), 6.0, 0.2);  // of the kernel: the kicks are finer
}

TEST(TorquedRivals, AtRestThereIsNoAnswer) {
  FreeBody body = satellite();
  body.momentum_body.setZero();
  const TorquedMethod& method = torqued_methods().front();
  EXPECT_TRUE(std::isnan(
      IntegratedMotion(body, all_kinds_of_torques(), {}, method.run, method.scheme).at(1.0).momentum_body[0]));
}

}  // namespace
}  // namespace polhode::rivals
