#pragma once

#include <optional>

#include "polhode/body/body.hpp"

namespace polhode {

/// One sigma of a state about three axes, independent.
struct StateSigmas {
  Matrix3 named_from_axes = Matrix3::Identity();  ///< these axes, as columns, in the body's
  Vector3 turn_deg = Vector3::Zero();             ///< of a small turn about each
  std::optional<Vector3> rate_deg_s;              ///< of the angular velocity along each
};

/// Gives a body that has an attitude this uncertainty, in the place of any: of the numbers "turn.x", "turn.y", "turn.z"
/// (deg) and "rate.x" … (deg/s), whose values are 0.
void set_state_uncertainty(Body& body, const StateSigmas& sigmas);

}  // namespace polhode
