#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "polhode/motion/motion.hpp"
#include "polhode/torque/parameters.hpp"

namespace polhode {

struct PropagationOptions {
  double tolerance_rad = 1e-9;  ///< wanted error of the attitude anywhere in the span
  /// The span, which holds t = 0.
  double first_s = 0.0, last_s = 0.0;
  /// Of the torques, or coefficients of series, of all runs together.
  std::size_t most_evaluations = 100'000'000;
};

/// A motion under torques that was computed in steps from t = 0 both ways.
class PropagatedMotion : public Motion {
 public:
  bool whole() const { return whole_; }            ///< false: the limit of evaluations ended it
  double error_rad() const { return error_rad_; }  ///< estimated, worst of the span; infinite if nothing is known of it
  double first_s() const { return first_s_; }      ///< reached
  double last_s() const { return last_s_; }        ///< reached
  std::size_t steps() const { return steps_; }     ///< kept
  std::size_t evaluations() const { return evaluations_; }            ///< of all runs
  std::size_t kept_evaluations() const { return kept_evaluations_; }  ///< of the run that is kept

  /// The partial derivatives of the motion by theta0, m0, I and parameters of the torques: the columns of a matrix as
  /// in partials.hpp, in principal axes.
  class Partials {
   public:
    virtual ~Partials() = default;
    /// A matrix of 6 x (9 + parameters) for each time, row by row. Throws what at() throws.
    virtual void batch(const TimeArrays& times, std::span<double> matrices) const = 0;
  };
  /// Of the body and the torques that the motion was made for; one run more over its steps. The motion must outlive it.
  /// Throws InputError for a motion that has none.
  virtual std::unique_ptr<const Partials> partials(const FreeBody& body, const Torques& torques_named,
                                                   std::span<const TorqueParameter> parameters) const;

 protected:
  PropagatedMotion() = default;

  /// Whether a time is on the way forward. Beyond an end at t = 0 the other way's motion goes on. Throws what
  /// check_within() throws.
  bool is_forward(double t_s) const {
    check_within(t_s, first_s_, last_s_);
    return t_s >= 0.0 ? last_s_ > 0.0 || first_s_ == 0.0 : first_s_ == 0.0;
  }

  bool whole_ = true;
  double error_rad_ = 0.0;
  double first_s_ = 0.0, last_s_ = 0.0;
  std::size_t steps_ = 0, evaluations_ = 0, kept_evaluations_ = 0;
};

}  // namespace polhode
