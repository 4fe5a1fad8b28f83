#include "polhode/motion/kicked_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/motion/splitting.hpp"
#include "polhode/motion/theta.hpp"

namespace polhode {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kFewestTurns = 1000.0;    // below, a plain method costs little
constexpr double kRampTurns = 30.0;        // over which the steps grow
constexpr double kWindowTurns = 100.0;     // of a trial, its ramp included
constexpr int kWindows = 3;                // over the span
constexpr double kLongestStep_rad = 1.2;   // a fifth of a turn: beyond 1.5 the second harmonic beats with the kicks
constexpr double kShortestStep_rad = 0.1;  // below, a method of higher order is cheaper
constexpr double kTrialStep_rad = 0.6;
constexpr double kSlowest_rad = 25.0;              // of rotation in r/v: then the surroundings change slowly
constexpr double kLeastSeparatrixDistance = 0.02;  // of G^2/(2 E I2) from 1
constexpr double kMostRateChange = 0.2;            // over the span, since the steps stay as long as they are
constexpr double kBoldness = 1.3;  // the drift at the start tends to be more than what it comes to in the end
constexpr int kMostAttempts = 3;   // at shorter steps
constexpr double kSafety = 1.25;   // of the drift between windows

/// Mean rate of rotation: of slow quantities only, so that steps do not follow the tumbling.
double mean_rate_rad_s(const Vector3& moments, const FreeState& state) {
  const double momentum = state.momentum_body.norm();
  return momentum > 0.0 ? state.momentum_body.dot(state.momentum_body.cwiseQuotient(moments)) / momentum : 0.0;
}

double separatrix_distance(const Vector3& moments, const FreeState& state) {
  const Vector3& m = state.momentum_body;
  return std::abs(m.squaredNorm() / (m.dot(m.cwiseQuotient(moments)) * moments[1]) - 1.0);
}

/// Share of the full step: from a twentieth to 1, with all derivatives, over the ramp.
double ramp(double turns) {
  const double x = turns / kRampTurns;
  if (!(x < 1.0)) return 1.0;
  const double grown = x > 0.0 ? 1.0 / (1.0 + std::exp(1.0 / x - 1.0 / (1.0 - x))) : 0.0;
  return 0.05 + 0.95 * grown;
}

}  // namespace

/// Makes runs, and counts what they cost.
class KickedMotion::Runner {
 public:
  Runner(const Vector3& moments, const Torques& torques) : moments_(moments), torques_(torques) {}

  /// One way from a state to end_s, with `take` after each step.
  template <class Take>
  void run(double start_s, const FreeState& start, double end_s, double step_rad, const Take& take) {
    SplittingRun run({moments_, start.q_inertial_from_body, start.momentum_body}, start_s, torques_,
                     splitting_scheme("strang"));
    // Steps that followed the rate would follow its swings too, and beat with the torque.
    const double rate = mean_rate_rad_s(moments_, start);
    for (bool last = end_s == start_s; !last;) {
      const double remaining_s = std::abs(end_s - run.t_s());
      const double length_s = ramp(std::abs(run.t_s() - start_s) * rate / kTurn_rad) * step_rad / rate;
      last = length_s >= remaining_s;
      run.step(std::copysign(last ? remaining_s : length_s, end_s - start_s));
      take(last ? end_s : run.t_s(), run.state());
    }
    evaluations += run.torque_evaluations();
  }

  struct Drift {
    double rate_rad_s = 0.0;  // between the run and the truth
    double swing_rad = 0.0;   // about that
  };

