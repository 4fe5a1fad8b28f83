#pragma once

#include <array>

#include "polhode/torque/terms.hpp"

namespace polhode {

/// torque = -D omega, or torque_i = -d_i omega_i: a viscous medium, the simplest model of loss.
struct LinearDamping {
  static constexpr std::string_view name = "linear damping";
  static constexpr std::array<std::string_view, 1> keys{"coefficient_n_m_s"};
  static constexpr bool needs_absolute_inertia = true;

  Matrix3 coefficients;  ///< D in body axes, finite; N m s, or unit of inertia / s

  /// From the d_i along the body axes.
  explicit LinearDamping(const Vector3& along_axes) : coefficients(along_axes.asDiagonal()) {}

  template <class Table>
  static LinearDamping read(const Table& table) {
    return LinearDamping(Vector3::Constant(table.number("coefficient_n_m_s")));
  }
  void check() const { check_finite("the coefficient", coefficients); }
  template <class Visit>
  void parameters(const Visit& visit) {
    static constexpr std::string_view names[3] = {"coefficient_x", "coefficient_y", "coefficient_z"};
    for (int i = 0; i < 3; ++i) visit(names[i], coefficients(i, i));
  }
  LinearDamping turned(const Matrix3& to_from) const {
    LinearDamping other = *this;
    other.coefficients = to_from * coefficients * to_from.transpose();
    return other;
  }

  double largest(double t_s, const Vector3& moments, double momentum) const;

  template <class Real>
  void add(const TorquePlace<Real>&, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    terms.damping += coefficients.cast<Real>();
    terms.depends_on_rate = true;
  }
};

}  // namespace polhode
