#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/torque/torques.hpp"
#include "rivals/survey/speed_accuracy.hpp"

namespace polhode::survey {

/// A body, what acts on it and how long to follow it, either way.
struct TorquedSubject {
  std::string name;
  FreeBody body;
  Torques torques;
  double span_s = 0.0;
};

/// One method at one step or tolerance.
struct TorquedRow {
  std::string method;
  std::string_view kind;          ///< "to an accuracy", "exact kernel", "other kernel", "general"
  int instants = 0;               ///< evenly over the span, the last at its end; 1 is its end alone
  double step_s = 0.0;            ///< 0 where the method has none
  double free_step_s = 0.0;       ///< of the kernel between kicks; 0 where it is exact
  double tolerance = 0.0;         ///< 0 where the method has none
  double attitude_rad = 0.0;      ///< greatest angle to the reference
  double momentum = 0.0;          ///< greatest |m - m_true| / |m_true|
  double evaluations = 0.0;       ///< of the torques, all that the answers took
  double kept_evaluations = 0.0;  ///< without the runs that only chose steps or told the error
  double time_ns = 0.0;           ///< of the processor, one thread, the least of several runs
};

/// What the methods are measured against: extrapolation in long double (ExtrapolatedMotion), to a far tighter
/// tolerance.
struct TorquedReference {
  double tolerance_rad = 0.0;
  double error_rad = 0.0;  ///< its own estimate
  std::string_view outcome;
  std::size_t evaluations = 0;
};

struct TorquedAccuracy {
  TorquedReference reference;
  std::vector<TorquedRow> rows;
};

/// Every method under torques over the span, at `instants` instants and again at the last one alone: TorquedMotion to
/// tolerances from 1e-2 in half decades, splittings at fixed steps from a turn, kernels that are not exact at free
/// steps as well, general-purpose integrators; until rounding stops the progress or a run would take more than
/// `most_evaluations` of the torques. Deterministic but for the times.
TorquedAccuracy torqued_accuracy(const TorquedSubject& subject, int instants, double most_evaluations,
                                 const Told& told = {});

}  // namespace polhode::survey
