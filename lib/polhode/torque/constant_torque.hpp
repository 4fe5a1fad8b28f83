#pragma once

#include "polhode/torque/terms.hpp"

namespace polhode {

/// A torque that keeps its components.
struct ConstantTorque {
  enum class Axes { body, inertial };
  static constexpr std::string_view name = "constant torque";

  Vector3 torque;  ///< N m, or unit of momentum / s
  Axes axes = Axes::body;

  void check() const { check_finite("the torque", torque); }
  ConstantTorque turned(const Matrix3& to_from) const {
    return axes == Axes::body ? ConstantTorque{to_from * torque, axes} : *this;
  }

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    const Vector3Of<Real> t = torque.cast<Real>();
    terms.constant += axes == Axes::body ? t : place.to_body(t);
  }
};

}  // namespace polhode
