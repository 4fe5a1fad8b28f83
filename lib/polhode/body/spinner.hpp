#pragma once

#include <utility>
#include <variant>

#include "polhode/base/geometry.hpp"

namespace polhode {

/// A body that spins about its z axis, as satellite operators describe it (CCSDS 504.0-B-2, annex F5). The axis may
/// nutate: it then turns about the angular momentum as well.
struct Spinner {
  /// The angular momentum is at this angle from the z axis, and the body turns about it once in the period. The phase
  /// is the angle in the plane of x and y, from x towards -y.
  struct Nutation {
    double angle_deg, period_s, phase_deg;
  };
  /// The angular momentum has this right ascension and declination, and the body turns about it at this rate.
  struct Momentum {
    double alpha_deg, delta_deg, rate_deg_s;
  };

  double alpha_deg = 0.0, delta_deg = 0.0;                 ///< right ascension and declination of the z axis
  double angle_deg = 0.0, rate_deg_s = 0.0;                ///< about the z axis
  std::variant<std::monostate, Nutation, Momentum> turns;  ///< of the z axis; the first: none
};

/// The attitude (v_frame = q v_body q*) and the angular velocity in body axes, rad/s.
std::pair<Quaternion, Vector3> attitude_and_rate(const Spinner& spinner);

}  // namespace polhode
