#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "rivals/survey/measure.hpp"

namespace polhode::survey {

/// A body and how long to follow it.
struct Subject {
  std::string name;
  FreeBody body;
  double span_s = 0.0;
};

/// One method at one step or tolerance.
struct SpeedAccuracyRow {
  std::string_view method;
  std::string_view family;
  int instants = 0;      ///< evenly over the span, the last at its end; 1 is its end alone
  double step_s = 0.0;   ///< 0 where the method has none
  double tolerance = 0;  ///< 0 where the method has none
  Errors errors;
  double evaluations_per_instant = 0.0;
  double ns_per_instant = 0.0;  ///< processor time, construction included, one thread, the least of several runs
};

/// Told before each method; returns nothing.
using Told = std::function<void(std::string_view)>;

/// Every method over the span, at `instants` instants and again at the last one alone; fixed steps from a sixth of a
/// turn, halved, and tolerances from 1e-2, divided by ten, until rounding stops the progress or a run would take more
/// than `most_evaluations`. Deterministic but for the times.
std::vector<SpeedAccuracyRow> speed_accuracy(const Subject& subject, int instants, double most_evaluations,
                                             const Told& told = {});

}  // namespace polhode::survey
