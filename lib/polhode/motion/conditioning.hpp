#pragma once

#include "polhode/motion/methods.hpp"
#include "polhode/motion/motion.hpp"

namespace polhode {

/// How far the attitude moves, in radians, per relative change of one moment of inertia or of one component of the
/// momentum, the worst of them, at time t: by the exact partial derivatives. At least 1. It grows with the angle
/// turned, and near the separatrix much faster. Throws InputError for a time that is not finite, and what checked()
/// refuses.
double condition_number(const FreeBody& body, double t_s);

/// Promised error of attitudes between two times: 16 units in the last place per condition number, the largest one of
/// 33 times spread over the span. Twice the limit that the reference corpus is held to, and more. NaN where a part in
/// 1e12 of an input turns the body by more than 0.3 rad: nothing can then be said.
double free_motion_error_rad(const FreeBody& body, double first_s, double last_s);

/// What to say of a free motion by this method. Methods that are exact everywhere (Method::exact_everywhere) promise
/// free_motion_error_rad(); the others promise nothing before they are compared with one that does (measured_account).
MotionAccount free_motion_account(const Method& method, const FreeBody& body, double first_s, double last_s);

}  // namespace polhode
