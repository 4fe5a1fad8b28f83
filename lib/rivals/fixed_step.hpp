#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "rivals/integrated_motion.hpp"

namespace polhode::rivals {

/// Drives a fixed-step scheme: between two instants as many equal steps as make them no longer than the one wanted.
/// Equally spaced instants, equal but for the rounding of the times, share one scheme and its constants.
/// A scheme is made from (body, state, step), under torques from (problem, t, state, step).
template <class Scheme>
std::int64_t run_fixed_step(const Problem& problem, std::span<const double> times, ScaledState<double>* out) {
  ScaledState<double> y = problem.start;
  std::optional<Scheme> scheme;
  std::int64_t evaluations = 0;
  double t = 0.0, step = 0.0, steps = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double interval = times[i] - t;
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(times[i]);
    if (!scheme || !(std::abs(interval - steps * step) <= rounding)) {
      steps = std::ceil((std::abs(interval) - rounding) / problem.step);
      if (!(steps > 0.0)) steps = interval == 0.0 ? 0.0 : 1.0;
      step = steps > 0.0 ? interval / steps : 0.0;
      if (scheme) evaluations += scheme->evaluations;
      if constexpr (std::is_constructible_v<Scheme, const Problem&, double, const ScaledState<double>&, double>) {
        scheme.emplace(problem, t, y, step);
      } else {
        scheme.emplace(problem.body, y, step);
      }
    }
    // A step takes one evaluation at least: this is known beforehand, the rest below.
    if (!(steps + static_cast<double>(evaluations + scheme->evaluations) <=
          static_cast<double>(problem.max_evaluations))) {
      no_answer(out, i, times.size());
      return std::numeric_limits<std::int64_t>::max();
    }
    scheme->advance(y, static_cast<std::int64_t>(steps));
    if (!is_finite(y) || evaluations + scheme->evaluations > problem.max_evaluations) {
      no_answer(out, i, times.size());
      break;
    }
    t += steps * step;
    out[i] = y;
  }
  return evaluations + (scheme ? scheme->evaluations : 0);
}

}  // namespace polhode::rivals
