#pragma once

#include <memory>
#include <string>
#include <vector>

#include "polhode/motion/motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// What one torque can do to an attitude over a span, from above, and what became of it.
struct PlannedEffect {
  std::string name;
  double periodic_rad = 0.0;  ///< swing within a turn: mean torque / (momentum x rate)
  double secular_rad = 0.0;   ///< bound at the end of the span, swing included: every push taken in the worst direction
  bool kept = false;
  std::string why;
};

/// The cheapest sufficient model of a motion, and what it promises.
struct Plan {
  std::vector<PlannedEffect> effects;
  Torques kept;
  std::string model;       ///< "principal-axis rotation", "symmetric top", "free triaxial", or the method under torques
  std::string why;         ///< of the model
  bool few_kicks = false;  ///< propagated by KickedMotion rather than by TorquedMotion
  double tolerance_rad = 0.0;       ///< of the propagation, if torques are kept
  double dropped_rad = 0.0;         ///< bound of all dropped effects together
  double error_rad = 0.0;           ///< predicted: dropped effects and propagation
  double torque_evaluations = 0.0;  ///< predicted, from a trial over the first part of the span
  double sensitivity = 0.0;         ///< rad of attitude at the end per relative change of the momentum at the start
};

/// Decides from bounds, before integrating, which torques matter for an attitude error of `accuracy_rad` over first_s …
/// last_s (which hold 0). Three quarters of the accuracy are for the motion, a quarter is left for interpolation
/// between rows of output.
///
/// The bound of a torque: its largest magnitude at any attitude, divided by the momentum, pushes the momentum at every
/// instant, each time in the worst direction; what such a push turns by the end of the span is the response of the
/// exact free motion after the time that is left, measured (twelve perturbed momenta, at three places on the polhode,
/// both ways in time) and doubled. An effect is dropped if all dropped ones together stay below half of the motion's
/// share; what they leave is for the propagation. `full` keeps everything, at 1e-9 rad.
///
/// Few turns, or high accuracy: TorquedMotion. Many turns and a low accuracy: KickedMotion, where its trial finds that
/// it serves. Nothing kept: the exact free motion.
Plan plan_motion(const FreeBody& body, const Torques& torques, double first_s, double last_s, double accuracy_rad,
                 bool full = false);

/// What came of a plan.
struct PlannedMotion {
  std::unique_ptr<const FreeMotion> motion;
  double error_rad = 0.0;              ///< of the propagation alone, as it estimates
  std::size_t torque_evaluations = 0;  ///< of all runs
};

/// The motion that a plan describes: the exact free motion, a KickedMotion, or a TorquedMotion. Throws ComputationError
/// where the planned error is not reached.
PlannedMotion planned_motion(const Plan& plan, const FreeBody& body, double first_s, double last_s);

/// Seconds after which the phase is lost to `accuracy_rad` if the periods are uncertain by this part of themselves.
double phase_horizon_s(const FreeBody& body, double relative_period_uncertainty, double accuracy_rad);

}  // namespace polhode
