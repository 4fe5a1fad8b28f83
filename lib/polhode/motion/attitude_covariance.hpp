#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "polhode/body/body.hpp"
#include "polhode/motion/partials.hpp"

namespace polhode {

/// How well the attitude of a free body is known at any time, to first order: the covariance of its published numbers,
/// carried by the exact partial derivatives of the motion. Of a small turn of the axes that the body's file names, in
/// these axes, rad^2. What is published as exact, and the absence of torques, count as exact. Thread-safe.
class AttitudeCovariance {
 public:
  /// Throws InputError for a body without an uncertainty, and what free_body() throws.
  explicit AttitudeCovariance(const Body& body);
  /// The same with another covariance of the same numbers.
  AttitudeCovariance(const Body& body, const Eigen::MatrixXd& covariance);

  Matrix3 at(double t_s) const;
  /// The root of its largest eigenvalue: the one-sigma angle of the most uncertain turn.
  double sigma_rad(double t_s) const;
  /// What one sigma of each independent part of the uncertainty (a column of Uncertainty::root()) turns: its columns.
  Eigen::Matrix3Xd turns_at(double t_s) const;

  /// At many times: `sigma_rad` one for each, `covariance_rad2` six, xx, xy, xz, yy, yz, zz. Allocates once for all.
  void batch(const TimeArrays& times, std::span<double> sigma_rad, std::span<double> covariance_rad2) const;

 private:
  using TurnRows = Eigen::Matrix<double, 3, 9, Eigen::RowMajor>;
  Matrix3 of(const TurnRows& partials) const;

  FreePartials partials_;
  Matrix3 named_from_principal_;
  Eigen::Matrix<double, 9, Eigen::Dynamic> principal_;  // what a sigma of each part does to the principal state
  Eigen::Matrix3Xd axes_;                               // and to the principal axes
};

/// batch() on several threads, 0 meaning one per core. The same bits for every thread count.
void batch_threads(const AttitudeCovariance& covariance, const TimeArrays& times, std::span<double> sigma_rad,
                   std::span<double> covariance_rad2, unsigned thread_count = 0);

/// Beyond this the first order says nothing: a turn by it is no small one.
inline constexpr double kLinearSigma_rad = 0.3;

/// How far from the epoch, up to `farthest_s` (negative: before it), the linear picture holds: SIGMA is below
/// kLinearSigma_rad, and the second and third order, as motions show that are displaced by one sigma of each part of
/// the uncertainty, both ways, change it by less than 5 %. 0 if it does not hold at the epoch.
double linear_until_s(const Body& body, const AttitudeCovariance& covariance, double farthest_s);

/// For people, if `from_s` … `to_s` from the epoch lead beyond what `until_s` answers for each of them.
std::optional<std::string> linear_caution(const std::function<double(double farthest_s)>& until_s, double from_s,
                                          double to_s);

/// The largest eigenvalue of a covariance, 0 or more.
double largest_variance(const Matrix3& covariance);

/// SIGMA and the six elements xx, xy, xz, yy, yz, zz.
void put_covariance(const Matrix3& covariance, double& sigma_rad, double* covariance_rad2);

/// The turn of an attitude's difference as a vector along its axis, rad, at most pi long.
Vector3 rotation_vector(const Quaternion& q);

}  // namespace polhode
