#include "polhode/motion/torqued_motion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "polhode/base/error.hpp"
#include "polhode/body/inertia.hpp"

namespace polhode {
namespace {

constexpr std::string_view kSeries = "series";
constexpr std::string_view kExtrapolationInDouble = "extrapolation-double";
constexpr std::string_view kExtrapolation = "extrapolation";
constexpr std::string_view kAuto = "auto";
constexpr double kLongestTurn_rad = 6.0;  // of one step: about what the kernel and the error estimate are made for
constexpr double kSafety = 5.0;           // two runs that differ by rounding tell its size no better
constexpr int kMostRefinements = 8;
constexpr double kTimeScaleShare = 0.7;  // of a step in r/v: an encounter is never stepped over
// By which one of two runs starts aside, where digits are doubles.
constexpr double kAside = 2e-16;
// Of extrapolation: its estimates are of the order below, and far too large. What halved steps gain is claimed in long
// double only, where it is not rounding that keeps two runs apart.
constexpr double kLooserExtrapolation = 1e2, kLooserExtrapolationInDouble = 100.0;
constexpr double kGainOfExtrapolation = 10.0, kGainOfExtrapolationInDouble = 2.0;
constexpr double kClaimWithKinks = 4.0;   // of the difference of two runs; errors of 1.6 of it were seen
constexpr double kAsymptotic_rad = 1e-2;  // runs that differ by more say nothing of each other

ExtendedState extended(const State& state) {
  return {state.q_inertial_from_body.cast<long double>(), state.momentum_body.cast<long double>()};
}

/// A momentum that damping has made less than a FreeBody may have is none.
State plain(const ExtendedState& state) {
  State rounded{state.q_inertial_from_body.cast<double>(), state.momentum_body.cast<double>()};
  if (rounded.momentum_body.stableNorm() < kLeastMagnitude) rounded.momentum_body.setZero();
  return rounded;
}

bool is_finite(const State& state) {
  return state.q_inertial_from_body.coeffs().allFinite() && state.momentum_body.allFinite();
}

/// Angle between two attitudes to the digits of long double.
double angle_rad(const ExtendedState& a, const ExtendedState& b) {
  const auto difference = a.q_inertial_from_body.conjugate() * b.q_inertial_from_body;
  return static_cast<double>(2.0L * std::atan2(difference.vec().norm(), std::abs(difference.w())));
}

/// What rounding in doubles adds up to, at the least: a random walk in the energy, one rounding per kick, that turns
/// into phase.
double rounding_rad(double phase_rad, double kicks) { return 1e-16 * std::sqrt(kicks) * (1.0 + phase_rad); }

}  // namespace

double rounding_of_doubles_rad(double phase_rad) { return rounding_rad(phase_rad, phase_rad); }

std::string_view outcome_name(Outcome outcome) {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::stopped:
      return "stopped";
    default:
      return "tolerance not reachable";
  }
}

std::span<const std::string_view> torqued_motion_methods() {
  static constexpr std::string_view all[] = {kAuto, kSeries, kExtrapolationInDouble, kExtrapolation};
  return all;
}

