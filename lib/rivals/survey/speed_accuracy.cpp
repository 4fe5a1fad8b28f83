#include "rivals/survey/speed_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polhode::survey {

namespace {

constexpr double longest_step_turns = 1.0 / 6.0;
constexpr double loosest_tolerance = 1e-2, tightest_tolerance = 1e-18;

SpeedAccuracyRow measured(const Subject& subject, const rivals::MeasuredMethod& method,
                          const rivals::StepControl& control, const std::vector<double>& times,
                          const std::vector<rivals::ScaledState<rivals::Quadruple>>& truth) {
  SpeedAccuracyRow row;
  row.method = method.name;
  row.family = method.family;
  row.instants = static_cast<int>(times.size());
  row.step_s = control.step_s;
  row.tolerance = control.tolerance;
  Answers answers;
  const double least = least_time_ns([&] { answers = answer(method, subject.body, control, times); });
  const auto count = static_cast<double>(times.size());
  row.ns_per_instant = least / count;
  row.evaluations_per_instant = static_cast<double>(answers.evaluations) / count;
  if (answers.failed) row.errors.attitude_rad = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < times.size() && !answers.failed; ++i) {
    row.errors = greatest(row.errors, errors_of_row(subject.body, answers, i, truth[i]));
  }
  return row;
}

}  // namespace

std::vector<SpeedAccuracyRow> speed_accuracy(const Subject& subject, int instants, double most_evaluations,
                                             const Told& told) {
  std::vector<double> all;
  for (int i = 1; i <= instants; ++i) all.push_back(subject.span_s * i / instants);
  const rivals::QuadrupleReference reference(rivals::in_quadruple(subject.body), 0.0, subject.span_s);
  const double turn = turn_s(subject.body);

  std::vector<SpeedAccuracyRow> rows;
  for (const std::vector<double>& times : {all, std::vector<double>{subject.span_s}}) {
    std::vector<rivals::ScaledState<rivals::Quadruple>> truth;
    truth.reserve(times.size());
    for (const double t : times) truth.push_back(reference.at(t));
    for (const rivals::MeasuredMethod& method : rivals::measured_methods()) {
      if (told) told(method.name);
      if (method.make_controlled == nullptr) {
        rows.push_back(measured(subject, method, {}, times, truth));
        continue;
      }
      rivals::StepControl control{.max_evaluations = static_cast<std::int64_t>(most_evaluations)};
      (method.fixed_step() ? control.step_s : control.tolerance) =
          method.fixed_step() ? longest_step_turns * turn : loosest_tolerance;
      double best = std::numeric_limits<double>::infinity();
      int given_up = 0;
      for (int without_progress = 0; without_progress < 3;) {
        const SpeedAccuracyRow row = measured(subject, method, control, times, truth);
        const bool finite = std::isfinite(row.errors.attitude_rad);
        if (finite) rows.push_back(row);
        // Too coarse steps may fail or diverge, and angles end at pi: neither is an end of the progress.
        // A loose tolerance may let the momentum grow, and with it the cost, where a tighter one keeps both.
        const bool too_long = row.evaluations_per_instant * static_cast<double>(times.size()) > most_evaluations;
        if (too_long && (std::isfinite(best) || ++given_up > 3)) break;
        if (!finite && std::isfinite(best)) break;
        if (finite && row.errors.attitude_rad > 0.5 * best && best < 1e-3) ++without_progress;
        best = finite ? std::min(best, row.errors.attitude_rad) : best;
        if (method.fixed_step()) {
          control.step_s /= 2.0;
          if (subject.span_s / control.step_s > most_evaluations) break;
        } else {
          control.tolerance /= 10.0;
          if (control.tolerance < tightest_tolerance) break;
        }
      }
    }
  }
  return rows;
}

}  // namespace polhode::survey
