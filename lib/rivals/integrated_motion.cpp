#include "rivals/integrated_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"

namespace polhode::rivals {

IntegratedMotion::IntegratedMotion(const FreeBody& body, const StepControl& control, Run run) : run_(run) {
  checked(body);
  const auto wanted = [](std::string_view what, double value) {  // 0 leaves it to the method
    if (!(value >= 0.0 && std::isfinite(value))) {
      throw InputError(fmt::format("{} is {}, a positive number is wanted, or 0 for the usual", what, value));
    }
  };
  wanted("the step", control.step_s);
  wanted("the tolerance", control.tolerance);
  wanted("the step of the free motion", control.free_step_s);
  wanted("the limit of evaluations", static_cast<double>(control.max_evaluations));
  momentum_ = body.momentum_body.stableNorm();
  time_unit_ = body.principal_moments[1] / momentum_;
  const Eigen::Vector4d q = scalar_first(body.q_inertial_from_body).stableNormalized();
  for (int i = 0; i < 4; ++i) problem_.start.q[i] = q[i];
  double rate = 0.0;
  for (int i = 0; i < 3; ++i) {
    problem_.body.x[i] = body.principal_moments[1] / body.principal_moments[i];
    problem_.start.m[i] = momentum_ > 0.0 ? body.momentum_body[i] / momentum_ : 0.0;
    rate = std::hypot(rate, problem_.body.x[i] * problem_.start.m[i]);
  }
  problem_.step = control.step_s > 0.0 ? control.step_s / time_unit_ : 2.0 * EIGEN_PI / (kDefaultStepsPerTurn * rate);
  problem_.tolerance = control.tolerance > 0.0 ? control.tolerance : kDefaultTolerance;
  problem_.max_evaluations =
      control.max_evaluations > 0 ? control.max_evaluations : std::numeric_limits<std::int64_t>::max();
}

IntegratedMotion::IntegratedMotion(const FreeBody& body, const Torques& torques, const StepControl& control, Run run,
                                   const SplittingScheme* scheme)
    : IntegratedMotion(body, control, run) {
  const double free_step = control.free_step_s > 0.0 ? control.free_step_s / time_unit_ : HUGE_VAL;
  forcing_ = Forcing{torques.in_principal_axes(body.named_from_principal),
                     body.principal_moments,
                     momentum_,
                     time_unit_,
                     0.0,
                     scheme,
                     free_step};
}

State IntegratedMotion::at(double t_high_s, double t_low_s) const {
  Eigen::Vector4d q;
  State state;
  integrate({{&t_high_s, 1}, {&t_low_s, 1}}, StateArrays::of_structures(q.data(), state.momentum_body.data()));
  state.q_inertial_from_body = from_scalar_first(q);
  return state;
}

std::int64_t IntegratedMotion::integrate(const TimeArrays& times, const StateArrays& out) const {
  check_lengths(times);
  const std::size_t count = times.high.size();
  std::vector<std::pair<double, std::size_t>> rows;  // of the times that are finite
  std::vector<std::size_t> unanswered;               // the others
  rows.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double t = times.high[i] + (times.low.empty() ? 0.0 : times.low[i]);
    if (std::isfinite(t)) {
      rows.emplace_back(t / time_unit_, i);
    } else {
      unanswered.push_back(i);
    }
  }
  if (!std::is_sorted(rows.begin(), rows.end())) std::sort(rows.begin(), rows.end());
  std::vector<double> tau;
  std::vector<std::size_t> order;
  tau.reserve(count), order.reserve(count);
  for (const auto& [time, row] : rows) tau.push_back(time), order.push_back(row);
  const auto past = static_cast<std::size_t>(std::lower_bound(tau.begin(), tau.end(), 0.0) - tau.begin());
  std::reverse(tau.begin(), tau.begin() + static_cast<std::ptrdiff_t>(past));
  std::reverse(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(past));

  const std::size_t finite = order.size();
  order.insert(order.end(), unanswered.begin(), unanswered.end());

  std::vector<ScaledState<double>> states(count, problem_.start);
  std::int64_t evaluations = 0;
  const std::span<const double> all(tau);
  if (momentum_ > 0.0) {
    if (past > 0) evaluations += advance(all.first(past), states.data());
    if (past < finite) evaluations += advance(all.subspan(past), states.data() + past);
  } else if (forcing_) {
    no_answer(states.data(), 0, count);
  }
  no_answer(states.data(), finite, count);
  for (std::size_t n = 0; n < count; ++n) {
    const auto row = static_cast<std::ptrdiff_t>(order[n]);
    for (int k = 0; k < 4; ++k) out.q[k][row * out.q_stride] = states[n].q[k];
    if (out.m[0] == nullptr) continue;
    for (int k = 0; k < 3; ++k) out.m[k][row * out.m_stride] = states[n].m[k] * momentum_;
  }
  return evaluations;
}

std::int64_t IntegratedMotion::advance(std::span<const double> times, ScaledState<double>* out) const {
  if (!forcing_) return run_(problem_, times, out);
  // From jump to jump of the torques: each stretch is a problem of its own.
  const double direction = times.back() < 0.0 ? -1.0 : 1.0;
  std::vector<double> ends;
  for (const double jump_s : forcing_->torques.jumps_s()) {
    const double jump = jump_s / time_unit_;
    if (direction * jump > 0.0 && direction * (times.back() - jump) > 0.0) ends.push_back(jump);
  }
  if (direction < 0.0) std::reverse(ends.begin(), ends.end());
  ends.push_back(times.back());
  Forcing forcing = *forcing_;
  Problem problem = problem_;
  problem.forcing = &forcing;
  std::int64_t evaluations = 0;
  double from = 0.0;
  std::size_t done = 0;
  std::vector<double> stretch;
  std::vector<ScaledState<double>> states;
  for (const double to : ends) {
    stretch.clear();
    for (std::size_t i = done; i < times.size() && direction * (times[i] - to) <= 0.0; ++i) {
      stretch.push_back(times[i] - from);
    }
    const std::size_t rows = stretch.size();
    if (rows == 0 || times[done + rows - 1] != to) stretch.push_back(to - from);
    states.resize(stretch.size());
    forcing.start_s = from * time_unit_;
    forcing.torques = forcing_->torques.during(0.5 * (from + to) * time_unit_);
    evaluations += run_(problem, stretch, states.data());
    std::copy_n(states.begin(), rows, out + done);
    done += rows;
    problem.start = states.back();
    problem.max_evaluations = problem_.max_evaluations - evaluations;
    from = to;
    if (!is_finite(problem.start)) break;
  }
  no_answer(out, done, times.size());
  return evaluations;
}

}  // namespace polhode::rivals
