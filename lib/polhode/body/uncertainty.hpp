#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/inertia.hpp"

namespace polhode {

struct Body;

/// What a small change of a published number does to a body at its epoch, to first order and per unit of the number. In
/// the axes that the body's file names.
struct EpochChange {
  Vector3 turn_rad = Vector3::Zero();     ///< small turn of the attitude, in body axes: q exp(turn/2)
  Vector3 omega_rad_s = Vector3::Zero();  ///< of the angular velocity, body axes
  Matrix3 tensor = Matrix3::Zero();       ///< of the tensor of inertia, in its unit
};

/// A number as a source publishes it.
struct PublishedNumber {
  std::string name;    ///< its key in a body file, with its part if it has several: "P_phi", "components.x"
  double value = 0.0;  ///< in the source's unit
  EpochChange change;  ///< per unit of `value`
};

/// How well the numbers of a body are known: those that are not exact, as published, and their covariance.
struct Uncertainty {
  std::vector<PublishedNumber> numbers;
  Eigen::MatrixXd covariance;  ///< of the values, in their units; symmetric, positive semidefinite
  /// The body with these values in the place of the published ones, all else as published; it has no uncertainty. No
  /// linear picture: a clone. Throws InputError where no body has them.
  std::function<Body(const Eigen::VectorXd& values)> body_with;

  Eigen::VectorXd values() const;
  double sigma(std::size_t number) const;
  /// Throws InputError unless there are numbers, the covariance has as many rows, is finite, symmetric and positive
  /// semidefinite (each within 1e-9 of its size).
  void check() const;
  /// A matrix F with F F^T = covariance: values + F z with normal z are draws. As many columns as there are numbers.
  Eigen::MatrixXd root() const;
  /// values() + root() z.
  Eigen::VectorXd values(const Eigen::MatrixXd& root, std::span<const double> z) const;
  /// The body of these.
  Body clone(const Eigen::MatrixXd& root, std::span<const double> z) const;
};

/// The covariance of independent numbers.
Eigen::MatrixXd independent(std::span<const double> sigmas);

/// The covariance if that number had a sigma smaller by this factor, 0 to 1: what another measurement of it, which
/// brings that, does to all others.
Eigen::MatrixXd known_better(const Uncertainty& uncertainty, std::size_t number, double factor);

/// Says of a body that its periods, all by one factor, are known to this part of themselves: adds to its uncertainty
/// the number "period_uncertainty", whose value is 0, or replaces its sigma. Throws InputError unless the part is
/// positive and finite, and where the rate or the periods have uncertainties of their own.
void set_period_uncertainty(Body& body, double part);

/// That part, if it was said.
std::optional<double> period_uncertainty(const Body& body);

/// A change of the body's published numbers as one of its principal state: what FreeBody holds.
struct PrincipalChange {
  Vector3 turn_rad;   ///< of the attitude of the principal axes, in these
  Vector3 momentum;   ///< in principal axes
  Vector3 moments;    ///< I1, I2, I3, each followed from where it is: equal ones need not be sorted
  Vector3 axes_turn;  ///< of the principal axes in the named ones, in principal axes, rad
};

/// Moments that are nearer each other than this part of the largest have no axes of their own that a product of inertia
/// could turn a little: separate_moments() takes them apart by it.
inline constexpr double kLeastSeparation = 1e-8;

/// The inertia, with moments that are that near each other taken apart.
Inertia separate_moments(const Inertia& inertia);

/// Of an inertia whose moments are apart if the change has products in its principal axes: else ComputationError.
PrincipalChange principal_change(const Inertia& inertia, const Vector3& omega_named_rad_s, const EpochChange& change);

/// The same the other way: the change of the named axes' attitude and rate that goes with one of the principal state,
/// and with one of the tensor.
EpochChange epoch_change(const Inertia& inertia, const Vector3& omega_named_rad_s, const Vector3& turn_rad,
                         const Vector3& momentum, const Matrix3& tensor);

/// Covariance of (theta0, m0, I), 9 x 9, of a body that has an uncertainty: a small turn of the principal axes at the
/// epoch and a change of the angular momentum along them, both given in the named axes, and the principal moments: what
/// partials of the motion are taken by. Throws InputError for a body without an uncertainty, inertia or rate.
Eigen::Matrix<double, 9, 9> epoch_covariance(const Body& body);

/// The same of (theta0, m0, I, axes), 12 x 12: and of a small turn of the principal axes in the body, in the named
/// axes, which products of inertia bring.
Eigen::Matrix<double, 12, 12> epoch_covariance_with_axes(const Body& body);

/// One sigma of E/E0 = 2 E I3 / L^2. Throws as epoch_covariance() does.
double energy_sigma(const Body& body);

}  // namespace polhode
