#pragma once

#include "polhode/base/geometry.hpp"
#include "polhode/motion/motion.hpp"

namespace polhode {

/// Derivatives of a free motion at an instant, from its state by the equations of motion. Principal axes.
struct StateRates {
  Vector3 omega_body_rad_s;               ///< m_i / I_i
  Vector3 omega_rate_body_rad_s2;         ///< Euler: I omega' = m x omega
  Eigen::Vector4d q_rate_scalar_first_s;  ///< q' = q (0, omega) / 2
};

/// Each component is good to a few units in its last place, as far as the state is.
StateRates state_rates(const Vector3& principal_moments, const State& state);

}  // namespace polhode
