#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"

namespace polhode {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// A rotation as a unit quaternion with the Hamilton product. `q_to_from` maps components: v_to = q v_from q*. Eigen
/// stores x, y, z, w and constructs w, x, y, z; every raw array of ours is scalar first and passes through the two
/// functions below.
using Quaternion = Eigen::Quaterniond;

/// (q0, q1, q2, q3), scalar first.
inline Eigen::Vector4d scalar_first(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

/// The quaternion of (q0, q1, q2, q3), scalar first, as given (not normalised).
inline Quaternion from_scalar_first(const Eigen::Vector4d& q) { return {q[0], q[1], q[2], q[3]}; }

/// Angle of the rotation between two attitudes, 0 to pi, in radians; the signs of a and b are irrelevant and small
/// angles keep their digits. NaN if an input is NaN.
inline double rotation_angle_rad(const Quaternion& a, const Quaternion& b) {
  const Quaternion difference = a.conjugate() * b;
  return 2.0 * std::atan2(difference.vec().norm(), std::abs(difference.w()));
}

/// A direction as longitude, 0 to 2 pi, and latitude, in the axes of its vector: right ascension and declination in an
/// equatorial frame. The vector may have any finite length but 0: else InputError.
struct Direction {
  double longitude_rad = 0.0;
  double latitude_rad = 0.0;
};

inline Direction direction_of(const Vector3& v) {
  if (!v.allFinite() || v.isZero(0.0)) throw InputError("a vector of length 0, or not finite, has no direction");
  const double longitude_rad = std::atan2(v.y(), v.x());
  return {longitude_rad < 0.0 ? longitude_rad + 2.0 * std::numbers::pi : longitude_rad,
          std::atan2(v.z(), std::hypot(v.x(), v.y()))};
}

}  // namespace polhode
