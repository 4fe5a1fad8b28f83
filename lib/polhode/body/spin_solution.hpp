#pragma once

#include <optional>
#include <vector>

#include "polhode/body/inertia.hpp"

namespace polhode {

/// Which body axis the Euler angles and periods of a tumbling asteroid follow (Samarasinha & Mueller 2015, Icarus 248,
/// 347): phi turns about the angular momentum, theta is the angle of that axis to it, psi turns about the axis. Z-X-Z;
/// the body's (x, y, z) are (intermediate, short, long) or (long, intermediate, short), so that psi = 0 is where the
/// angular momentum lies in the plane of the long and the short axis.
enum class AxisConvention { long_axis, short_axis };

/// From principal axes to (x, y, z) of a convention.
Matrix3 matrix_of(AxisConvention convention);

/// A tumbling motion as light-curve papers publish it.
struct PublishedPeriods {
  AxisConvention convention = AxisConvention::long_axis;
  double precession_period_s = 0.0;    ///< P_phi: mean time of one turn of the axis about the angular momentum
  double rotation_period_s = 0.0;      ///< P_psi: the polhode closes, whether psi turns or swings
  std::optional<bool> long_axis_mode;  ///< if the paper says it
};

/// The motion that has these periods. Energy and momentum follow from them and the ratios of inertia.
struct SpinSolution {
  bool long_axis_mode = false;
  double energy = 0.0;               ///< E/E0 = 2 E I3 / L^2
  double separatrix_distance = 0.0;  ///< m_c: 0 on the separatrix, 1 farthest
  double momentum = 0.0;             ///< L in the unit of the moments times rad/s
  Vector3 momentum_at_psi_zero;      ///< in principal axes, where psi = 0: no intermediate component
};

/// The motions that have these periods: energies at which P_psi / P_phi is as given, and the size of L from P_psi. One,
/// or one in each mode (short-axis mode first) if the mode is not given; a symmetric body has one mode. Throws
/// InputError where no energy has that ratio, naming the range, and for spheres.
std::vector<SpinSolution> solve_periods(const Inertia& inertia, const PublishedPeriods& periods);

/// A free rotation's state in its principal axes.
struct EulerState {
  Quaternion q_momentum_from_principal;  ///< from principal axes to axes with z along L
  Vector3 momentum_principal;
  double theta_rad = 0.0;  ///< between L and the convention's axis
};

/// The state at angles phi, psi (rad) of the convention; theta follows from the energy: that below 90 deg, or the other
/// one of the two. Throws InputError if no theta has that energy at this psi.
EulerState state_at(const Inertia& inertia, AxisConvention convention, const SpinSolution& motion, double phi_rad,
                    double psi_rad, bool theta_above_90_deg);

/// E/E0 of the state with these angles; only theta and psi matter.
double energy_at(const Inertia& inertia, AxisConvention convention, double theta_rad, double psi_rad);

/// v_frame = q v_momentum q*, of axes with z along the direction (longitude, latitude) and x in the plane of that and
/// the frame's z axis: Rz(longitude) Ry(90 deg - latitude), as in Kaasalainen 2001 (A&A 376, 302) and DAMIT.
Quaternion q_frame_from_momentum(double longitude_rad, double latitude_rad);

}  // namespace polhode
