#pragma once

#include <limits>
#include <optional>

#include "polhode/motion/theta.hpp"

namespace polhode {

/// Mean rates of a free motion in closed form (theta.md, "Mean rates"); of a constant momentum only the rotation.
struct MeanRates {
  double polhode_period_s =
      std::numeric_limits<double>::infinity();  ///< P_psi = 4 K / |lambda|; infinite on the separatrix
  double long_axis_precession_rad_s = 0.0;   ///< mean rate of e1 about the momentum: 2 pi / P_phi, long-axis convention
  double short_axis_precession_rad_s = 0.0;  ///< mean rate of e3 about it, short-axis convention
};

MeanRates mean_rates(const ThetaMotion& motion);

/// The first instant after `after_s` at which the middle axis passes the plane across the momentum (m2 = 0), which is
/// the middle of a flip of a body that spins near its middle axis: the T-handle's. In closed form, to a few ulp of the
/// time and the polhode's period. Infinity if there is none: constant momentum, or on the separatrix after its only
/// flip. Throws InputError for a time that is not finite.
double next_flip_s(const ThetaMotion& motion, double after_s);

/// A passage of a body axis near an inertial direction.
struct AxisPass {
  double time_s;
  double angle_rad;  ///< at that time
};

/// The first instant in [after_s, until_s] at which the body axis (unit vector, principal axes) is within `within_rad`
/// of the inertial direction (unit vector). Steps are bounded by the fastest that the body can turn, so that no passage
/// deeper than 1e-9 rad is missed; the time is good to 1e-9 rad of motion. Throws InputError for vectors of another
/// length (by more than 1e-9), a negative angle, times that are not finite, and what checked() refuses.
std::optional<AxisPass> next_pass(const ThetaMotion& motion, const FreeBody& body, const Vector3& axis_body,
                                  const Vector3& direction_inertial, double within_rad, double after_s, double until_s);

}  // namespace polhode
