#pragma once

#include <optional>
#include <string>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

/// Inertia of a rigid body about its centre of mass.
struct Inertia {
  /// I1 <= I2 <= I3, all positive, I1 + I2 >= I3 within rounding; kg m^2 if `absolute`, else any one unit.
  Vector3 principal_moments;
  /// The right-handed principal axes in the axes that the user's file names: v_named = q v_principal q*.
  Quaternion q_named_from_principal = Quaternion::Identity();
  /// False where only ratios are known: free motion needs no more, torques do.
  bool absolute = false;
};

/// Attitude and rate at one instant, of the axes that the user's file names ("named" axes). What a file does not say
/// is absent.
struct SpinState {
  Instant epoch;
  TimeScale epoch_scale = TimeScale::tdb;  ///< as written
  Frame frame = Frame::icrf;               ///< inertial frame of q_frame_from_named
  std::optional<Quaternion> q_frame_from_named;
  std::optional<Vector3> omega_named_rad_s;
};

/// A body as read from a file.
struct Body {
  std::string name;
  std::string source;  ///< where the numbers come from, in the file's words
  std::optional<Inertia> inertia;
  std::optional<SpinState> state;
  std::vector<std::string> notes;     ///< what was understood, for people
  std::vector<std::string> warnings;  ///< what was assumed or looks doubtful
};

}  // namespace polhode
