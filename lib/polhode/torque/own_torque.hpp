#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// What a torque of one's own is asked about: a body at one instant. Body axes are those that the body's inertia is
/// named in (FreeBody::named_from_principal): the principal ones, if nothing else was said.
struct TorqueQuestion {
  double t_s;                       ///< seconds on the body's clock
  Quaternion q_inertial_from_body;  ///< unit; v_inertial = q v_body q*
  Vector3 omega_rad_s;              ///< body axes
  Vector3 momentum_body;            ///< body axes, unit of FreeBody::momentum_body
  const OrbitState<double>* orbit;  ///< inertial axes; null for a torque without trajectory
};

/// A torque of one's own: derive from it, and hand an object to OwnTorque. It is asked at any time within the span (and
/// once within a step when a motion is asked for a state there), by several threads if several ask the motion, and
/// answers the same each time. What it throws reaches whoever asked for the motion.
class TorqueFunction {
 public:
  virtual ~TorqueFunction() = default;

  /// The torque in body axes, in N m if the moments are in kg m2. Finite, or InputError is thrown.
  virtual Vector3 torque(const TorqueQuestion& at) const = 0;
  /// Whether it has kinks or jumps in time, attitude or rate. One that has none is propagated in fewer evaluations; one
  /// that says so wrongly gets errors that are stated too small.
  virtual bool has_kinks() const { return true; }
  /// No attitude, and no momentum of this length, feels a larger torque at time t: lets a plan tell whether it matters.
  virtual double largest(double /*t_s*/, double /*momentum*/) const { return std::numeric_limits<double>::infinity(); }
};

/// A TorqueFunction among the torques on a body.
class OwnTorque {
 public:
  static constexpr std::string_view name = "own function";
  static constexpr bool needs_absolute_inertia = true;

  /// `way`: the trajectory on which the function is told the body's place. Throws InputError for a null pointer.
  explicit OwnTorque(std::shared_ptr<const TorqueFunction> function, std::optional<Trajectory> way = std::nullopt);

  void check() const {}  // nothing is left for it: see the constructor
  OwnTorque turned(const Matrix3& to_from) const;
  double largest(double t_s, const Vector3& /*moments*/, double momentum) const {
    return function_->largest(t_s, momentum);
  }
  bool has_kinks() const { return function_->has_kinks(); }

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>& moments, TorqueTerms<Real>& terms) const {
    std::optional<OrbitState<double>> orbit;
    if (place.orbit != nullptr) {
      orbit = {place.orbit->position_m.template cast<double>(), place.orbit->velocity_m_s.template cast<double>()};
    }
    terms.constant +=
        torque(static_cast<double>(place.t_s), place.inertial_from_body.template cast<double>(),
               place.omega_rad_s.template cast<double>(), moments.template cast<double>(), orbit ? &*orbit : nullptr)
            .template cast<Real>();
  }

  template <class Visit>
  void parameters(const Visit& /*visit*/) {}  // they are the function's own

  std::optional<Trajectory> trajectory;

 private:
  Vector3 torque(double t_s, const Matrix3& inertial_from_body, const Vector3& omega_rad_s, const Vector3& moments,
                 const OrbitState<double>* orbit) const;

  std::shared_ptr<const TorqueFunction> function_;
  Matrix3 own_from_body_ = Matrix3::Identity();  // the function's axes, and those of add()
};

}  // namespace polhode
