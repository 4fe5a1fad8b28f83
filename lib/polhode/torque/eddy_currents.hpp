#pragma once

#include <array>

#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// Torque of the currents that a magnetic field induces in a turning conductor, and the field of a dipole:
///
///     torque = B x (M dB/dt),   dB/dt = B x omega + (dB/dt seen by a body that does not turn)      body axes
///     B = (moment/r^3) (3 (a . r) r/r^2 - a)                                                        tesla
///
/// (Praly et al. 2012, Acta Astronautica 76; Ortiz Gomez & Walker 2015, Advances in Space Research 56, 494.) M, the
/// magnetic tensor, is in S m^4 = N m s / T^2: it is a conductivity times a length to the fifth.
struct EddyCurrents {
  static constexpr std::string_view name = "eddy currents";
  static constexpr std::array<std::string_view, 4> keys{"magnetic_tensor_s_m4", "dipole_t_m3", "dipole_axis", "orbit"};
  static constexpr bool needs_absolute_inertia = true;

  Matrix3 magnetic_tensor_s_m4;  ///< symmetric, body axes
  Vector3 dipole_axis;    ///< unit, inertial, along the magnetic moment: southward for the Earth, since the field
                          ///< at its equator points north
  double dipole_t_m3;     ///< field on the dipole's equator times the distance cubed, 0 or more; Earth 7.8e15
  Trajectory trajectory;  ///< of the body, from the dipole

  template <class Table>
  static EddyCurrents read(const Table& table) {
    return {table.matrix3("magnetic_tensor_s_m4"), table.direction("dipole_axis"), table.number("dipole_t_m3"),
            table.orbit().trajectory};
  }
  /// Throws InputError for a tensor that is not symmetric (within 1e-9 of its size), an axis that is not of length 1
  /// (likewise), a dipole that is negative, or a number that is not finite.
  void check() const;
  template <class Visit>
  void parameters(const Visit& visit) {
    Matrix3& M = magnetic_tensor_s_m4;
    visit("magnetic_tensor_xx", M(0, 0));
    visit("magnetic_tensor_yy", M(1, 1));
    visit("magnetic_tensor_zz", M(2, 2));
    visit("magnetic_tensor_yz", M(1, 2), &M(2, 1));
    visit("magnetic_tensor_zx", M(2, 0), &M(0, 2));
    visit("magnetic_tensor_xy", M(0, 1), &M(1, 0));
    visit("dipole_t_m3", dipole_t_m3);
  }
  EddyCurrents turned(const Matrix3& to_from) const {
    return {to_from * magnetic_tensor_s_m4 * to_from.transpose(), dipole_axis, dipole_t_m3, trajectory};
  }

  double largest(double t_s, const Vector3& moments, double momentum) const;

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    const Vector3Of<Real>&r = place.orbit->position_m, &v = place.orbit->velocity_m_s;
    const Vector3Of<Real> a = dipole_axis.cast<Real>();
    using std::sqrt;
    const Real r2 = r.squaredNorm(), strength = Real(dipole_t_m3) / (r2 * sqrt(r2)), ar = a.dot(r) / r2;
    const Real rv = r.dot(v) / r2;
    const Vector3Of<Real> field = strength * (3 * ar * r - a);
    const Vector3Of<Real> field_rate = 3 * strength * ((a.dot(v) / r2 - 5 * ar * rv) * r + ar * v + rv * a);
    const Vector3Of<Real> B = place.to_body(field);
    Matrix3Of<Real> cross;
    cross << 0, -B[2], B[1], B[2], 0, -B[0], -B[1], B[0], 0;
    const Matrix3Of<Real> induced = cross * magnetic_tensor_s_m4.cast<Real>();
    terms.constant += induced * place.to_body(field_rate);
    terms.damping -= induced * cross;  // B x (M (B x omega)) = -(cross^T M cross) omega
    terms.depends_on_rate = true;
  }
};

}  // namespace polhode
