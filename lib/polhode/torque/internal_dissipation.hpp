#pragma once

#include <array>

#include "polhode/torque/terms.hpp"

namespace polhode {

/// Loss of energy inside the body at constant momentum: no torque from outside, but the motion relaxes towards rotation
/// about the short axis. Modelled as the steepest descent of the energy on the sphere of constant |m|,
///
///     m' = m x omega + k m x (m x omega),     d(energy)/dt = -k |m x omega|^2
///
/// The momentum in space stays as it is because the principal axes move with omega + k m x omega: they slip a little
/// relative to a body turning at omega, which is what a body that is not quite rigid does.
struct InternalDissipation {
  static constexpr std::string_view name = "internal dissipation";
  static constexpr std::array<std::string_view, 1> keys{"quality_factor"};
  static constexpr bool needs_absolute_inertia = false;

  double relaxation;  ///< k, 1/(unit of momentum): k |m| is a number, the slip per radian turned; 0 or more

  /// From a quality factor: the energy above that of short-axis rotation decays by 2 pi/Q of itself per turn at the
  /// rate |m|/I3 (the definition of Burns & Safronov 1973, MNRAS 165, 403, with their shape and amplitude factors left
  /// out: Q is that of the wobble, not of the material). Throws InputError unless Q and the momentum are positive and
  /// the moments those of a body that is no sphere.
  static InternalDissipation from_quality_factor(double quality_factor, const Vector3& moments, double momentum);

  template <class Table>
  static InternalDissipation read(const Table& table) {
    const double quality_factor = table.positive_number("quality_factor");
    return table.located("kind",
                         [&] { return from_quality_factor(quality_factor, table.moments(), table.momentum()); });
  }
  void check() const;
  template <class Visit>
  void parameters(const Visit& visit) {
    visit("relaxation", relaxation);
  }
  const InternalDissipation& turned(const Matrix3&) const { return *this; }

  double largest(double, const Vector3& moments, double momentum) const {
    return relaxation * momentum * momentum * momentum * 0.5 * (1.0 / moments[0] - 1.0 / moments[2]);
  }

  template <class Real>
  void add(const TorquePlace<Real>&, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    terms.relaxation += Real(relaxation);
  }
};

}  // namespace polhode
