#pragma once

#include <array>

#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// Torque of a point mass on the body's second moments (Hughes 1986, eq. 8.1(16)):
///
///     torque = 3 mu / r^5  r x (I r)          r in body axes; unit of inertia / s^2
///
/// The field's next terms are smaller by (size of the body)/r.
struct GravityGradient {
  static constexpr std::string_view name = "gravity gradient";
  static constexpr std::array<std::string_view, 1> keys{"orbit"};
  static constexpr bool needs_absolute_inertia = false;

  double mu_m3_s2;        ///< G times the mass, positive
  Trajectory trajectory;  ///< of the body, from that mass

  GravityGradient(double mu, Trajectory way) : mu_m3_s2(mu), trajectory(std::move(way)) {}

  template <class Table>
  static GravityGradient read(const Table& table) {
    return {table.orbit().mu_m3_s2, table.orbit().trajectory};
  }
  void check() const;
  template <class Visit>
  void parameters(const Visit& visit) {
    visit("mu_m3_s2", mu_m3_s2);
  }
  const GravityGradient& turned(const Matrix3&) const { return *this; }

  double largest(double t_s, const Vector3& moments, double momentum) const;

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>& I, TorqueTerms<Real>& terms) const {
    const Vector3Of<Real>& r = place.orbit->position_m;
    const Vector3Of<Real> x = place.to_body(r);
    using std::sqrt;
    const Real r2 = r.squaredNorm(), strength = 3 * Real(mu_m3_s2) / (r2 * r2 * sqrt(r2));
    terms.constant += strength * Vector3Of<Real>((I[2] - I[1]) * x[1] * x[2], (I[0] - I[2]) * x[2] * x[0],
                                                 (I[1] - I[0]) * x[0] * x[1]);
  }
};

}  // namespace polhode
