#pragma once

#include <optional>
#include <string>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

/// Attitude and rate at one instant, of the axes that the user's file names ("named" axes). What a file does not say
/// is absent.
struct SpinState {
  Instant epoch;
  TimeScale epoch_scale = TimeScale::tdb;        ///< as written
  Frame frame = Frame::icrf;                     ///< inertial frame of q_frame_from_named
  std::optional<Quaternion> q_frame_from_named;  ///< unit length
  std::optional<Vector3> omega_named_rad_s;
};

/// A body as read from a file.
struct Body {
  std::string name;
  std::string source;  ///< where the numbers come from, in the file's words
  std::optional<Inertia> inertia;
  std::optional<SpinState> state;
  std::vector<std::string> missing;   ///< what a propagation would need and the file does not give; empty: complete
  std::vector<std::string> notes;     ///< what was understood, for people
  std::vector<std::string> warnings;  ///< what was assumed or looks doubtful
};

}  // namespace polhode
