#pragma once

#include <array>

#include "polhode/torque/terms.hpp"

namespace polhode {

/// A torque that keeps its components.
struct ConstantTorque {
  enum class Axes { body, inertial };
  static constexpr std::string_view name = "constant";
  static constexpr std::array<std::string_view, 2> keys{"torque_n_m", "axes"};
  static constexpr bool needs_absolute_inertia = true;

  Vector3 torque;  ///< N m, or unit of momentum / s
  Axes axes = Axes::body;

  template <class Table>
  static ConstantTorque read(const Table& table) {
    const bool body = table.choice("axes", {"body", "frame"}) == 0;
    return {table.vector3("torque_n_m"), body ? Axes::body : Axes::inertial};
  }
  void check() const { check_finite("the torque", torque); }
  template <class Visit>
  void parameters(const Visit& visit) {
    for (int i = 0; i < 3; ++i) visit(kComponentNames[i], torque[i]);
  }
  ConstantTorque turned(const Matrix3& to_from) const {
    return axes == Axes::body ? ConstantTorque{to_from * torque, axes} : *this;
  }

  double largest(double, const Vector3&, double) const { return torque.norm(); }

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    const Vector3Of<Real> t = torque.cast<Real>();
    terms.constant += axes == Axes::body ? t : place.to_body(t);
  }
};

}  // namespace polhode
