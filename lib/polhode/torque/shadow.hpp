#pragma once

#include <vector>

#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// The share of the Sun's disc, 0 to 1, that is seen beside a ball of this radius: of umbra, penumbra and the shadow's
/// tip, where a ring is left (Montenbruck & Gill 2000, Satellite Orbits, section 3.4.2, with angles instead of their
/// small-angle ones). The disc is evenly bright (radius 695 700 km, IAU 2015 resolution B3), the ball without
/// atmosphere. Vectors are from the body to the Sun, and from the ball's centre to the body, which is outside of it.
double lit_share(const Vector3& to_sun_m, const Vector3& from_ball_m, double ball_radius_m);

/// When, within a span, the body comes into the penumbra, into the umbra (or where a ring is left), and out of them
/// again: ascending. A shadow that is only touched, for less than some seconds, may be missed.
std::vector<double> shadow_edges_s(const Trajectory& from_sun, const Trajectory& from_ball, double ball_radius_m,
                                   double first_s, double last_s);

}  // namespace polhode
