#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/body/uncertainty.hpp"
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

/// An attitude between frames that a file names; they need not be inertial.
struct StatedAttitude {
  std::string block;                 ///< where in the file: "QUAT", "EULER", "SPIN", "ATT"
  std::string frame;                 ///< reference frame, as named
  std::string body;                  ///< body axes, as named
  std::optional<Frame> known_frame;  ///< of `frame`, if it is inertial
  Quaternion q_frame_from_body;
  std::optional<Vector3> omega_body_rad_s;  ///< relative to `frame`
};

/// A body as read from a file.
struct Body {
  std::string name;
  std::string id;      ///< designation, such as 1992-A01 or 20099942; empty: none is given
  std::string source;  ///< where the numbers come from, in the file's words
  std::optional<Inertia> inertia;
  bool any_inertia = false;  ///< `inertia` is not known, but any leads to this rotation about a principal axis
  std::optional<SpinState> state;
  std::shared_ptr<const Uncertainty> uncertainty;  ///< of the published numbers; null: they count as exact
  std::vector<StatedAttitude> attitudes;           ///< all that the file states, where `state` is chosen among several
  std::vector<std::string> missing;   ///< what a propagation would need and the file does not give; empty: complete
  std::vector<std::string> notes;     ///< what was understood, for people
  std::vector<std::string> warnings;  ///< what was assumed or looks doubtful
};

}  // namespace polhode
