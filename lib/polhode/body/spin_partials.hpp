#pragma once

#include <array>

#include "polhode/body/spin_solution.hpp"
#include "polhode/body/uncertainty.hpp"

namespace polhode {

/// A tumbling motion as published, solved.
struct PublishedTumbling {
  PublishedPeriods periods;
  SpinSolution motion;  ///< that solve_periods() found
  double longitude_rad = 0.0, latitude_rad = 0.0;
  double phi_rad = 0.0, psi_rad = 0.0;
  bool theta_above_90_deg = false;
};

/// Derivatives of the attitude and the angular momentum at the epoch by what is published, at fixed principal axes:
/// `turn` of the principal axes in these, `momentum` in them.
struct TumblingPartials {
  struct Column {
    Vector3 turn = Vector3::Zero(), momentum = Vector3::Zero();
  };
  Column longitude, latitude, phi, psi, precession_period, rotation_period;  ///< per rad and s
  std::array<Column, 3> moments;
};

/// In closed form but for the periods, which are differentiated along with their computation; the energy depends on
/// them by the theorem on implicit functions. The moments must be apart (separate_moments()), and the motion that of
/// the moments. Throws InputError where theta is 90 deg: there an angle's change is not in proportion to the energy's.
TumblingPartials tumbling_partials(const Inertia& inertia, const PublishedTumbling& spin);

}  // namespace polhode
