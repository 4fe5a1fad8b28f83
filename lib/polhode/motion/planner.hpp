#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polhode/motion/motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// What one torque can do to an attitude over a span, from above, and what became of it.
struct PlannedEffect {
  std::string name;
  /// Swing within a turn: mean torque / (momentum x rate). Absent for a body at rest, which has no rate.
  std::optional<double> periodic_rad;
  /// Bound at the end of the span, swing included: every push taken in the worst direction. Absent, as the other, for a
  /// body at rest, and for a torque of one's own that does not say how large it may be.
  std::optional<double> secular_rad;
  bool kept = false;
  std::string why;
};

/// The cheapest sufficient model of a motion, and what is expected of it. What ran in the end is in
/// PlannedMotion::account.
struct Plan {
  std::vector<PlannedEffect> effects;
  Torques kept;
  std::string model;       ///< "principal-axis rotation", "symmetric top", "free triaxial", or the method to try first
  std::string why;         ///< of the model
  bool few_kicks = false;  ///< KickedMotion is tried before TorquedMotion
  double tolerance_rad = 0.0;  ///< of the propagation, if torques are kept
  double dropped_rad = 0.0;    ///< bound of all dropped effects together
  double error_rad = 0.0;      ///< at the most, if the propagation succeeds: dropped effects, propagation, rounding
  /// Expected within a factor of 2; absent where a trial over the first part of the span cannot tell.
  std::optional<double> torque_evaluations;
  std::string cost_why;      ///< of the number, or of its absence
  double sensitivity = 0.0;  ///< rad of attitude at the end per relative change of the momentum at the start
};

/// Torque evaluations that plans and propagations may take unless the caller allows more: some seconds of work. An
/// evaluation of a torque on many facets counts for several (Torques::cost_of_evaluation()).
constexpr std::size_t kMostTorqueEvaluations = 16'000'000;
/// The same where every effect was asked for, at 1e-9 rad: a minute and more.
constexpr std::size_t kMostTorqueEvaluationsInFull = 100'000'000;
/// The same for a motion without a plan, whatever its tolerance: some seconds, so fewer of several torques. (One torque
/// over a hundred thousand radians at 1e-12 rad takes seven million.)
inline std::size_t usual_torque_evaluations(const Torques& torques) {
  return static_cast<std::size_t>(16e6 / (1.0 + static_cast<double>(torques.list().size())));
}

/// Decides from bounds, before integrating, which torques matter for an attitude error of `accuracy_rad` over first_s …
/// last_s (which hold 0). Three quarters of the accuracy are for the motion, a quarter is left for interpolation
/// between rows of output.
///
/// The bound of a torque: its largest magnitude at any attitude, divided by the momentum, pushes the momentum at every
/// instant, each time in the worst direction; what such a push turns by the end of the span is the response of the
/// exact free motion after the time that is left, by its partial derivatives (at three places on the polhode, both ways
/// in time), doubled. An effect is dropped if all dropped ones together stay below half of the motion's
/// share; what they leave is for the propagation. `full` keeps everything, at 1e-9 rad. Where the body's numbers leave
/// the attitude uncertain by `uncertain_rad` at the end of the span, effects are also dropped that together stay below
/// a tenth of that: Plan::dropped_rad may then be larger than the accuracy. Torques whose own numbers are uncertain
/// (`uncertain`, of each torque; empty: none) are kept, since another value of them may matter.
///
/// Torques are in the axes of body.named_from_principal, in the plan too. Throws InputError for what checked() refuses,
/// a span without 0, an accuracy that is not positive and finite.
///
/// Few turns, or high accuracy: TorquedMotion. Many turns and a low accuracy: KickedMotion, where its trial finds that
/// it serves. Nothing kept: the exact free motion.
///
/// Throws InputError for an accuracy or a span that is none, for a torque whose bound over the span is not finite,
/// where the surroundings change too often in the span to be followed in 2 million steps, and for an accuracy that the
/// rounding of the free motion over the span leaves no room for.
Plan plan_motion(const FreeBody& body, const Torques& torques, double first_s, double last_s, double accuracy_rad,
                 bool full = false, double uncertain_rad = 0.0, const std::vector<bool>& uncertain = {});

/// What came of a plan.
struct PlannedMotion {
  std::unique_ptr<const Motion> motion;
  MotionAccount
      account;  ///< the error with that of dropped effects; the evaluations of all runs, also of those in vain
};

/// The motion that a plan describes: the exact free motion, a KickedMotion, or a TorquedMotion. Throws ComputationError
/// where the planned error is not reached, or not within so many torque evaluations.
PlannedMotion planned_motion(const Plan& plan, const FreeBody& body, double first_s, double last_s,
                             std::size_t most_torque_evaluations = kMostTorqueEvaluations);

}  // namespace polhode
