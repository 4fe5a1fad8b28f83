#pragma once

#include "polhode/base/geometry.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/body/spin_solution.hpp"
#include "polhode/motion/motion.hpp"
#include "polhode/observe/sight.hpp"

namespace polhode {

/// How an axis stands on the sky of an observer who looks at the body.
struct AxisOnSky {
  Direction icrf;                   ///< right ascension and declination
  double position_angle_rad = 0.0;  ///< of its projection, from north through east, 0 to 2 pi
  double aspect_angle_rad = 0.0;    ///< between the axis and the direction to the observer
};

/// The axis, in ICRF and of any length but 0, of a body from which the observer lies in this direction.
AxisOnSky axis_on_sky(const Vector3& axis_icrf, const Vector3& observer_from_target);

/// A body's attitude as seen.
struct Aspect {
  Direction sub_observer, sub_solar;  ///< planetocentric, in the named axes: longitude 0 to 2 pi
  AxisOnSky momentum, long_axis;
  Vector3 euler_angles_rad;  ///< phi, theta, psi of the convention, about axes with z along the angular momentum
};

/// What does not change while a body is observed.
struct AspectFrame {
  Quaternion q_icrf_from_inertial;  ///< of the motion's states
  Matrix3 named_from_principal = Matrix3::Identity();
  AxisConvention convention = AxisConvention::long_axis;
  /// In which phi counts from the plane of the frame's z axis and the angular momentum (q_frame_from_momentum()).
  Quaternion q_icrf_from_angles;
};

/// Of the state at emission. NaN throughout where the body is at rest or the state is no state.
Aspect aspect_of(const Sight& sight, const State& at_emission, const AspectFrame& frame);

/// phi, theta, psi of an attitude of the principal axes: the inverse of state_at().
Vector3 convention_angles_rad(AxisConvention convention, const Quaternion& q_momentum_from_principal);

}  // namespace polhode
