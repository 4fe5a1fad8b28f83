#pragma once

#include "polhode/torque/terms.hpp"

namespace polhode {

/// torque_i = -d_i omega_i in the principal axes: a viscous medium, the simplest model of loss.
struct LinearDamping {
  Vector3 coefficients;  ///< N m s, or unit of inertia / s

  template <class Real>
  void add(const TorquePlace<Real>&, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    terms.damping.diagonal() += coefficients.cast<Real>();
    terms.depends_on_rate = true;
  }
};

}  // namespace polhode
