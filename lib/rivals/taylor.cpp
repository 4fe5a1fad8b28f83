#include "rivals/taylor.hpp"

#include <cmath>
#include <memory>

#include "rivals/fixed_step.hpp"
#include "rivals/general_purpose.hpp"

namespace polhode::rivals {

std::int64_t run_taylor(const Problem& problem, std::span<const double> times, ScaledState<double>* out) {
  const auto taylor = std::make_unique<Taylor<double>>(problem.body, problem.tolerance);
  ScaledState<double> y = problem.start;
  const double direction = times.back() < 0.0 ? -1.0 : 1.0;
  double t = 0.0;
  double step = direction * taylor->expand(y);
  for (std::size_t i = 0; i < times.size(); ++i) {
    while (direction * (times[i] - (t + step)) > 0.0) {
      y = taylor->at(step);
      t += step;
      step = direction * taylor->expand(y);
      if (!(std::abs(step) > 1e-15 * std::abs(t)) || taylor->evaluations > problem.max_evaluations) {
        no_answer(out, i, times.size());
        return taylor->evaluations;
      }
    }
    out[i] = with_common_turn(taylor->at(times[i] - t), problem.body.x[1] * times[i]);
  }
  return taylor->evaluations;
}

}  // namespace polhode::rivals
