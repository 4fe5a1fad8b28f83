#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "rivals/integrated_motion.hpp"

namespace polhode::rivals {

/// A way of integrating the motion under torques.
struct TorquedMethod {
  std::string_view name;
  std::string_view kind;  ///< "exact kernel", "other kernel" or "general"
  std::string_view source;
  Run run;                        ///< for IntegratedMotion
  const SplittingScheme* scheme;  ///< of the kicks; null for the general-purpose ones
  bool fixed_step;                ///< controlled by StepControl::step_s, else by its tolerance
  bool fixed_free_step;           ///< and by StepControl::free_step_s
};

/// Splittings around the exact motion at fixed steps, every scheme; the same around the free methods of the literature;
/// general-purpose integrators.
std::span<const TorquedMethod> torqued_methods();

/// The motion over a span that holds t = 0 by one of torqued_methods(), or by "extrapolation" (ExtrapolatedMotion).
/// Throws InputError for another name, or a step where the method has none; ComputationError where extrapolation does
/// not reach its tolerance within the limit of evaluations. (The others answer NaN.)
std::unique_ptr<Motion> make_torqued_motion(std::string_view name, const FreeBody& body, const Torques& torques,
                                            const StepControl& control, double first_s, double last_s);

}  // namespace polhode::rivals
