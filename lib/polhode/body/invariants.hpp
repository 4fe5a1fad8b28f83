#pragma once

#include <optional>
#include <vector>

#include "polhode/body/body.hpp"

namespace polhode {

/// How a free body turns.
enum class RotationMode {
  rest,
  sphere,          ///< all moments equal: constant rate about any axis
  principal_axis,  ///< constant rate about one axis: L and omega are parallel
  short_axis,      ///< tumbling; L circles the short axis (largest moment) in the body: L^2/2E > I2
  long_axis,       ///< tumbling; L circles the long axis (smallest moment): L^2/2E < I2
  separatrix,      ///< L^2/2E = I2 within rounding: one flip, then for ever closer to the middle axis
};

/// "at rest", "sphere", "principal-axis rotation", "short-axis mode", "long-axis mode", "separatrix".
std::string_view name(RotationMode mode);

/// Mean motion of one body axis about the angular momentum L.
struct AxisMotion {
  double precession_period_s = 0.0;  ///< mean time of one turn about L
  double least_angle_rad = 0.0;      ///< between the axis and L; of the axis' two ends the one ...
  double greatest_angle_rad = 0.0;   ///< ... that is nearer L where it stays nearer, else either: least + greatest = pi
};

/// What a free motion keeps, and its periods. Lengths of time in s; inertia in the unit of the body's.
struct SpinInvariants {
  RotationMode mode = RotationMode::rest;
  double momentum = 0.0;      ///< L, unit of inertia times rad/s
  double twice_energy = 0.0;  ///< 2 E, unit of inertia times (rad/s)^2
  /// E/E0 - 1 = 2 E I3 / L^2 - 1 without its subtraction; E0 is the least energy with this L. 0 at rest.
  double energy_above_ground = 0.0;
  /// (L^2 - 2 E I2) / L^2 = 1 - E I2 / (E0 I3), signed: positive in short-axis mode.
  double separatrix_offset = 0.0;
  /// The complementary parameter m_c of the elliptic functions, 0 on the separatrix to 1: scale-free closeness. Absent
  /// where the body does not tumble.
  std::optional<double> separatrix_distance;
  /// P_psi = 4 K / |lambda|: the polhode closes, and omega in the body repeats. Infinite on the separatrix; absent
  /// where the body does not tumble.
  std::optional<double> polhode_period_s;
  /// Periods P_phi of the long-axis and of the short-axis convention (Samarasinha & Mueller 2015, Icarus 248, 347).
  std::optional<AxisMotion> long_axis, short_axis;
  /// Of principal-axis rotation and spheres.
  std::optional<double> rotation_period_s;
  int rotation_axis = -1;  ///< 0, 1, 2: principal axis of principal-axis rotation; else -1
};

/// From the angular momentum in principal axes. Closed forms; the periods keep about 13 digits (against integration of
/// Euler's equations, tests/unit/invariants_test.cpp) as far as the data determine them: near the separatrix their
/// logarithm needs digits of I and L that published values do not have.
SpinInvariants spin_invariants(const Inertia& inertia, const Vector3& momentum_principal);

/// A frequency that the light curve of a tumbling body shows: a sum of whole multiples of 1/P_phi and 1/P_psi.
struct LightCurveFrequency {
  const char* name;  ///< "2/P_phi - 2/P_psi"
  double per_s;      ///< may be negative
};

/// The lowest ones of a body whose brightness is the same when it is turned by half a turn about a principal axis, as
/// that of an ellipsoid is, and 1/P_phi, by the periods of the long-axis convention; a body of another form shows odd
/// multiples as well. None where the body does not tumble, or its polhode never closes.
std::vector<LightCurveFrequency> light_curve_frequencies(const SpinInvariants& spin);

/// Angular momentum of a state in principal axes, or in an inertial frame. Throw InputError if the inertia, the rate or
/// (in a frame) the attitude is missing, or is not what its description says.
Vector3 momentum_principal(const Body& body);
Vector3 momentum_in_frame(const Body& body, Frame frame);

}  // namespace polhode