/// Makes paths; what they share while they are made.
class TorquedMotion::Builder {
 public:
  /// Of the evaluations that the options allow, `spent` are gone.
  Builder(const FreeBody& body, const Torques& torques, const TorquedOptions& options, std::string_view method,
          std::size_t spent)
      : most_evaluations_(options.max_torque_evaluations - std::min(spent, options.max_torque_evaluations)),
        way_(way(method, options)),
        moments_(body.principal_moments) {
    start_ = {body.q_inertial_from_body.cast<long double>().normalized(), body.momentum_body.cast<long double>()};
    for (const bool forward : {true, false}) {
      const double end_s = forward ? options.last_s : options.first_s;
      std::vector<double> ends;
      for (const double jump_s : torques.jumps_s()) {
        if (jump_s != 0.0 && (jump_s > 0.0) == forward && std::abs(jump_s) < std::abs(end_s)) ends.push_back(jump_s);
      }
      ends.push_back(end_s);
      std::sort(ends.begin(), ends.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
      double from_s = 0.0;
      for (const double to_s : ends) {
        (forward ? forward_ : backward_).push_back({torques.during(0.5 * (from_s + to_s)), {{from_s, {}}, {to_s, {}}}});
        from_s = to_s;
      }
    }
  }

  static Way way(std::string_view name, const TorquedOptions& options) {
    if (options.splitting != nullptr) return {.scheme = options.splitting};
    if (name == kExtrapolation) return {.extended = true};
    if (name == kExtrapolationInDouble) return {};
    throw InputError(fmt::format("unknown method '{:.40}' under torques, allowed are {}", name,
                                 fmt::join(torqued_motion_methods(), ", ")));
  }

  template <class Real>
  static ExtendedState extrapolated(const Vector3& moments, const Torques& torques, const Node& from, double length_s,
                                    std::size_t parts, std::size_t& evaluations, double* local_error) {
    Extrapolation<Real> method(moments, torques);
    ExtendedState state = from.state;
    const long double part_s = static_cast<long double>(length_s) / parts;
    for (std::size_t i = 0; i < parts; ++i) {
      const auto step = method.step(from.t_s + i * part_s, state, part_s);
      state = step.state;
      if (local_error != nullptr) *local_error = step.error;
    }
    evaluations += method.torque_evaluations();
    return state;
  }

  /// One state from a splitting method or from extrapolation.
  static ExtendedState stepped(const Way& way, const Vector3& moments, const Torques& torques, const Node& from,
                               double length_s, std::size_t parts, std::size_t& evaluations, double* local_error) {
    if (way.scheme == nullptr) {
      return (way.extended ? extrapolated<long double> : extrapolated<double>)(moments, torques, from, length_s, parts,
                                                                               evaluations, local_error);
    }
    const State start = plain(from.state);
    if (!is_finite(start)) return from.state;
    SplittingRun run({moments, start.q_inertial_from_body, start.momentum_body}, from.t_s, torques, *way.scheme);
    for (std::size_t i = 0; i < parts; ++i) run.step(length_s / static_cast<double>(parts));
    evaluations += run.torque_evaluations();
    return extended(run.state());
  }

  /// Paths whose steps were chosen for this local tolerance. False if the limit of evaluations ended it, or the method
  /// is of no use here.
  bool first_paths(double tolerance_rad, Path& forward, Path& backward) {
    tolerance_rad_ = tolerance_rad;
    aside_ = !aside_;
    forward = forward_, backward = backward_;
    if (choose_steps(forward)) return choose_steps(backward);
    end_in(backward, 0);  // the start alone
    backward.front().nodes.assign(1, {0.0, start_});
    return false;
  }

  /// The same paths, finer; false as above.
  bool finer_paths(const Path& forward, const Path& backward, Path& finer_forward, Path& finer_backward) {
    return halve(forward, finer_forward) && halve(backward, finer_backward);
  }

  /// Largest angle between a path and the finer one, at the ends of the steps of the coarse one; NaN if one is.
  double difference_rad(const Path& coarse, const Path& fine) const {
    double worst = 0.0;
    const auto compare = [&worst](const ExtendedState& a, const ExtendedState& b) {
      const double angle = angle_rad(a, b);
      if (!(angle <= worst) && !std::isnan(worst)) worst = angle;
    };
    for (std::size_t l = 0; l < coarse.size(); ++l) {
      for (std::size_t i = 0; i < coarse[l].nodes.size(); ++i) {
        compare(coarse[l].nodes[i].state, fine[l].nodes[2 * i].state);
      }
    }
    return worst;
  }

  double rounding_rad(const Path& path) const {
    double phase_rad = 0.0;
    std::size_t steps = 0;
    for (const Leg& leg : path) {
      for (std::size_t i = 1; i < leg.nodes.size(); ++i) {
        const Vector3 omega = leg.nodes[i].state.momentum_body.cast<double>().cwiseQuotient(moments_);
        phase_rad += omega.norm() * std::abs(leg.nodes[i].t_s - leg.nodes[i - 1].t_s);
      }
      steps += leg.nodes.size();
    }
    const double kicks = way_.scheme == nullptr ? 1.0 : static_cast<double>(way_.scheme->kicks);
    return polhode::rounding_rad(phase_rad, kicks * static_cast<double>(steps));
  }

  std::size_t evaluations() const { return evaluations_; }

 private:
  /// The start but for a rounding: what grows from it shows in the difference of two runs.
  ExtendedState start_aside() const {
    ExtendedState state = start_;
    state.momentum_body = state.momentum_body.cwiseProduct(Vector3Of<long double>(1 + kAside, 1 - kAside, 1 + kAside));
    const Eigen::Quaternion<long double> turn(1.0L, kAside, -kAside, kAside);
    state.q_inertial_from_body = state.q_inertial_from_body * turn;
    return state;
  }

  /// Ends the path within its leg l; false.
  static bool end_in(Path& path, std::size_t l) {
    path.erase(path.begin() + static_cast<std::ptrdiff_t>(l) + 1, path.end());
    return false;
  }

  /// The same path with every step in two; false as above.
  bool halve(const Path& coarse, Path& fine) {
    fine = coarse;
    ExtendedState state = start_;
    for (std::size_t l = 0; l < coarse.size(); ++l) {
      const std::vector<Node>& nodes = coarse[l].nodes;
      fine[l].nodes.assign(1, {nodes[0].t_s, state});
      if (way_.scheme != nullptr) {
        const State start = plain(state);
        if (!is_finite(start)) return false;
        SplittingRun run({moments_, start.q_inertial_from_body, start.momentum_body}, nodes[0].t_s, fine[l].torques,
                         *way_.scheme);
        for (std::size_t i = 1; i < nodes.size(); ++i) {
          const double middle_s = 0.5 * (nodes[i - 1].t_s + nodes[i].t_s);
          for (const double to_s : {middle_s, nodes[i].t_s}) {
            run.step(to_s - run.t_s());
            fine[l].nodes.push_back({to_s, extended(run.state())});
          }
          if (evaluations_ + run.torque_evaluations() > most_evaluations_) {
            evaluations_ += run.torque_evaluations();
            return false;
          }
        }
        evaluations_ += run.torque_evaluations();
      } else {
        for (std::size_t i = 1; i < nodes.size(); ++i) {
          const double middle_s = 0.5 * (nodes[i - 1].t_s + nodes[i].t_s);
          for (const double to_s : {middle_s, nodes[i].t_s}) {
            const Node from = fine[l].nodes.back();
            fine[l].nodes.push_back(
                {to_s, stepped(way_, moments_, fine[l].torques, from, to_s - from.t_s, 1, evaluations_, nullptr)});
          }
          if (evaluations_ > most_evaluations_) return false;
        }
      }
      state = fine[l].nodes.back().state;
    }
    return true;
  }

  bool choose_steps(Path& path) {
    ExtendedState state = way_.scheme == nullptr && !way_.extended ? start_aside() : start_;
    const double end_s = path.back().nodes.back().t_s;
    for (std::size_t l = 0; l < path.size(); ++l) {
      Leg& leg = path[l];
      const double leg_end_s = leg.nodes.back().t_s;
      leg.nodes.assign(1, {leg.nodes[0].t_s, state});
      double wanted_s = std::abs(leg_end_s - leg.nodes[0].t_s);
      while (leg.nodes.back().t_s != leg_end_s) {
        const Node from = leg.nodes.back();
        const double remaining_s = std::abs(leg_end_s - from.t_s);
        const double rate_rad_s = from.state.momentum_body.cast<double>().cwiseQuotient(moments_).norm();
        double length_s = std::min(wanted_s, kTimeScaleShare * leg.torques.time_scale_s(from.t_s));
        if (rate_rad_s > 0.0) length_s = std::min(length_s, kLongestTurn_rad / rate_rad_s);
        if (length_s > 0.999 * remaining_s) {
          length_s = remaining_s;
        } else if (length_s > 0.5 * remaining_s) {
          length_s = 0.5 * remaining_s;  // no sliver at the end
        }
        const double to_s = length_s == remaining_s ? leg_end_s : from.t_s + std::copysign(length_s, leg_end_s);
        length_s = std::abs(to_s - from.t_s);
        if (!(length_s > 4e-16 * std::abs(from.t_s))) return end_in(path, l);

        double error = 0.0;
        ExtendedState next;
        Node middle{};
        // A momentum off by a part d turns the body d omega t away in the time t that is left; but these errors swing
        // rather than add up, and what they come to is measured afterwards: start from the geometric mean.
        const double weight = std::sqrt(1.0 + rate_rad_s * std::abs(end_s - from.t_s));
        if (way_.scheme == nullptr) {
          next = stepped(way_, moments_, leg.torques, from, to_s - from.t_s, 1, evaluations_, &error);
          error *= weight / 1000.0;  // two orders of the step lie between the estimate and the error
        } else {
          const ExtendedState whole =
              stepped(way_, moments_, leg.torques, from, to_s - from.t_s, 1, evaluations_, nullptr);
          middle = {0.5 * (from.t_s + to_s), {}};
          middle.state = stepped(way_, moments_, leg.torques, from, middle.t_s - from.t_s, 1, evaluations_, nullptr);
          next = stepped(way_, moments_, leg.torques, middle, to_s - middle.t_s, 1, evaluations_, nullptr);
          const double momentum = static_cast<double>(next.momentum_body.norm());
          const double momentum_error = static_cast<double>((next.momentum_body - whole.momentum_body).norm());
          error = angle_rad(whole, next) + (momentum > 0.0 ? momentum_error / momentum * weight : 0.0);
          error /= 60.0;  // of the halves: 16 for the lowest order there is, 2000 for the highest
        }
        const double turned_rad =
            length_s * static_cast<double>(next.momentum_body.cast<double>().cwiseQuotient(moments_).norm());
        // Local errors of a symmetric method hardly add up: their share falls with the root of the number of steps.
        // Below the rounding of a step there is nothing to gain.
        const double rounding =
            (way_.scheme != nullptr ? 5e-15 / 60.0 : (way_.extended ? 3e-18 : 3e-15) / 1000.0) * weight;
        const double allowed = std::max(tolerance_rad_ * std::sqrt(length_s / std::abs(end_s)), rounding);
        if (evaluations_ > most_evaluations_) return end_in(path, l);
        const bool good = error <= allowed && turned_rad <= 2.0 * kLongestTurn_rad;
        const double exponent = way_.scheme == nullptr ? 1.0 / 15.0 : 1.0 / 7.0;
        const double factor =
            !std::isfinite(error) ? 0.1 : 0.85 * std::pow(allowed / std::max(error, 1e-300), exponent);
        wanted_s = length_s * std::clamp(factor, 0.1, good ? 4.0 : 0.7);
        if (good && way_.scheme != nullptr) leg.nodes.push_back(middle);
        if (good) leg.nodes.push_back({to_s, next});
      }
      state = leg.nodes.back().state;
    }
    return true;
  }

  std::size_t most_evaluations_;
  Way way_;
  Vector3 moments_;
  double tolerance_rad_ = 0.0;  // of the finest paths so far
  bool aside_ = false;
  ExtendedState start_;
  Path forward_, backward_;  // one leg per stretch between jumps, with its two ends as nodes
  std::size_t evaluations_ = 0;
};

void TorquedMotion::follow_series(const FreeBody& body, const Torques& torques, const TorquedOptions& options) {
  if (!SeriesMotion::serves(torques)) {
    throw InputError("a torque here has no series: facets in sunlight, or the currents of several fields");
  }
  series_ = std::make_shared<const SeriesMotion>(
      body, torques,
      SeriesMotion::Options{options.tolerance_rad, options.first_s, options.last_s, options.max_torque_evaluations});
  method_ = kSeries;
  first_s_ = series_->first_s();
  last_s_ = series_->last_s();
  error_rad_ = series_->error_rad();
  evaluations_ = series_->coefficients();
  kept_evaluations_ = series_->kept_coefficients();
  outcome_ = !series_->whole()                     ? Outcome::stopped
             : error_rad_ <= options.tolerance_rad ? Outcome::done
                                                   : Outcome::tolerance_not_reachable;
}

TorquedMotion::TorquedMotion(const FreeBody& body, const Torques& torques_named, const TorquedOptions& options)
    : moments_(checked(body).principal_moments), tolerance_rad_(options.tolerance_rad) {
  const Torques torques = torques_named.in_principal_axes(body.named_from_principal);
  if (!(options.tolerance_rad > 0.0 && std::isfinite(options.tolerance_rad))) {
    throw InputError(fmt::format("the tolerance is {}, a positive angle in radians is wanted", options.tolerance_rad));
  }
  check_span(options.first_s, options.last_s);
  // What "auto" tries in turn; a method of the caller's choice stands alone.
  std::vector<std::string_view> methods{options.splitting != nullptr ? options.splitting->name : options.method};
  const double phase_rad =
      body.momentum_body.cwiseQuotient(moments_).norm() * std::max(options.last_s, -options.first_s);
  if (methods.front() == kAuto) {
    methods = {kExtrapolationInDouble, kExtrapolation};
    if (rounding_of_doubles_rad(phase_rad) > options.tolerance_rad) methods = {kExtrapolation};
    if (SeriesMotion::serves(torques)) methods = {kSeries};
  }
  if (methods.front() == kSeries) {
    follow_series(body, torques, options);
    return;
  }
  for (const std::string_view name : methods) {
    const bool last = name == methods.back();
    Builder builder(body, torques, options, name, evaluations_);
    way_ = Builder::way(name, options);
    method_ = way_.scheme != nullptr ? way_.scheme->name
              : way_.extended        ? kExtrapolation
                                     : kExtrapolationInDouble;  // not `name`, which may be the caller's
    double gain = 1.0, looser = 1.0, safety = kSafety;
    if (way_.scheme == nullptr) {
      gain = way_.extended ? kGainOfExtrapolation : kGainOfExtrapolationInDouble;
      looser = way_.extended ? kLooserExtrapolation : kLooserExtrapolationInDouble;
    }
    if (!torques.smooth()) gain = 1.0 / kClaimWithKinks, safety = 1.0;
    const double goal_rad = gain * options.tolerance_rad / safety;
    Path forward, backward;
    bool whole = builder.first_paths(looser * options.tolerance_rad, forward, backward);
    double before_rad = std::numeric_limits<double>::infinity();
    std::size_t kept_from = 0;
    int poor = 0;  // steps of refinement that gained little
    error_rad_ = std::numeric_limits<double>::infinity();
    outcome_ = Outcome::tolerance_not_reachable;
    bool hopeless = !last && way_.scheme != nullptr &&
                    std::max(builder.rounding_rad(forward), builder.rounding_rad(backward)) > options.tolerance_rad;
    for (int refinement = 0; whole && !hopeless && refinement < kMostRefinements; ++refinement) {
      Path finer_forward, finer_backward;
      const std::size_t before = builder.evaluations();
      whole = builder.finer_paths(forward, backward, finer_forward, finer_backward);
      if (!whole) break;
      kept_from = before;
      const double difference =
          std::max(builder.difference_rad(forward, finer_forward), builder.difference_rad(backward, finer_backward));
      // Finer steps gain a factor of ten and more from where the runs are near each other, until rounding shows.
      poor += difference < 0.1 && !(difference < 0.5 * before_rad);
      hopeless = poor >= 2 || (difference < 0.1 && !(difference < 2.0 * before_rad));
      before_rad = difference;
      error_rad_ = difference / gain;
      forward = std::move(finer_forward), backward = std::move(finer_backward);
      if (difference <= std::min(goal_rad, kAsymptotic_rad)) {
        outcome_ = Outcome::done;
        break;
      }
    }
    evaluations_ += builder.evaluations();
    const bool out_of_evaluations = evaluations_ >= options.max_torque_evaluations;
    if (outcome_ != Outcome::done) {
      if (!last && !out_of_evaluations) continue;
      if (!whole) outcome_ = Outcome::stopped;
      if (error_rad_ <= options.tolerance_rad) outcome_ = Outcome::done;  // with less margin than was aimed at
    }
    forward_ = std::move(forward);
    backward_ = std::move(backward);
    kept_evaluations_ = builder.evaluations() - kept_from;
    first_s_ = backward_.back().nodes.back().t_s;
    last_s_ = forward_.back().nodes.back().t_s;
    break;
  }
}

MotionAccount TorquedMotion::account() const {
  MotionAccount account;
  account.method = method_;
  account.torque_evaluations = evaluations_;
  if (outcome_ == Outcome::stopped) {
    account.error_meaning = "nothing is promised: the end of the span was not reached";
    return account;
  }
  const std::string found = series_ ? fmt::format("carried along with the motion: {:.1e} rad", error_rad_)
                                    : fmt::format("two runs agree to {:.1e} rad", error_rad_);
  if (outcome_ == Outcome::done) {
    account.max_error_rad = tolerance_rad_;
    account.error_meaning = found + "; the numbers of the body and its torques are taken as exact";
  } else {
    account.error_meaning = fmt::format("nothing is promised: {} only", found);
  }
  return account;
}

std::size_t TorquedMotion::steps() const {
  if (series_) return series_->steps();
  std::size_t count = 0;
  for (const Path* path : {&forward_, &backward_}) {
    for (const Leg& leg : *path) count += leg.nodes.size() - 1;
  }
  return count;
}

void TorquedMotion::batch(const TimeArrays& times, const StateArrays& out) const {
  if (series_) {
    series_->batch(times, out);
  } else {
    Motion::batch(times, out);
  }
}

State TorquedMotion::at(double t_high_s, double t_low_s) const {
  if (series_) return series_->at(t_high_s, t_low_s);
  if (std::isnan(t_high_s + t_low_s)) return nan_state();
  const double room_s = end_room_s(last_s_ - first_s_);
  if (!(t_high_s >= first_s_ - room_s && t_high_s <= last_s_ + room_s)) {
    throw InputError(fmt::format("the motion was propagated from {} s to {} s, it was asked for at {} s", first_s_,
                                 last_s_, t_high_s));
  }
  // Beyond an end at t = 0 the other way's motion goes on.
  const bool is_forward = t_high_s >= 0.0 ? last_s_ > 0.0 || first_s_ == 0.0 : first_s_ == 0.0;
  const Path& path = is_forward ? forward_ : backward_;
  const double away_s = std::abs(t_high_s);
  const Leg& leg =
      *std::find_if(path.begin(), path.end() - 1, [&](const Leg& l) { return away_s <= std::abs(l.nodes.back().t_s); });
  const auto after = std::upper_bound(leg.nodes.begin(), leg.nodes.end(), away_s,
                                      [](double t, const Node& node) { return t < std::abs(node.t_s); });
  const Node& node = *(after == leg.nodes.begin() ? after : after - 1);
  const double length_s = (t_high_s - node.t_s) + t_low_s;
  if (length_s == 0.0) return plain(node.state);
  std::size_t uncounted = 0;
  return plain(Builder::stepped(way_, moments_, leg.torques, node, length_s, 1, uncounted, nullptr));
}

}  // namespace polhode
