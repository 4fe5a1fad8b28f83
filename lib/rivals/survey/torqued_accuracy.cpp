#include "rivals/survey/torqued_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polhode/motion/torqued_motion.hpp"
#include "rivals/extrapolated_motion.hpp"
#include "rivals/torqued_methods.hpp"

namespace polhode::survey {

namespace {

constexpr double reference_tolerance_rad = 1e-14;
// Most runs' worth of torque evaluations to spend on the reference, and where that is less, some seconds' worth.
constexpr double runs_of_reference = 100.0, least_evaluations_of_reference = 1e7;
constexpr int loosest = 4, tightest = 32;  // tolerances, in half decades
constexpr double longest_torqued_step_turns = 1.0, longest_torqued_step_turns_without_kernel = 1.0 / 8.0;
constexpr double runs_of_torqued_motion = 10.0;  // to choose steps, to tell the error, in long double: at the most
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Instants and what is true there.
struct Examination {
  const TorquedSubject& subject;
  double most_evaluations;
  std::vector<double> times_s;
  std::vector<State> truth;
};

/// Time and errors of `answer(out)`, which fills the states.
template <class Answer>
TorquedRow measured(const Examination& e, std::string_view method, std::string_view kind, const Answer& answer) {
  TorquedRow row;
  row.method = method;
  row.kind = kind;
  row.instants = static_cast<int>(e.times_s.size());
  std::vector<double> q(4 * e.times_s.size()), m(3 * e.times_s.size());
  row.time_ns = least_time_ns([&] { answer(StateArrays::of_structures(q.data(), m.data()), row); });
  for (std::size_t i = 0; i < e.times_s.size(); ++i) {
    const Quaternion attitude = from_scalar_first({q[4 * i], q[4 * i + 1], q[4 * i + 2], q[4 * i + 3]});
    const Vector3 momentum(m[3 * i], m[3 * i + 1], m[3 * i + 2]), &exact = e.truth[i].momentum_body;
    const double angle = rotation_angle_rad(attitude, e.truth[i].q_inertial_from_body);
    const double change = (momentum - exact).norm() / exact.norm();
    row.attitude_rad = greatest(row.attitude_rad, angle);
    row.momentum = greatest(row.momentum, change);
  }
  return row;
}

/// TorquedMotion at one tolerance; NaN where it stopped.
TorquedRow measured(const Examination& e, std::string_view method, double tolerance) {
  TorquedRow row = measured(e, method, "to an accuracy", [&](const StateArrays& out, TorquedRow& r) {
    const double last_s = e.times_s.back();
    const TorquedMotion motion(
        e.subject.body, e.subject.torques,
        {.tolerance_rad = tolerance,
         .first_s = std::min(0.0, last_s),
         .last_s = std::max(0.0, last_s),
         .method = method,
         .max_torque_evaluations = static_cast<std::size_t>(runs_of_torqued_motion * e.most_evaluations)});
    r.evaluations = static_cast<double>(motion.torque_evaluations());
    r.kept_evaluations = static_cast<double>(motion.kept_torque_evaluations());
    if (motion.outcome() == Outcome::stopped) {
      for (std::size_t i = 0; i < e.times_s.size(); ++i) {
        out.q[0][static_cast<std::ptrdiff_t>(i) * out.q_stride] = std::numeric_limits<double>::quiet_NaN();
      }
      return;
    }
    motion.batch({e.times_s}, out);
  });
  row.tolerance = tolerance;
  return row;
}

TorquedRow measured(const Examination& e, const rivals::TorquedMethod& method, const rivals::StepControl& control) {
  TorquedRow row = measured(e, method.name, method.kind, [&](const StateArrays& out, TorquedRow& r) {
    const rivals::IntegratedMotion motion(e.subject.body, e.subject.torques, control, method.run, method.scheme);
    r.evaluations = r.kept_evaluations = static_cast<double>(motion.integrate({e.times_s}, out));
  });
  row.step_s = control.step_s;
  row.free_step_s = control.free_step_s;
  row.tolerance = control.tolerance;
  return row;
}

/// Collects the rows of one method from coarse to fine; false once rounding, or the limit, has ended the progress.
class Progress {
 public:
  Progress(double most_evaluations, std::vector<TorquedRow>& rows) : most_evaluations_(most_evaluations), rows_(rows) {}

  bool take(const TorquedRow& row) {
    // Too coarse steps may fail, diverge or cost more than fine ones: none is an end of the progress.
    const bool finite = std::isfinite(row.attitude_rad);
    if (finite) rows_.push_back(row);
    if (std::isfinite(best_) && (!finite || row.evaluations > most_evaluations_)) return false;
    // Where something else shortens the steps, several tolerances take the same ones.
    if (finite && row.evaluations != last_evaluations_) {
      without_progress_ = row.attitude_rad < 0.8 * best_ || best_ > 1e-3 ? 0 : without_progress_ + 1;
    }
    if (finite) best_ = std::min(best_, row.attitude_rad);
    last_evaluations_ = row.evaluations;
    return without_progress_ < most_without_progress;
  }

