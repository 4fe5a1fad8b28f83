#pragma once

#include "polhode/body/body.hpp"
#include "polhode/motion/motion.hpp"

namespace polhode {

/// The free body of a file at its epoch, in its principal axes and the given inertial frame; torques on it are given in
/// the axes that the file names. Throws InputError saying
/// what is missing, if the inertia, the attitude or the rate is, or if `inertial` turns with time. A state in a frame
/// that turns is taken as it stood at the epoch.
FreeBody free_body(const Body& body, Frame inertial = Frame::icrf);

/// A state in the axes that the body's file names.
struct NamedState {
  Quaternion q_inertial_from_named;
  Vector3 omega_named_rad_s;
  Vector3 momentum_named;  ///< unit of FreeBody::momentum_body
};

/// What a motion of this body answers, in those axes.
NamedState named_state(const FreeBody& body, const State& state);

}  // namespace polhode
