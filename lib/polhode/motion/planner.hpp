#pragma once

#include <memory>
#include <string>
#include <vector>

#include "polhode/motion/motion.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// What one torque can do to an attitude over a span, from above, and what became of it.
struct PlannedEffect {
  std::string name;
  double periodic_rad = 0.0;  ///< swing within a turn: torque / (momentum x rate)
  double secular_rad = 0.0;   ///< bound at the end of the span, every push taken in the worst direction
  bool kept = false;
  std::string why;
};

/// The cheapest sufficient model of a motion, and what it promises.
struct Plan {
  std::vector<PlannedEffect> effects;
  Torques kept;
  std::string model;  ///< "principal-axis rotation", "symmetric top", "free triaxial", or the method under torques
  std::string why;    ///< of the model
  double tolerance_rad = 0.0;       ///< of the propagation, if torques are kept
  double dropped_rad = 0.0;         ///< bound of all dropped effects together
  double error_rad = 0.0;           ///< predicted: dropped effects and propagation
  double torque_evaluations = 0.0;  ///< predicted, from a trial over the first part of the span
  double sensitivity = 0.0;         ///< rad of attitude at the end per relative change of the momentum at the start
};

/// Decides from bounds, before integrating, which torques matter for an attitude error of `accuracy_rad` over first_s …
/// last_s (which hold 0).
///
/// The bound of a torque: the integral of its largest magnitude over the span, divided by the momentum, is how far it
/// can push the momentum, in any direction; the free motion's response to such a push is measured on the exact solution
/// (twelve perturbed momenta at eight times) and doubled. An effect is dropped if all dropped ones together stay below
/// half the accuracy; the other half is for the propagation. `full` keeps everything.
Plan plan_motion(const FreeBody& body, const Torques& torques, double first_s, double last_s, double accuracy_rad,
                 bool full = false);

/// The motion that a plan describes: the exact free motion, or a TorquedMotion.
std::unique_ptr<FreeMotion> planned_motion(const Plan& plan, const FreeBody& body, double first_s, double last_s);

/// Seconds after which the phase is lost to `accuracy_rad` if the periods are uncertain by this part of themselves.
double phase_horizon_s(const FreeBody& body, double relative_period_uncertainty, double accuracy_rad);

}  // namespace polhode
