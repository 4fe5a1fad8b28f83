#pragma once

#include <cstdint>

namespace polhode::rivals {

/// What an integrator takes where the choice is left to it.
inline constexpr double kDefaultStepsPerTurn = 100.0;  ///< at the initial rate
inline constexpr double kDefaultTolerance = 1e-10;

/// What a user may choose about an integrator. Zero leaves the choice to the method.
struct StepControl {
  double step_s = 0.0;  ///< of fixed-step methods; by default a turn / kDefaultStepsPerTurn
  /// Of adaptive methods, absolute and relative, |m| and |q| being 1; by default kDefaultTolerance.
  double tolerance = 0.0;
  /// Splittings between kicks of a torque: of the free motion, where that is not exact; by default one step per drift.
  double free_step_s = 0.0;
  /// A span that would cost more than about this is not computed: its answers are NaN. 0 is no limit.
  std::int64_t max_evaluations = 0;
};

}  // namespace polhode::rivals
