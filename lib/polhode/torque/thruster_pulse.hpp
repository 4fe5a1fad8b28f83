#pragma once

#include "polhode/torque/terms.hpp"

namespace polhode {

/// A constant torque in body axes while a thruster fires, from `start_s` for `duration_s` (positive). Propagation stops
/// at both ends of each pulse, so that its order is kept; `Torques::during` says what is on between them.
struct ThrusterPulse {
  double start_s = 0.0;
  double duration_s = 0.0;
  Vector3 torque_body = Vector3::Zero();  ///< N m, or unit of momentum / s

  double end_s() const { return start_s + duration_s; }
};

}  // namespace polhode
