#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "rivals/survey/measure.hpp"

namespace polhode::survey {

/// One cell of a stability map for one method.
struct StabilityRow {
  std::string_view map;  ///< of stability_maps()
  double x = 0.0, y = 0.0;
  std::string_view method;
  /// "answered"; "failed": an exception, NaN or no convergence; "too long": more than the permitted evaluations;
  /// "undetermined": the inputs' last digits decide the answer, eps kappa > 1.
  std::string_view outcome;
  double error = 0.0;        ///< greatest of attitude angle in radians and relative momentum
  double kappa = 0.0;        ///< the greatest condition number of an instant
  double digits_lost = 0.0;  ///< log10 of the greatest error / (eps max(1, kappa))
};

/// A map: what its axes are.
struct StabilityMap {
  std::string_view name, title, x_label, y_label;
};
const std::vector<StabilityMap>& stability_maps();

/// Every method on every map. `size` 1 is the default resolution, two decades a cell; 2 is twice as fine. Fixed steps
/// are a hundredth of a turn, from order 6 on a twenty-fifth, tolerances 1e-13; a cell that would cost an integrator
/// more than `most_evaluations` is not computed. `told` hears of each map's progress.
std::vector<StabilityRow> stability(double size, double most_evaluations,
                                    const std::function<void(std::string_view)>& told = {});

}  // namespace polhode::survey
