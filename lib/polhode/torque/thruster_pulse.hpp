#pragma once

#include <array>
#include <optional>

#include "polhode/torque/constant_torque.hpp"

namespace polhode {

/// A constant torque in body axes while a thruster fires, from `start_s` for `duration_s`. Propagation stops at both
/// ends of each pulse, so that its order is kept; `Torques::during` says what is on between them.
struct ThrusterPulse {
  static constexpr std::string_view name = "thruster pulse";
  static constexpr std::array<std::string_view, 3> keys{"torque_n_m", "start_s", "duration_s"};
  static constexpr bool needs_absolute_inertia = true;

  double start_s = 0.0;                   ///< on the body's clock
  double duration_s = 0.0;                ///< positive, and enough to end later than it starts
  Vector3 torque_body = Vector3::Zero();  ///< N m, or unit of momentum / s

  double end_s() const { return start_s + duration_s; }

  template <class Table>
  static ThrusterPulse read(const Table& table) {
    return {table.number("start_s"), table.positive_number("duration_s"), table.vector3("torque_n_m")};
  }
  /// Throws InputError for a duration that is not positive, or too short beside the start to count.
  void check() const;
  template <class Visit>
  void parameters(const Visit& visit) {
    for (int i = 0; i < 3; ++i) visit(kComponentNames[i], torque_body[i]);
  }
  ThrusterPulse turned(const Matrix3& to_from) const { return {start_s, duration_s, to_from * torque_body}; }
  double largest(double t_s, const Vector3&, double) const {
    return start_s <= t_s && t_s <= end_s() ? torque_body.norm() : 0.0;
  }

  std::array<double, 2> jumps_s() const { return {start_s, end_s()}; }
  std::optional<ConstantTorque> during(double inside_s) const {
    if (!(start_s < inside_s && inside_s < end_s())) return std::nullopt;
    return ConstantTorque{torque_body, ConstantTorque::Axes::body};
  }
};

}  // namespace polhode