 private:
  static constexpr int most_without_progress = 6;  // errors of either sign cancel in passing

  double most_evaluations_;
  std::vector<TorquedRow>& rows_;
  double best_ = infinity, last_evaluations_ = 0.0;
  int without_progress_ = 0;
};

/// Steps, each with the free step that is just short enough.
void sweep_steps(const Examination& e, const rivals::TorquedMethod& method, double longest_s,
                 std::vector<TorquedRow>& rows) {
  Progress progress(e.most_evaluations, rows);
  const double span_s = std::abs(e.subject.span_s);
  double free_step_s = longest_s;
  for (int halvings = 0;; ++halvings) {  // of the square of the step
    const double step_s = longest_s * std::pow(0.5, 0.5 * halvings);
    if (span_s / step_s > e.most_evaluations) return;
    rivals::StepControl control{.step_s = step_s, .max_evaluations = static_cast<std::int64_t>(e.most_evaluations)};
    if (!method.fixed_free_step) {
      if (!progress.take(measured(e, method, control))) return;
      continue;
    }
    TorquedRow best;
    best.attitude_rad = infinity;
    const double first_s = std::min(4.0 * free_step_s, step_s);
    bool exhausted = false;
    for (int n = 0; !exhausted; ++n) {
      const double s = std::ldexp(first_s, -n);
      control.free_step_s = s;
      const TorquedRow row = measured(e, method, control);
      const double before = best.attitude_rad;
      const bool better = row.attitude_rad < 0.8 * before;
      if (better) best = row, free_step_s = s;
      if (std::isfinite(before) && !better) break;
      exhausted = span_s / s > 2.5 * e.most_evaluations;
    }
    // Where the free motion is what limits, finer kicks change nothing.
    if (!progress.take(best) || exhausted) return;
  }
}

}  // namespace

TorquedAccuracy torqued_accuracy(const TorquedSubject& subject, int instants, double most_evaluations,
                                 const Told& told) {
  TorquedAccuracy result;
  if (told) told("reference");
  const double most_of_reference = std::max(runs_of_reference * most_evaluations, least_evaluations_of_reference);
  const rivals::ExtrapolatedMotion reference(subject.body, subject.torques,
                                             {.tolerance_rad = reference_tolerance_rad,
                                              .first_s = std::min(0.0, subject.span_s),
                                              .last_s = std::max(0.0, subject.span_s),
                                              .most_evaluations = static_cast<std::size_t>(most_of_reference)});
  const Outcome outcome = !reference.whole()                                 ? Outcome::stopped
                          : reference.error_rad() <= reference_tolerance_rad ? Outcome::done
                                                                             : Outcome::tolerance_not_reachable;
  result.reference = {reference_tolerance_rad, reference.error_rad(), outcome_name(outcome), reference.evaluations()};
  if (outcome == Outcome::stopped) return result;

  std::vector<double> all;
  for (int i = 1; i <= instants; ++i) all.push_back(subject.span_s * i / instants);
  for (const std::vector<double>& times : {all, std::vector<double>{subject.span_s}}) {
    Examination e{subject, most_evaluations, times, {}};
    for (const double t : times) e.truth.push_back(reference.at(t));
    // Between two instants there is a step at least.
    const double longest_s =
        std::min(turn_s(subject.body), std::abs(subject.span_s) / static_cast<double>(times.size()));
    for (const std::string_view method : torqued_motion_methods()) {
      if (told) told(method);
      Progress progress(runs_of_torqued_motion * most_evaluations, result.rows);
      for (int n = loosest; n <= tightest; ++n) {
        if (!progress.take(measured(e, method, std::pow(10.0, -0.5 * n)))) break;
      }
    }
    for (const rivals::TorquedMethod& method : rivals::torqued_methods()) {
      if (told) told(method.name);
      if (method.fixed_step) {
        const double turns =
            method.scheme == nullptr ? longest_torqued_step_turns_without_kernel : longest_torqued_step_turns;
        sweep_steps(e, method, std::min(longest_s, turns * turn_s(subject.body)), result.rows);
        continue;
      }
      Progress progress(most_evaluations, result.rows);
      for (int n = loosest; n <= tightest; ++n) {
        const rivals::StepControl control{.tolerance = std::pow(10.0, -0.5 * n),
                                          .max_evaluations = static_cast<std::int64_t>(most_evaluations)};
        if (!progress.take(measured(e, method, control))) break;
      }
    }
  }
  return result;
}

}  // namespace polhode::survey
