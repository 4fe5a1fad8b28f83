#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/motion/extrapolation.hpp"
#include "polhode/motion/motion.hpp"
#include "polhode/motion/series_motion.hpp"
#include "polhode/motion/splitting.hpp"
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
  /// One of torqued_motion_methods(). "series": power series in time (SeriesMotion); "extrapolation-double";
  /// "extrapolation" in long double; or "auto": series where all torques have them, else extrapolation, in long double
  /// where doubles cannot meet the tolerance. The motion keeps no view of it.
  std::string_view method = "auto";
  /// Of all runs together: evaluations of the torques, or coefficients of series.
  std::size_t max_torque_evaluations = 100'000'000;
  /// If not null, steps of this splitting, with lengths chosen by their error, take the place of `method`. The scheme
  /// must outlive the motion.
  const SplittingScheme* splitting = nullptr;
};

/// What TorquedOptions::method may be, "auto" first.
std::span<const std::string_view> torqued_motion_methods();

/// What rounding in doubles comes to over so many radians of rotation. Where it is above the tolerance, "auto" without
/// series begins with long double.
double rounding_of_doubles_rad(double phase_rad);

/// The motion of a rigid body under torques, from t = 0 both ways, computed once and answered at any time.
///
/// By series: see SeriesMotion. Otherwise steps are chosen by an estimate of their error, weighted by how a change of
/// momentum grows until the end: by doing each step whole and in halves (splitting), or from the columns of the
/// extrapolation. That says nothing about how errors grow on a chaotic path, so the whole span is then done again,
/// finer, until two such runs agree within the tolerance; error_rad() is their difference (the finer one is kept, whose
/// error is smaller still). Where rounding keeps them apart, extrapolation in long double takes over. Torques with
/// kinks (Torques::smooth()) do not let the error fall as steps shorten: for them error_rad() is four times the
/// difference. Between the ends of steps a state is a shorter step of the same method from the last end: full order
/// everywhere.
class TorquedMotion final : public Motion {
 public:
  /// Torques are in the axes of body.named_from_principal, as Torques says. Throws InputError for what checked()
  /// refuses, a span without 0, a tolerance that is not positive and finite, an unknown method.
  TorquedMotion(const FreeBody& body, const Torques& torques, const TorquedOptions& options);

  /// Throws InputError for a time beyond what was propagated by more than end_room_s(); NaN gives NaN.
  State at(double t_high_s, double t_low_s = 0.0) const override;
  void batch(const TimeArrays& times, const StateArrays& out) const override;

  Outcome outcome() const { return outcome_; }
  const std::string& method() const { return method_; }  ///< the one that gave the states
  double error_rad() const { return error_rad_; }        ///< estimated, worst of the span
  /// What ran. The tolerance is promised if the outcome is `done`, else nothing.
  MotionAccount account() const;
  double first_s() const { return first_s_; }                                ///< reached
  double last_s() const { return last_s_; }                                  ///< reached
  std::size_t steps() const;                                                 ///< kept
  std::size_t torque_evaluations() const { return evaluations_; }            ///< of all runs
  std::size_t kept_torque_evaluations() const { return kept_evaluations_; }  ///< of the run that is kept

 private:
  struct Node {
    double t_s;
    ExtendedState state;
  };
  /// How to go on.
  struct Way {
    const SplittingScheme* scheme = nullptr;  ///< null: extrapolation
    bool extended = false;                    ///< extrapolation in long double
  };
  /// Nodes between two jumps of the torques, away from t = 0.
  struct Leg {
    Torques torques;
    std::vector<Node> nodes;
  };
  using Path = std::vector<Leg>;  // one direction, from t = 0 outward
  class Builder;
  void follow_series(const FreeBody& body, const Torques& torques, const TorquedOptions& options);

  Vector3 moments_;
  Way way_;
  Path forward_, backward_;
  double first_s_ = 0.0, last_s_ = 0.0;
  Outcome outcome_ = Outcome::done;
  std::string method_;
  double tolerance_rad_ = 0.0;
  double error_rad_ = 0.0;
  std::size_t evaluations_ = 0, kept_evaluations_ = 0;
  std::shared_ptr<const SeriesMotion> series_;  // or null
};

}  // namespace polhode
