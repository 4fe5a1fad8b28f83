#pragma once

#include "polhode/body/body.hpp"
#include "polhode/motion/motion.hpp"

namespace polhode {

/// The free body of a file at its epoch, in its principal axes and the given inertial frame. Throws InputError saying
/// what is missing, if the inertia, the attitude or the rate is, or if `inertial` turns with time. A state in a frame
/// that turns is taken as it stood at the epoch.
FreeBody free_body(const Body& body, Frame inertial = Frame::icrf);

}  // namespace polhode
