#pragma once

#include <cstddef>
#include <optional>

#include "polhode/body/inertia.hpp"
#include "polhode/motion/motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// Attitude and momentum with the digits of long double (64 bits on x86, 113 on most others).
struct ExtendedState {
  Eigen::Quaternion<long double> q_inertial_from_body = Eigen::Quaternion<long double>::Identity();
  Vector3Of<long double> momentum_body = Vector3Of<long double>::Zero();
};

/// Gragg's modified midpoint rule with polynomial extrapolation in the square of the step, order 16 in 97 evaluations
/// (Hairer, Norsett & Wanner, Solving ODEs I, section II.9): knows nothing of the exact free motion, so that it checks
/// the other methods, takes over where torques are as large as the inertia forces, and with Real = long double goes
/// where doubles run out of digits.
template <class Real>
class Extrapolation {
 public:
  /// `torques`, in principal axes (Torques::in_principal_axes), must outlive it. Throws InputError for impossible
  /// moments.
  Extrapolation(const Vector3& principal_moments, const Torques& torques)
      : moments_(principal_moments.cast<Real>()), torques_(torques) {
    check_principal_moments(principal_moments);
  }
  Extrapolation(const Vector3&, const Torques&&) = delete;  // they would be gone

  struct Step {
    ExtendedState state;
    double error = 0.0;  ///< of attitude (rad) and momentum (relative) together, an estimate from above
  };
  /// One step of any length and sign.
  Step step(long double t_s, const ExtendedState& state, long double length_s);

  std::size_t torque_evaluations() const { return evaluations_; }

 private:
  using Values = Eigen::Matrix<Real, 7, 1>;  // q scalar first, m
  Values rate(const Torques::Surroundings<Real>& surroundings, const Values& y);

  Vector3Of<Real> moments_;
  const Torques& torques_;
  std::size_t evaluations_ = 0;
};

extern template class Extrapolation<double>;
extern template class Extrapolation<long double>;

}  // namespace polhode
