#pragma once

#include <memory>

#include "polhode/motion/motion.hpp"

namespace polhode {

/// How far the attitude moves, in radians, per relative change of one moment of inertia or of one component of the
/// momentum, the worst of them, at time t: measured by changing each by a part in 1e12 and evaluating again. At least
/// 1. It grows with the angle turned, and near the separatrix much faster.
double condition_number(std::unique_ptr<FreeMotion> (*make)(const FreeBody&), const FreeBody& body, double t_s);

/// Promised error of attitudes between two times: 16 units in the last place per condition number, the larger one of
/// the two ends, which is the limit that the reference corpus is held to.
double free_motion_error_rad(std::unique_ptr<FreeMotion> (*make)(const FreeBody&), const FreeBody& body, double first_s,
                             double last_s);

}  // namespace polhode
