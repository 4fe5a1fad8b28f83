#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polhode/motion/torqued_motion.hpp"

namespace polhode {

/// A motion under torques with its partial derivatives, in the shape of FreePartials: d(theta, m at t) by theta0, m0, I
/// and parameters of the torques, in the axes that the body's file names (PartialsMatrix has the meaning of rows and
/// columns). By the equations of a small change of the motion, over the steps of the motion: in power series, or from
/// values of the torques where the motion has no series. A column has about the relative error of the motion itself.
class TorquedPartials {
 public:
  using Matrix = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;

  /// By all parameters of the torques.
  explicit TorquedPartials(const TorquedMotion& motion) : TorquedPartials(motion, parameters_of(motion.torques())) {}
  /// By these alone.
  TorquedPartials(const TorquedMotion& motion, std::vector<TorqueParameter> parameters);

  /// Names of the columns: "theta0_x" ..., "m0_x" ..., "I1", "I2", "I3", then the parameters'.
  const std::vector<std::string>& columns() const { return columns_; }

  /// Throws what TorquedMotion::at() throws; NaN gives NaN.
  Matrix at(double t_high_s, double t_low_s = 0.0) const;
  /// 6 x columns().size() numbers for each time, row by row. Throws InputError if `matrices` has another length.
  void batch(const TimeArrays& times, std::span<double> matrices) const;

 private:
  Matrix3 named_from_principal_;
  std::vector<std::string> columns_;
  std::shared_ptr<const PropagatedMotion> engine_;
  std::shared_ptr<const PropagatedMotion::Partials> partials_;
};

/// Partial derivatives of the states of any motion.
struct StatePartialsSource {
  std::vector<std::string> parameters;  ///< "theta0_x" ..., as TorquedPartials::columns()
  /// d(theta, m)/d(parameters) at these times: 6 rows for each, in the named axes. Several threads may call it.
  std::function<void(const TimeArrays& times, std::span<double> matrices)> batch;
};

/// Of this motion of the body: those of TorquedPartials if it is a TorquedMotion, else those of free motion
/// (FreePartials). Throws InputError for a motion by few kicks, which has none.
StatePartialsSource state_partials_of(const Motion& motion, const FreeBody& body);

}  // namespace polhode
