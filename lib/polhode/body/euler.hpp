#pragma once

#include <array>
#include <string>
#include <string_view>

#include "polhode/base/geometry.hpp"

namespace polhode {

/// Three axes of rotation, as applied to go from the reference frame to the body: the first angle turns about that axis
/// of the frame, the second about the turned second axis, the third about the body's own axis (intrinsic). "ZXZ" or
/// "313", any case; no two neighbours alike: 12 sequences.
class EulerSequence {
 public:
  /// Throws InputError naming what is allowed.
  explicit EulerSequence(std::string_view name);

  std::string name() const;                                 ///< "ZXZ"
  const std::array<int, 3>& axes() const { return axes_; }  ///< 0, 1, 2 for x, y, z
  /// First axis = third, as in ZXZ: singular at second angle 0 and 180 deg; the others at -90 and 90 deg.
  bool proper() const { return axes_[0] == axes_[2]; }

 private:
  std::array<int, 3> axes_;
};

// The functions throw InputError for angles and rates that are not finite, and for a quaternion that is no attitude.

/// v_frame = q v_body q*.
Quaternion q_frame_from_body(const EulerSequence& sequence, const Vector3& angles_rad);

/// The three angles of an attitude: the first and third in (-pi, pi], the second in [0, pi] if proper, else in
/// [-pi/2, pi/2]. Near the singularity the digits of the attitude are kept, not those of the two outer angles; on it
/// the third is 0.
Vector3 euler_angles_rad(const EulerSequence& sequence, const Quaternion& q_frame_from_body);

/// Angular velocity in body axes of angles that change at these rates.
Vector3 omega_body_rad_s(const EulerSequence& sequence, const Vector3& angles_rad, const Vector3& rates_rad_s);

/// The rates of the three angles of a body that turns with this angular velocity, in body axes. Not finite where the
/// sequence is singular.
Vector3 euler_rates_rad_s(const EulerSequence& sequence, const Vector3& angles_rad, const Vector3& omega_body_rad_s);

}  // namespace polhode
