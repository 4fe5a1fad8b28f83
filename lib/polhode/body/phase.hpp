#pragma once

#include <optional>
#include <string>

#include "polhode/body/body.hpp"

namespace polhode {

/// Seconds after (or before) the epoch in which the phase of a rotation at `omega_rad_s` comes to be off by this angle,
/// if its periods are uncertain by this part of themselves. Infinite for a body at rest.
double phase_horizon_s(const Vector3& omega_rad_s, double period_uncertainty, double angle_rad);

/// For people: after how long the phase of this body is uncertain by 1 deg, and when it is lost (by 180 deg, one
/// sigma), and whether what is wanted lies beyond, up to `farthest_s` from the epoch either way. Nothing if no
/// uncertainty is known or the body does not turn.
std::optional<std::string> phase_warning(const Body& body, double farthest_s = 0.0);

}  // namespace polhode
