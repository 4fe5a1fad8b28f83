#pragma once

#include <limits>

namespace polhode {

/// How the accuracy that a user asks for is shared among what spends it. The shares stand here alone.
///
///     accuracy asked of a scene        motion: 3/4                    interpolation between rows: 1/4
///     of the motion's share            torques left out: at most 1/2  propagation: what they leave
///     of what --tolerance leaves       measured between rows: 9/10    what lies between the places measured: 1/10
///
/// The promises that follow are tested against independent runs in python_checks/test_promises.py, test_tolerance.py
/// and tests/unit/planner_test.cpp.
struct ErrorBudget {
  static constexpr double motion_of_accuracy = 0.75;
  static constexpr double dropped_of_motion = 0.5;
  static constexpr double measured_between_rows = 0.9;
  /// Rows that take more than this of a tolerance leave too little for the interpolation.
  static constexpr double rows_of_tolerance = 0.8;
  /// Of an exact motion, per condition number. The reference corpus is held to 4 eps; this is four times as much, since
  /// the condition number is measured at some times of a span only.
  static constexpr double rounding_rad = 16.0 * std::numeric_limits<double>::epsilon();
};

}  // namespace polhode
