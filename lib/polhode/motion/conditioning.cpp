#include "polhode/motion/conditioning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polhode {

double condition_number(std::unique_ptr<FreeMotion> (*make)(const FreeBody&), const FreeBody& body, double t_s) {
  constexpr double change = 1e-12;  // far above rounding, far below what bends the answer
  const Quaternion attitude = make(body)->at(t_s).q_inertial_from_body;
  double worst = 1.0;
  const auto compare = [&](const FreeBody& changed) {
    const double moved = rotation_angle_rad(make(changed)->at(t_s).q_inertial_from_body, attitude) / change;
    if (!(moved <= worst)) worst = moved;  // keeps a NaN
  };
  for (int k = 0; k < 3; ++k) {
    FreeBody changed = body;
    // Away from the neighbours, so that the moments keep their order; the middle one has one side free unless all
    // three are equal.
    Vector3& moments = changed.principal_moments;
    const double sign = k == 0 || (k == 1 && moments[1] > moments[0]) ? -1.0 : 1.0;
    moments[k] *= 1.0 + sign * change;
    std::sort(moments.begin(), moments.end());
    compare(changed);
  }
  for (int k = 0; k < 3; ++k) {
    FreeBody changed = body;
    changed.momentum_body[k] *= 1.0 + change;
    compare(changed);
  }
  return worst;
}

double free_motion_error_rad(std::unique_ptr<FreeMotion> (*make)(const FreeBody&), const FreeBody& body, double first_s,
                             double last_s) {
  constexpr double units = 16.0;
  const double condition = std::max(condition_number(make, body, first_s), condition_number(make, body, last_s));
  return units * std::numeric_limits<double>::epsilon() * condition;
}

}  // namespace polhode
