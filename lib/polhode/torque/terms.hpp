#pragma once

#include <limits>
#include <span>
#include <string_view>

#include "polhode/base/geometry.hpp"

namespace polhode {

template <class Real>
using Vector3Of = Eigen::Matrix<Real, 3, 1>;
template <class Real>
using Matrix3Of = Eigen::Matrix<Real, 3, 3>;

/// What the torques on a body come to at one instant and one attitude, in the principal axes. Everything left to know
/// is the momentum m and the rate omega:
///
///     m' = m x omega + constant - damping omega + relaxation m x (m x omega)
///     q' = q (0, omega + relaxation m x omega) / 2
///
/// Each torque adds its part. A splitting method solves the part beside the free motion from these numbers. Units are
/// those of the body: constant in (unit of inertia)/s^2 (N m where that is kg m2), damping in (unit of inertia)/s,
/// relaxation in s/(unit of inertia).
template <class Real>
struct TorqueTerms {
  Vector3Of<Real> constant = Vector3Of<Real>::Zero();
  Matrix3Of<Real> damping = Matrix3Of<Real>::Zero();
  Real relaxation = 0;
  bool depends_on_rate = false;  ///< false: damping is 0

  /// The torque from outside, unit of m / s.
  Vector3Of<Real> torque(const Vector3Of<Real>& omega_rad_s) const {
    return depends_on_rate ? Vector3Of<Real>(constant - damping * omega_rad_s) : constant;
  }
};

/// A place and how it moves, inertial axes.
template <class Real>
struct OrbitState {
  Vector3Of<Real> position_m, velocity_m_s;
};

/// Where a torque is asked for: the rotation v_inertial = R v_principal, the body's place on the torque's trajectory
/// and on its second one (null for a torque that has none), the time, and the body's rate in the principal axes (NaN
/// where nobody knows it: only a torque of one's own asks for it).
template <class Real>
struct TorquePlace {
  Matrix3Of<Real> inertial_from_body;
  const OrbitState<Real>* orbit = nullptr;
  const OrbitState<Real>* second_orbit = nullptr;
  Real t_s = 0;
  Vector3Of<Real> omega_rad_s = Vector3Of<Real>::Constant(std::numeric_limits<Real>::quiet_NaN());

  Vector3Of<Real> to_body(const Vector3Of<Real>& v_inertial) const {
    return inertial_from_body.transpose() * v_inertial;
  }
};

struct FacetNormal;

/// See Torques::streams().
struct TorqueStream {
  Vector3 from_body;   ///< unit vector to where it comes from, body axes
  double pressure_pa;  ///< 0: it is not there
  std::span<const FacetNormal> edges;
};

/// Parameters that are components of a torque.
inline constexpr std::string_view kComponentNames[3] = {"torque_x", "torque_y", "torque_z"};

/// Throws InputError "`what` is …, a finite one is wanted" if an element is NaN or infinite.
void check_finite(std::string_view what, const Eigen::Ref<const Eigen::MatrixXd>& values);
void check_finite(std::string_view what, double value);

}  // namespace polhode
