#pragma once

// A satellite on a low orbit, its motion by extrapolation in long double, and how far another is from it.

#include <gtest/gtest.h>

#include <algorithm>

#include "polhode/motion/free_body.hpp"
#include "polhode/torque/torques.hpp"
#include "rivals/extrapolated_motion.hpp"

namespace polhode::test {

inline constexpr double kEarth = 3.986004418e14;

/// Envisat-like, on a circular low orbit.
inline FreeBody satellite(const Vector3& omega_rad_s = {0.02, 0.01, 0.04}) {
  const Vector3 moments(17000, 124800, 129200);
  return {moments, Quaternion(0.3, -0.5, 0.7, 0.2).normalized(), moments.cwiseProduct(omega_rad_s)};
}
inline constexpr double kRadius_m = 7.146e6;

inline Torques gravity(double eccentricity = 0.0) {
  return Torques(
      {GravityGradient(kEarth, KeplerElements{kEarth, kRadius_m, eccentricity, 100.0, {1, 0, 0}, {0, 0.6, 0.8}})});
}

inline State reference(const FreeBody& body, const Torques& torques, double span_s) {
  const rivals::ExtrapolatedMotion motion(body, torques, {1e-13, std::min(0.0, span_s), std::max(0.0, span_s)});
  EXPECT_LE(motion.error_rad(), 1e-13);
  return motion.at(span_s);
}

inline double distance(const State& a, const State& b) {
  return std::max(rotation_angle_rad(a.q_inertial_from_body, b.q_inertial_from_body),
                  (a.momentum_body - b.momentum_body).norm() / b.momentum_body.norm());
}

}  // namespace polhode::test
