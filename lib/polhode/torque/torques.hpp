#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "polhode/torque/constant_torque.hpp"
#include "polhode/torque/eddy_currents.hpp"
#include "polhode/torque/gravity_gradient.hpp"
#include "polhode/torque/internal_dissipation.hpp"
#include "polhode/torque/linear_damping.hpp"
#include "polhode/torque/sunlight.hpp"
#include "polhode/torque/thruster_pulse.hpp"

namespace polhode {

using Torque = std::variant<GravityGradient, ConstantTorque, ThrusterPulse, LinearDamping, EddyCurrents,
                            InternalDissipation, Sunlight>;

/// "gravity gradient", "sunlight" …
std::string_view torque_name(const Torque& torque);

/// All torques on one body; they add up.
class Torques {
 public:
  Torques() = default;
  explicit Torques(std::vector<Torque> torques) : torques_(std::move(torques)) {}

  /// The sum at time t and attitude q (unit; v_inertial = q v_body q*), for a body of these principal moments. Thruster
  /// pulses are left out: see during().
  template <class Real>
  TorqueTerms<Real> at(Real t_s, const Eigen::Quaternion<Real>& q, const Vector3Of<Real>& moments) const {
    const TorquePlace<Real> place{t_s, q.toRotationMatrix()};
    TorqueTerms<Real> terms;
    for (const Torque& torque : torques_) {
      std::visit(
          [&](const auto& one) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(one)>, ThrusterPulse>) one.add(place, moments, terms);
          },
          torque);
    }
    return terms;
  }

  /// How fast the surroundings change at time t: the least r/v of the trajectories, infinite without one. A step that
  /// is not much longer cannot miss an encounter.
  double time_scale_s(double t_s) const;

  /// Times, ascending, at which a torque jumps: pulses, and where one part of a trajectory follows another.
  std::vector<double> jumps_s() const;
  /// The torques at work between two neighbouring jumps, pulses among them as constant ones. `inside_s` is any time
  /// between the two.
  Torques during(double inside_s) const;

  bool empty() const { return torques_.empty(); }
  const std::vector<Torque>& list() const { return torques_; }

 private:
  std::vector<Torque> torques_;
};

}  // namespace polhode
