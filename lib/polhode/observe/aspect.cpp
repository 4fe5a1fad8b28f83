#include "polhode/observe/aspect.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "polhode/body/euler.hpp"

namespace polhode {
namespace {

constexpr double turn = 2.0 * std::numbers::pi;

double positive(double angle_rad) { return angle_rad < 0.0 ? angle_rad + turn : angle_rad; }

Direction as_direction(const Vector3& v) {
  return {positive(std::atan2(v.y(), v.x())), std::atan2(v.z(), std::hypot(v.x(), v.y()))};
}

}  // namespace

AxisOnSky axis_on_sky(const Vector3& axis_icrf, const Vector3& observer_from_target) {
  const Vector3 axis = axis_icrf.normalized(), towards = observer_from_target.normalized();
  // The target's place on the sky is -towards; at a pole of ICRF north is along its x axis, as if it lay on the
  // meridian 0.
  const double across = std::hypot(towards.x(), towards.y());
  const double cosine = across > 0.0 ? -towards.x() / across : 1.0, sine = across > 0.0 ? -towards.y() / across : 0.0;
  const Vector3 east(-sine, cosine, 0.0);
  const Vector3 north(towards.z() * cosine, towards.z() * sine, across);
  AxisOnSky out;
  out.icrf = as_direction(axis);
  out.position_angle_rad = positive(std::atan2(axis.dot(east), axis.dot(north)));
  out.aspect_angle_rad = std::atan2(axis.cross(towards).norm(), axis.dot(towards));
  return out;
}

Vector3 convention_angles_rad(AxisConvention convention, const Quaternion& q_momentum_from_principal) {
  // The convention's (x, y, z) are (intermediate, short, long) or (long, intermediate, short).
  const bool is_long = convention == AxisConvention::long_axis;
  const Quaternion q_principal_from_convention =
      is_long ? Quaternion(0.5, 0.5, 0.5, 0.5) : Quaternion::Identity();  // x to 2, y to 3, z to 1
  static const EulerSequence zxz("ZXZ");
  const Vector3 angles = euler_angles_rad(zxz, q_momentum_from_principal * q_principal_from_convention);
  return {positive(angles[0]), angles[1], positive(angles[2])};
}

Aspect aspect_of(const Sight& sight, const State& at_emission, const AspectFrame& frame) {
  Aspect out;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3& momentum = at_emission.momentum_body;
  const Quaternion q_icrf_from_principal = frame.q_icrf_from_inertial * at_emission.q_inertial_from_body;
  if (!q_icrf_from_principal.coeffs().allFinite() || !momentum.allFinite() || momentum.isZero(0.0)) {
    const AxisOnSky none{{nan, nan}, nan, nan};
    out = {{nan, nan}, {nan, nan}, none, none, Vector3::Constant(nan)};
  }
  if (!q_icrf_from_principal.coeffs().allFinite()) return out;
  const Matrix3 icrf_from_principal = q_icrf_from_principal.toRotationMatrix();
  const Matrix3 named_from_icrf = frame.named_from_principal * icrf_from_principal.transpose();
  out.sub_observer = as_direction(named_from_icrf * sight.observer_from_target_m);
  out.sub_solar = as_direction(named_from_icrf * sight.sun_from_target_m);
  out.long_axis = axis_on_sky(icrf_from_principal.col(0), sight.observer_from_target_m);
  if (!momentum.allFinite() || momentum.isZero(0.0)) return out;
  const Vector3 momentum_icrf = icrf_from_principal * momentum;
  out.momentum = axis_on_sky(momentum_icrf, sight.observer_from_target_m);
  const Direction along = as_direction(frame.q_icrf_from_angles.conjugate() * momentum_icrf);
  const Quaternion q_icrf_from_momentum =
      frame.q_icrf_from_angles * q_frame_from_momentum(along.longitude_rad, along.latitude_rad);
  out.euler_angles_rad =
      convention_angles_rad(frame.convention, q_icrf_from_momentum.conjugate() * q_icrf_from_principal);
  return out;
}

}  // namespace polhode
