#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "polhode/motion/propagated_motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// How a propagation ended.
enum class Outcome {
  done,     ///< the whole span, within the tolerance
  stopped,  ///< the limit of torque evaluations ended it: states from first_s() to last_s() were reached
  tolerance_not_reachable,  ///< the whole span, but error_rad() is above the tolerance
};
std::string_view outcome_name(Outcome outcome);

struct TorquedOptions {
  /// Wanted error of the attitude anywhere in the span, in radians, for the numbers as given.
  double tolerance_rad = 1e-9;
  /// The span, which holds t = 0.
  double first_s = 0.0, last_s = 0.0;
  /// One of torqued_motion_methods(). "series": power series in time (SeriesMotion); "dormand-prince": steps of order 8
  /// by values of the torques (ValueMotion); "auto": series where all torques have them. The motion keeps no view of
  /// it.
  std::string_view method = "auto";
  /// Of all runs together: evaluations of the torques, or coefficients of series.
  std::size_t max_torque_evaluations = 100'000'000;
};

/// What TorquedOptions::method may be, "auto" first.
std::span<const std::string_view> torqued_motion_methods();

/// The motion of a rigid body under torques, from t = 0 both ways, computed once by one of the two engines and answered
/// at any time: by SeriesMotion, or by ValueMotion where a torque has no series. Their pages say how error_rad() is
/// found.
class TorquedMotion final : public Motion {
 public:
  /// Torques are in the axes of body.named_from_principal, as Torques says. Throws InputError for what checked()
  /// refuses, a span without 0, a tolerance that is not positive and finite, an unknown method, and "series" where a
  /// torque has none.
  TorquedMotion(const FreeBody& body, const Torques& torques, const TorquedOptions& options);

  /// Throws InputError for a time beyond what was propagated by more than end_room_s(); NaN gives NaN.
  State at(double t_high_s, double t_low_s = 0.0) const override { return engine_->at(t_high_s, t_low_s); }
  /// Where times ascend, or several lie in a step, much faster than one by one; the same bits.
  void batch(const TimeArrays& times, const StateArrays& out) const override { engine_->batch(times, out); }

  Outcome outcome() const { return outcome_; }
  const std::string& method() const { return method_; }      ///< the one that gave the states
  double error_rad() const { return engine_->error_rad(); }  ///< estimated, worst of the span
  /// What ran. The tolerance is promised if the outcome is `done`, else nothing.
  MotionAccount account() const;
  double first_s() const { return engine_->first_s(); }                                ///< reached
  double last_s() const { return engine_->last_s(); }                                  ///< reached
  std::size_t steps() const { return engine_->steps(); }                               ///< kept
  std::size_t torque_evaluations() const { return engine_->evaluations(); }            ///< of all runs
  std::size_t kept_torque_evaluations() const { return engine_->kept_evaluations(); }  ///< of the run that is kept
  const FreeBody& body() const { return body_; }
  const Torques& torques() const { return torques_; }  ///< in the axes that the body names

 private:
  friend class TorquedPartials;
  FreeBody body_;
  Torques torques_;
  std::shared_ptr<const PropagatedMotion> engine_;
  Outcome outcome_ = Outcome::done;
  std::string method_;
  double tolerance_rad_ = 0.0;
};

}  // namespace polhode
