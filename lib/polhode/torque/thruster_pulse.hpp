#pragma once

#include "polhode/torque/terms.hpp"

namespace polhode {

/// A constant torque in body axes while a thruster fires, from `start_s` for `duration_s`. Propagation stops at both
/// ends of each pulse, so that its order is kept; `Torques::during` says what is on between them.
struct ThrusterPulse {
  static constexpr std::string_view name = "thruster pulse";

  double start_s = 0.0;                   ///< on the body's clock
  double duration_s = 0.0;                ///< positive, and enough to end later than it starts
  Vector3 torque_body = Vector3::Zero();  ///< N m, or unit of momentum / s

  double end_s() const { return start_s + duration_s; }

  /// Throws InputError for a duration that is not positive, or too short beside the start to count.
  void check() const;
  ThrusterPulse turned(const Matrix3& to_from) const { return {start_s, duration_s, to_from * torque_body}; }
};

}  // namespace polhode
