#include "polhode/motion/kicked_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/motion/splitting.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/motion/torqued_motion.hpp"

namespace polhode {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kFewestTurns = 1000.0;  // below, a plain method costs little
constexpr double kRampTurns = 30.0;      // over which the steps grow
constexpr double kWindowTurns = 100.0;   // of the trial, its ramp included
constexpr double kTrialStep_rad = 0.6;
constexpr double kBoldness = 2.0;          // the drift at the start tends to be more than what it comes to in the end
constexpr double kCoarser = 1.6;           // step of the run to compare with
constexpr double kLongestStep_rad = 0.92;  // the coarser ones below 1.5, where the second harmonic beats with the kicks
constexpr double kShortestStep_rad = 0.1;  // below, a method of higher order is cheaper
constexpr int kMostGridRefinements = 3;
constexpr double kSlowest_rad = 25.0;              // of rotation in r/v: then the surroundings change slowly
constexpr double kLeastSeparatrixDistance = 0.02;  // of G^2/(2 E I2) from 1
constexpr double kMostRateChange = 0.2;            // over the span, since the steps stay as long as they are

/// Mean rate of rotation: of slow quantities only, so that steps do not follow the tumbling.
double mean_rate_rad_s(const Vector3& moments, const State& state) {
  const double momentum = state.momentum_body.norm();
  return momentum > 0.0 ? state.momentum_body.dot(state.momentum_body.cwiseQuotient(moments)) / momentum : 0.0;
}

double separatrix_distance(const Vector3& moments, const State& state) {
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
  Runner(const FreeBody& body, const Torques& torques)
      : moments_(body.principal_moments), torques_(torques.in_principal_axes(body.named_from_principal)) {}

  /// One way from t = 0 to end_s, with `take` after each step.
  template <class Take>
  void run(const State& start, double end_s, double step_rad, const Take& take) {
    SplittingRun run({moments_, start.q_inertial_from_body, start.momentum_body}, 0.0, torques_, kStrang);
    // Steps that followed the rate would follow its swings too, and beat with the torque.
    const double rate = mean_rate_rad_s(moments_, start);
    for (bool last = end_s == 0.0; !last;) {
      const double remaining_s = std::abs(end_s - run.t_s());
      const double length_s = ramp(std::abs(run.t_s()) * rate / kTurn_rad) * step_rad / rate;
      last = length_s >= remaining_s;
      run.step(std::copysign(last ? remaining_s : length_s, end_s));
      take(last ? end_s : run.t_s(), run.state());
    }
    evaluations += run.torque_evaluations();
  }

  /// How fast a run from here departs from an accurate one, rad/s.
  double drift_rad_s(const State& start, double direction, double step_rad) {
    const double turn_s = kTurn_rad / mean_rate_rad_s(moments_, start);
    SplittingRun exact({moments_, start.q_inertial_from_body, start.momentum_body}, 0.0, torques_, kNear1064);
    std::vector<double> times_s;
    std::vector<Vector3> offsets;
    double next_s = 0.0;
    run(start, direction * kWindowTurns * turn_s, step_rad, [&](double t_s, const State& state) {
      if (direction * (t_s - next_s) < 0.0) return;
      next_s = t_s + direction * 0.35 * turn_s;
      exact.step(t_s - exact.t_s());
      if (std::abs(t_s) < kRampTurns * turn_s) return;
      Quaternion away = state.q_inertial_from_body * exact.state().q_inertial_from_body.conjugate();
      if (away.w() < 0.0) away.coeffs() = -away.coeffs();
      times_s.push_back(t_s);
      offsets.push_back(2.0 * std::atan2(away.vec().norm(), away.w()) * away.vec().stableNormalized());
    });
    evaluations += exact.torque_evaluations();
    // A straight line through the offsets, by least squares: its slope does not feel the swings.
    const auto count = static_cast<double>(times_s.size());
    double mean_s = 0.0, square = 0.0;
    Vector3 product = Vector3::Zero();
    for (const double t_s : times_s) mean_s += t_s / count;
    for (std::size_t i = 0; i < times_s.size(); ++i) {
      square += (times_s[i] - mean_s) * (times_s[i] - mean_s);
      product += (times_s[i] - mean_s) * offsets[i];
    }
    return product.norm() / square;
  }

  std::size_t evaluations = 0;

 private:
  const Vector3 moments_;
  const Torques torques_;
};

namespace {

/// Whether the method is for this at all.
bool applies(const FreeBody& body, const Torques& torques, const KickedOptions& options) {
  checked(body);
  check_span(options.first_s, options.last_s);
  if (!(options.tolerance_rad > 0.0 && std::isfinite(options.tolerance_rad))) {
    throw InputError(fmt::format("the tolerance is {}, a positive angle in radians is wanted", options.tolerance_rad));
  }
  const State start{body.q_inertial_from_body, body.momentum_body};
  const double rate = mean_rate_rad_s(body.principal_moments, start);
  const double span_s = std::max(options.last_s, -options.first_s);
  if (!(rate * span_s >= kFewestTurns * kTurn_rad) || torques.empty()) return false;
  for (const double jump_s : torques.jumps_s()) {
    if (options.first_s < jump_s && jump_s < options.last_s) return false;
  }
  // An eclipse, and a function that may depend on the rate, would leave it of the first order.
  if (!torques.times_of_kinks_s(options.first_s, options.last_s).empty()) return false;
  for (const Torque& torque : torques.list()) {
    if (std::holds_alternative<OwnTorque>(torque)) return false;
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
  const double drift_rad_s = runner.drift_rad_s({body.q_inertial_from_body.normalized(), body.momentum_body},
                                                options.last_s >= -options.first_s ? 1.0 : -1.0, kTrialStep_rad);
  // Second order; the drift varies over the span, and what it comes to is measured afterwards.
  const double step_rad = kTrialStep_rad * std::sqrt(kBoldness * options.tolerance_rad / (drift_rad_s * span_s));
  if (!(step_rad >= kShortestStep_rad)) return std::nullopt;
  return std::min(step_rad, kLongestStep_rad);
}

std::optional<double> KickedMotion::predicted_evaluations(const FreeBody& body, const Torques& torques,
                                                          const KickedOptions& options) {
  if (!applies(body, torques, options)) return std::nullopt;
  Runner runner(body, torques);
  const std::optional<double> step_rad = chosen_step_rad(body, options, runner);
  if (!step_rad) return std::nullopt;
  const double rate = mean_rate_rad_s(body.principal_moments, {body.q_inertial_from_body, body.momentum_body});
  return (options.last_s - options.first_s) * rate / *step_rad * (1.0 + 1.0 / kCoarser) +
         2.0 * static_cast<double>(runner.evaluations);
}

std::unique_ptr<const KickedMotion> KickedMotion::make(const FreeBody& body, const Torques& torques,
                                                       const KickedOptions& options, std::size_t* in_vain) {
  if (!applies(body, torques, options)) return nullptr;
  Runner runner(body, torques);
  std::unique_ptr<const KickedMotion> motion = make(body, options, runner);
  if (!motion && in_vain != nullptr) *in_vain += runner.evaluations;
  return motion;
}

std::unique_ptr<const KickedMotion> KickedMotion::make(const FreeBody& body, const KickedOptions& options,
                                                       Runner& runner) {
  const std::optional<double> step_rad = chosen_step_rad(body, options, runner);
  if (!step_rad) return nullptr;
  const double rate = mean_rate_rad_s(body.principal_moments, {body.q_inertial_from_body, body.momentum_body});
  const double phase_rad = (options.last_s - options.first_s) * rate;
  const auto made = [&](double step) {
    std::unique_ptr<KickedMotion> motion;
    if (static_cast<double>(runner.evaluations) + phase_rad / step >
        static_cast<double>(options.max_torque_evaluations)) {
      return motion;
    }
    motion.reset(new KickedMotion(body, options));  // NOLINT: the constructor is private
    if (!motion->run(body, step, runner)) motion.reset();
    return motion;
  };
  double step = kCoarser * *step_rad;
  std::unique_ptr<KickedMotion> coarse = made(step);
  for (int refinement = 0; coarse && refinement < kMostGridRefinements; ++refinement) {
    step /= kCoarser;
    if (!(step >= kShortestStep_rad)) break;
    std::unique_ptr<KickedMotion> fine = made(step);
    if (!fine) break;
    // The error of the finer run is 0.6 of the difference where it is of second order.
    for (const Node& node : coarse->nodes_) {
      fine->error_rad_ = std::max(fine->error_rad_, rotation_angle_rad(node.state.q_inertial_from_body,
                                                                       fine->at(node.t_s).q_inertial_from_body));
    }
    if (fine->error_rad_ <= options.tolerance_rad) {
      fine->evaluations_ = runner.evaluations;
      return fine;
    }
    coarse = std::move(fine);
  }
  return nullptr;
}

bool KickedMotion::run(const FreeBody& body, double step_rad, Runner& runner) {
  const State start{body.q_inertial_from_body.normalized(), body.momentum_body};
  const double rate = mean_rate_rad_s(moments_, start);
  nodes_.push_back({0.0, start});
  bool regular = true;
  for (const double end_s : {options_.first_s, options_.last_s}) {
    runner.run(start, end_s, step_rad, [&](double t_s, const State& state) {
      nodes_.push_back({t_s, state});
      regular = regular && separatrix_distance(moments_, state) >= kLeastSeparatrixDistance &&
                std::abs(mean_rate_rad_s(moments_, state) / rate - 1.0) <= kMostRateChange;
    });
    if (!regular) return false;
    if (end_s < 0.0) std::reverse(nodes_.begin(), nodes_.end());
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

MotionAccount KickedMotion::account() const {
  return {"splitting, few kicks per turn", options_.tolerance_rad,
          fmt::format("two runs agree to {:.1e} rad; the numbers of the body and its torques are taken as exact",
                      error_rad_),
          evaluations_};
}

State KickedMotion::at(double t_high_s, double t_low_s) const {
  if (std::isnan(t_high_s + t_low_s)) return nan_state();
  check_within(t_high_s, options_.first_s, options_.last_s);
  // Kicks stand half way between nodes: the nearest node is on the same free motion.
  const Node& node = nodes_[nearest(t_high_s)];
  const ThetaMotion free(ThetaMotion::Unchecked{},
                         {moments_, node.state.q_inertial_from_body, node.state.momentum_body},
                         ThetaMotion::Span::step);
  return free.at(t_high_s - node.t_s, t_low_s);
}

}  // namespace polhode