  /// What a run that begins here does beside an accurate one.
  Drift drift(double start_s, const FreeState& start, double direction, double step_rad) {
    const double turn_s = kTurn_rad / mean_rate_rad_s(moments_, start);
    const double end_s = start_s + direction * kWindowTurns * turn_s;
    SplittingRun exact({moments_, start.q_inertial_from_body, start.momentum_body}, start_s, torques_,
                       splitting_scheme("near-10-6-4"));
    std::vector<double> times_s;
    std::vector<Vector3> offsets;
    double next_s = start_s;
    run(start_s, start, end_s, step_rad, [&](double t_s, const FreeState& state) {
      if (direction * (t_s - next_s) < 0.0) return;
      next_s = t_s + direction * 0.35 * turn_s;
      exact.step(t_s - exact.t_s());
      if (direction * (t_s - start_s) < kRampTurns * turn_s) return;
      Quaternion away = state.q_inertial_from_body * exact.state().q_inertial_from_body.conjugate();
      if (away.w() < 0.0) away.coeffs() = -away.coeffs();
      times_s.push_back(t_s);
      offsets.push_back(2.0 * std::atan2(away.vec().norm(), away.w()) * away.vec().stableNormalized());
    });
    evaluations += exact.torque_evaluations();
    // A straight line through the offsets, by least squares.
    const auto count = static_cast<double>(times_s.size());
    double mean_s = 0.0, square = 0.0;
    Vector3 mean = Vector3::Zero(), product = Vector3::Zero();
    for (std::size_t i = 0; i < times_s.size(); ++i) mean_s += times_s[i] / count, mean += offsets[i] / count;
    for (std::size_t i = 0; i < times_s.size(); ++i) {
      square += (times_s[i] - mean_s) * (times_s[i] - mean_s);
      product += (times_s[i] - mean_s) * offsets[i];
    }
    const Vector3 slope = product / square;
    Drift result{slope.norm(), 0.0};
    for (std::size_t i = 0; i < times_s.size(); ++i) {
      result.swing_rad = std::max(result.swing_rad, (offsets[i] - slope * (times_s[i] - mean_s)).norm());
    }
    return result;
  }

  std::size_t evaluations = 0;

 private:
  const Vector3& moments_;
  const Torques& torques_;
};

namespace {

/// Whether the method is for this at all.
bool applies(const FreeBody& body, const Torques& torques, const KickedOptions& options) {
  const FreeState start{body.q_inertial_from_body, body.momentum_body};
  const double rate = mean_rate_rad_s(body.principal_moments, start);
  const double span_s = std::max(options.last_s, -options.first_s);
  if (!(rate * span_s >= kFewestTurns * kTurn_rad) || torques.empty()) return false;
  for (const double jump_s : torques.jumps_s()) {
    if (options.first_s < jump_s && jump_s < options.last_s) return false;
  }
  for (double t_s = options.first_s; t_s <= options.last_s;) {
    const double scale_s = torques.time_scale_s(t_s);
    if (!(scale_s * rate >= kSlowest_rad)) return false;
    t_s += std::isfinite(scale_s) ? std::max(0.1 * scale_s, 1e-4 * span_s) : span_s;
  }
  return separatrix_distance(body.principal_moments, start) >= kLeastSeparatrixDistance;
}

}  // namespace

std::optional<double> KickedMotion::chosen_step_rad(const FreeBody& body, const KickedOptions& options,
                                                    Runner& runner) {
  const double span_s = std::max(options.last_s, -options.first_s);
  const Runner::Drift drift = runner.drift(0.0, {body.q_inertial_from_body.normalized(), body.momentum_body},
                                           options.last_s >= -options.first_s ? 1.0 : -1.0, kTrialStep_rad);
  const double error_rad = drift.rate_rad_s * span_s + drift.swing_rad;
  const double step_rad = kTrialStep_rad * std::sqrt(kBoldness * options.tolerance_rad / error_rad);  // second order
  if (!(step_rad >= kShortestStep_rad)) return std::nullopt;
  return std::min(step_rad, kLongestStep_rad);
}

std::optional<double> KickedMotion::predicted_evaluations(const FreeBody& body, const Torques& torques,
                                                          const KickedOptions& options) {
  if (!applies(body, torques, options)) return std::nullopt;
  Runner runner(body.principal_moments, torques);
  const std::optional<double> step_rad = chosen_step_rad(body, options, runner);
  if (!step_rad) return std::nullopt;
  const double rate = mean_rate_rad_s(body.principal_moments, {body.q_inertial_from_body, body.momentum_body});
  return (options.last_s - options.first_s) * rate / *step_rad +
         (1.0 + kWindows) * static_cast<double>(runner.evaluations);
}

std::unique_ptr<const KickedMotion> KickedMotion::make(const FreeBody& body, const Torques& torques,
                                                       const KickedOptions& options) {
  if (!applies(body, torques, options)) return nullptr;
  Runner runner(body.principal_moments, torques);
  std::optional<double> step_rad = chosen_step_rad(body, options, runner);
  for (int attempt = 0; step_rad && attempt < kMostAttempts; ++attempt) {
    std::unique_ptr<KickedMotion> motion(new KickedMotion(body, options));  // NOLINT: the constructor is private
    if (!motion->run(body, *step_rad, runner)) return nullptr;
    if (motion->error_rad_ <= options.tolerance_rad) {
      motion->evaluations_ = runner.evaluations;
      return motion;
    }
    *step_rad *= 0.85 * std::sqrt(options.tolerance_rad / motion->error_rad_);
    if (!(*step_rad >= kShortestStep_rad)) return nullptr;
  }
  return nullptr;
}

bool KickedMotion::run(const FreeBody& body, double step_rad, Runner& runner) {
  const FreeState start{body.q_inertial_from_body.normalized(), body.momentum_body};
  const double rate = mean_rate_rad_s(moments_, start);
  nodes_.push_back({0.0, start});
  bool regular = true;
  for (const double end_s : {options_.first_s, options_.last_s}) {
    if (end_s == 0.0) continue;
    runner.run(0.0, start, end_s, step_rad, [&](double t_s, const FreeState& state) {
      nodes_.push_back({t_s, state});
      regular = regular && separatrix_distance(moments_, state) >= kLeastSeparatrixDistance &&
                std::abs(mean_rate_rad_s(moments_, state) / rate - 1.0) <= kMostRateChange;
    });
    if (!regular) return false;
    if (end_s < 0.0) std::reverse(nodes_.begin(), nodes_.end());
    // The drift, window by window, each for its part of the span.
    double drifted_rad = 0.0, swing_rad = 0.0;
    for (int i = 0; i < kWindows; ++i) {
      const Node& node = nodes_[nearest(end_s * i / kWindows)];
      const double window_s = kWindowTurns * kTurn_rad / mean_rate_rad_s(moments_, node.state);
      if (std::abs(end_s - node.t_s) < window_s) continue;
      const Runner::Drift drift = runner.drift(node.t_s, node.state, end_s > 0.0 ? 1.0 : -1.0, step_rad);
      drifted_rad += drift.rate_rad_s * std::abs(end_s) / kWindows;
      swing_rad = std::max(swing_rad, drift.swing_rad);
    }
    error_rad_ = std::max(error_rad_, kSafety * drifted_rad + swing_rad);
  }
  return true;
}

std::size_t KickedMotion::nearest(double t_s) const {
  const auto after =
      std::lower_bound(nodes_.begin(), nodes_.end(), t_s, [](const Node& n, double t) { return n.t_s < t; });
  const auto index = static_cast<std::size_t>(after - nodes_.begin());
  if (index == nodes_.size()) return index - 1;
  if (index > 0 && t_s - nodes_[index - 1].t_s < nodes_[index].t_s - t_s) return index - 1;
  return index;
}

FreeState KickedMotion::at(double t_high_s, double t_low_s) const {
  const double room_s = 1e-12 * (options_.last_s - options_.first_s);  // a last row that was rounded up
  if (!(t_high_s >= options_.first_s - room_s && t_high_s <= options_.last_s + room_s)) {
    throw InputError(fmt::format("the motion was propagated from {} s to {} s, it was asked for at {} s",
                                 options_.first_s, options_.last_s, t_high_s));
  }
  // Kicks stand half way between nodes: the nearest node is on the same free motion.
  const Node& node = nodes_[nearest(t_high_s)];
  const ThetaMotion free({moments_, node.state.q_inertial_from_body, node.state.momentum_body},
                         ThetaMotion::Span::step);
  return free.at(t_high_s - node.t_s, t_low_s);
}

}  // namespace polhode
