#include "polhode/motion/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "polhode/base/error.hpp"
#include "polhode/base/error_budget.hpp"
#include "polhode/motion/attitude_covariance.hpp"
#include "polhode/motion/conditioning.hpp"
#include "polhode/motion/kicked_motion.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/motion/partials.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/motion/torqued_motion.hpp"

namespace polhode {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// When a plan tells what the propagation will cost. Two trials over the first part of the span, the second longer than
/// the first, tell it if they agree and the surroundings stay as they are. Chosen on 200 random scenes, of which two
/// thirds are told and the worst prediction is off by a factor of 1.66; held by
/// Planner.PredictsItsCostOrSaysThatItCannot.
struct TrialTuning {
  static constexpr double shorter = 0.02, longer = 0.08;  // of the span
  static constexpr double most_of_span = 0.3;             // a longer trial may as well be the whole
  static constexpr double steady = 1.3;                   // by what factor distances may change over the span
  static constexpr double agree = 1.25;                   // by what factor the costs per time of the two may differ
  static constexpr double error_margin = 0.05;            // of the tolerance, that the error of a part may take
};

constexpr double kMostPushes = 2e6;          // steps in which the bound of a torque is summed: a second or two
constexpr double kFullTolerance_rad = 1e-9;  // with everything kept
constexpr double kDroppedOfUncertainty = 0.1;

/// No attitude and no momentum of this length feels a larger torque at time t.
double largest_torque(const Torque& torque, double t_s, const FreeBody& body) {
  return std::visit(
      [&](const auto& one) { return one.largest(t_s, body.principal_moments, body.momentum_body.norm()); }, torque);
}

/// False for a torque of one's own that does not say how large it may be.
bool has_bound(const Torque& torque, const FreeBody& body) {
  return !std::holds_alternative<OwnTorque>(torque) || std::isfinite(largest_torque(torque, 0.0, body));
}

/// rad of attitude per relative change of the momentum, by the time since the change: worst of all directions, of
/// several places on the free motion, of both directions of time. By its exact partial derivatives, then doubled; grows
/// with time.
class Sensitivity {
 public:
  Sensitivity(const FreeBody& body, double longest_s) : longest_s_(longest_s) {
    const ThetaMotion whole(body);
    for (const double place : {0.0, 0.2137, 0.5681}) {
      const State state = whole.at(place * longest_s);
      const FreePartials motion({body.principal_moments, state.q_inertial_from_body, state.momentum_body});
      for (std::size_t i = 1; i < by_time_.size(); ++i) {
        for (const double direction : {-1.0, 1.0}) {
          const Matrix3 turn = motion.at(direction * time_s(i)).partials.block<3, 3>(0, 3);
          const double worst = std::sqrt(largest_variance(turn * turn.transpose()));
          by_time_[i] = std::max(by_time_[i], state.momentum_body.norm() * worst);
        }
      }
    }
    for (std::size_t i = 0; i < by_time_.size(); ++i) {
      // A change of momentum alone turns nothing, but may be a turn of it.
      by_time_[i] = 2.0 * std::max(by_time_[i], 1.0);
      if (i > 0) by_time_[i] = std::max(by_time_[i], by_time_[i - 1]);
    }
  }

  /// From above: the value at the next later time that was looked at.
  double after(double elapsed_s) const {
    std::size_t i = 0;
    while (i + 1 < by_time_.size() && time_s(i) < elapsed_s) ++i;
    return by_time_[i];
  }
  double at_the_end() const { return by_time_.back(); }

 private:
  /// Sixteen times, closer together early.
  double time_s(std::size_t i) const {
    const double part = static_cast<double>(i) / static_cast<double>(by_time_.size() - 1);
    return longest_s_ * part * part;
  }

  double longest_s_;
  std::array<double, 17> by_time_{};
};

struct Push {
  double impulse = 0.0;     // integral of the largest torque over the span
  double turned_rad = 0.0;  // at an end, each part of the impulse in the worst direction with the time it has left
};

/// What the largest torque does from t = 0 to one end of the span.
Push largest_push(const Torque& torque, const FreeBody& body, double end_s, const Sensitivity& sensitivity) {
  const double momentum = body.momentum_body.norm(), direction = end_s < 0.0 ? -1.0 : 1.0, length_s = std::abs(end_s);
  const Torques alone({torque});
  const double quick_s = body.momentum_body.norm() > 0.0 ? length_s / 64.0 : length_s;
  std::vector<double> stops_s;  // a pulse begins and ends at a stop
  for (const double jump_s : alone.jumps_s()) {
    if (jump_s * direction > 0.0 && std::abs(jump_s) < length_s) stops_s.push_back(std::abs(jump_s));
  }
  stops_s.push_back(length_s);
  std::sort(stops_s.begin(), stops_s.end());
  Push push;
  double gone_s = 0.0, pushes = 0.0;
  const auto largest_at = [&](double away_s) {
    const double largest = largest_torque(torque, direction * away_s, body);
    if (!std::isfinite(largest)) {
      throw InputError(fmt::format("{}: the largest torque at {} s is {}; a finite one is wanted", torque_name(torque),
                                   direction * away_s, largest));
    }
    return largest;
  };
  const bool jumps = std::visit([](const auto& one) { return JumpingTorque<std::decay_t<decltype(one)>>; }, torque);
  // One that jumps is constant between its stops: its middle counts.
  double at_begin = jumps ? 0.0 : largest_at(0.0);
  for (const double stop_s : stops_s) {
    while (gone_s < stop_s) {
      const double step_s = std::min({0.02 * alone.time_scale_s(direction * gone_s), stop_s - gone_s, quick_s});
      if (!(step_s > 0.0) || ++pushes > kMostPushes) {
        throw InputError(fmt::format(
            "{}: its surroundings change too often in {} s to be followed: at {} s they take {} s; shorten the span",
            torque_name(torque), length_s, direction * gone_s, 50.0 * step_s));
      }
      const double next_s = step_s < stop_s - gone_s ? gone_s + step_s : stop_s;
      const double at_end = largest_at(jumps ? 0.5 * (gone_s + next_s) : next_s);
      // The larger of the ends, and 5 % for what may lie between them: r changes by 2 % in a step.
      const double impulse = (jumps ? at_end : 1.05 * std::max(at_begin, at_end)) * (next_s - gone_s);
      push.impulse += impulse;
      push.turned_rad += impulse / momentum * sensitivity.after(length_s - gone_s);
      gone_s = next_s;
      at_begin = at_end;
    }
  }
  return push;
}

/// Which chart of the free motion is enough, and why. All are the same exact series; this is for people.
void name_free_model(const FreeBody& body, double accuracy_rad, Plan& plan) {
  const Vector3& I = body.principal_moments;
  const Vector3 m = body.momentum_body / body.momentum_body.norm();
  const Vector3 away = m.cwiseAbs();
  Eigen::Index axis = 0;
  const double along = away.maxCoeff(&axis);
  const double wobble = std::atan2(std::sqrt(std::max(0.0, 1.0 - along * along)), along);
  if (wobble < 0.5 * accuracy_rad && axis != 1) {
    plan.model = "principal-axis rotation";
    plan.why = fmt::format("the axis wobbles by {:.1e} rad", wobble);
  } else if (I[0] == I[1] || I[1] == I[2]) {
    plan.model = "symmetric top";
    plan.why = "two moments are equal";
  } else {
    plan.model = "free triaxial";
    plan.why = "exact at any time: nothing cheaper is needed";
  }
}

[[noreturn]] void throw_no_room(double accuracy_rad, double error_rad) {
  throw InputError(
      fmt::format("an accuracy of {} rad cannot be kept: over this span the attitude is good to {:.1e} rad",
                  accuracy_rad, error_rad));
}

/// What to say of the exact free motion; refuses an accuracy that its rounding leaves no room for.
MotionAccount free_account(const FreeBody& body, double first_s, double last_s, double accuracy_rad) {
  MotionAccount account = free_motion_account(method("theta"), body, first_s, last_s);
  if (!account.max_error_rad) throw_no_room(accuracy_rad, std::numbers::pi);
  if (*account.max_error_rad > accuracy_rad) throw_no_room(accuracy_rad, *account.max_error_rad);
  return account;
}

/// So many evaluations of these torques are as much work as `most` of a gravity gradient.
std::size_t allowed_evaluations(const Torques& torques, std::size_t most) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(static_cast<double>(most) / torques.cost_of_evaluation()));
}

/// The ratio of the longest to the shortest time in which the surroundings change during the span; 1 without any.
double unsteadiness(const Torques& torques, double first_s, double last_s) {
  constexpr int looks = 1000;
  double least = kInfinity, most = 0.0;
  for (int i = 0; i <= looks; ++i) {
    const double scale_s = torques.time_scale_s(std::lerp(first_s, last_s, static_cast<double>(i) / looks));
    least = std::min(least, scale_s);
    most = std::max(most, scale_s);
  }
  return std::isfinite(most) ? most / least : 1.0;
}

/// Model and cost from TorquedMotion over the first parts of the span.
void predict_by_trials(const FreeBody& body, double first_s, double last_s, double rate_rad_s, std::size_t most,
                       Plan& plan) {
  const double span_s = last_s - first_s;
  const double least_s = rate_rad_s > 0.0 ? 20.0 / rate_rad_s : span_s;  // a few turns
  const double shortest = std::min(1.0, std::max(TrialTuning::shorter, least_s / span_s));
  double longest = shortest * TrialTuning::longer / TrialTuning::shorter;
  if (longest > TrialTuning::most_of_span) longest = 1.0;
  bool needs_more = false;
  const auto trial = [&](double share) {
    TorquedOptions options{plan.tolerance_rad, share * first_s, share * last_s};
    options.max_torque_evaluations = most;
    const TorquedMotion motion(body, plan.kept, options);
    needs_more = motion.error_rad() > TrialTuning::error_margin * longest * plan.tolerance_rad;
    return motion.account();
  };
  const MotionAccount second = trial(longest);
  const std::string part =
      longest == 1.0 ? "the whole span" : fmt::format("the first {:.1f} % of the span", 100.0 * longest);
  plan.model = second.method;
  plan.why = fmt::format("steps chosen for {:.1e} rad{}", plan.tolerance_rad,
                         plan.kept.smooth() ? "" : "; the kinks that facets make may keep it from that");
  if (second.torque_evaluations >= most) {
    plan.cost_why =
        fmt::format("a trial over {} was ended after {} torque evaluations", part, second.torque_evaluations);
    return;
  }
  const auto evaluations = static_cast<double>(second.torque_evaluations);
  if (longest == 1.0) {
    plan.torque_evaluations = evaluations;
    plan.cost_why = "from a trial over " + part;
    return;
  }
  const std::string at_least =
      fmt::format("a trial over {} took {} torque evaluations, but ", part, second.torque_evaluations);
  if (unsteadiness(plan.kept, first_s, last_s) > TrialTuning::steady || !plan.kept.jumps_s().empty()) {
    plan.cost_why = at_least + "the surroundings change over the span";
    return;
  }
  if (needs_more) {
    plan.cost_why = at_least + "the error may grow along the span until more runs are needed";
    return;
  }
  const MotionAccount first = trial(shortest);
  const double ratio = evaluations / static_cast<double>(first.torque_evaluations) * shortest / longest;
  if (first.method != second.method || !(ratio < TrialTuning::agree && ratio > 1.0 / TrialTuning::agree)) {
    plan.cost_why = at_least + "the effort changes along the span";
    return;
  }
  plan.torque_evaluations = evaluations / longest;
  plan.cost_why = "from trials over " + part;
}

}  // namespace

Plan plan_motion(const FreeBody& body, const Torques& torques, double first_s, double last_s, double accuracy_rad,
                 bool full, double uncertain_rad, const std::vector<bool>& uncertain) {
  checked(body);
  if (!uncertain.empty() && uncertain.size() != torques.list().size()) {
    throw InputError(fmt::format("{} torques, and of {} it is said whether they are uncertain", torques.list().size(),
                                 uncertain.size()));
  }
  if (!(uncertain_rad >= 0.0)) {
    throw InputError(fmt::format("the attitude is uncertain by {} rad, 0 or more is wanted", uncertain_rad));
  }
  if (!(accuracy_rad > 0.0 && std::isfinite(accuracy_rad))) {
    throw InputError(fmt::format("the accuracy is {}, a positive angle in radians is wanted", accuracy_rad));
  }
  check_span(first_s, last_s);
  Plan plan;
  const double momentum = body.momentum_body.norm();
  const double rate_rad_s = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
  const double budget_rad = ErrorBudget::motion_of_accuracy * accuracy_rad, span_s = last_s - first_s;
  std::optional<Sensitivity> sensitivity;
  if (momentum > 0.0 && span_s > 0.0) sensitivity.emplace(body, std::max(last_s, -first_s));
  plan.sensitivity = sensitivity ? sensitivity->at_the_end() : momentum > 0.0 ? 1.0 : kInfinity;

  std::vector<std::size_t> by_size;
  const Torques principal = torques.in_principal_axes(body.named_from_principal);
  for (const Torque& torque : principal.list()) {
    PlannedEffect effect;
    effect.name = torque_name(torque);
    if (momentum > 0.0 && has_bound(torque, body)) {
      double impulse = 0.0, turned_rad = 0.0;
      for (const double end_s : {first_s, last_s}) {
        if (end_s == 0.0) continue;
        const Push push = largest_push(torque, body, end_s, *sensitivity);
        impulse += push.impulse;
        turned_rad = std::max(turned_rad, push.turned_rad);
      }
      if (!std::isfinite(turned_rad)) {
        throw InputError(
            fmt::format("{}: the bound of what it does is {} rad; a finite one is wanted", effect.name, turned_rad));
      }
      effect.secular_rad = turned_rad;
      effect.periodic_rad = span_s > 0.0 ? impulse / span_s / (momentum * rate_rad_s) : 0.0;
    }
    by_size.push_back(plan.effects.size());
    plan.effects.push_back(std::move(effect));
  }
  const auto bound_rad = [&](std::size_t i) { return plan.effects[i].secular_rad.value_or(kInfinity); };
  std::sort(by_size.begin(), by_size.end(), [&](std::size_t a, std::size_t b) { return bound_rad(a) < bound_rad(b); });
  std::vector<Torque> kept;
  const double of_accuracy_rad = ErrorBudget::dropped_of_motion * budget_rad;
  const double of_uncertainty_rad = kDroppedOfUncertainty * std::min(uncertain_rad, std::numbers::pi);
  for (const std::size_t i : by_size) {  // the smallest first, while they fit into half the accuracy
    PlannedEffect& effect = plan.effects[i];
    const double all_rad = plan.dropped_rad + bound_rad(i);
    const bool is_uncertain = !uncertain.empty() && uncertain[i];
    effect.kept = full || is_uncertain || all_rad > std::max(of_accuracy_rad, of_uncertainty_rad);
    if (!effect.kept) {
      effect.why = all_rad <= of_accuracy_rad
                       ? "negligible, also together with all others that are dropped"
                       : fmt::format("below a tenth of the {:.1e} rad that the uncertainties do anyway",
                                     std::min(uncertain_rad, std::numbers::pi));
      plan.dropped_rad = all_rad;
    } else if (full) {
      effect.why = "everything was asked for";
    } else if (is_uncertain) {
      effect.why = "its numbers are uncertain";
    } else if (!effect.secular_rad) {
      effect.why = momentum > 0.0 ? "nobody knows how large it may be" : "the body is at rest: any torque turns it";
    } else {
      effect.why = fmt::format("may turn it by more than {:.1e} rad",
                               std::max(of_accuracy_rad, of_uncertainty_rad) - plan.dropped_rad);
    }
  }
  // What is dropped for the uncertainties' sake is beyond the accuracy, and not counted against it.
  const double beyond_rad = std::max(0.0, plan.dropped_rad - of_accuracy_rad);
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (plan.effects[i].kept) kept.push_back(torques.list()[i]);
  }
  plan.kept = Torques(std::move(kept));
  // What is not spent on dropped effects is left for the propagation.
  plan.tolerance_rad = full ? std::min(kFullTolerance_rad, budget_rad) : budget_rad - (plan.dropped_rad - beyond_rad);
  if (plan.kept.empty()) {
    name_free_model(body, accuracy_rad, plan);
    plan.torque_evaluations = 0.0;
    plan.cost_why = "no torque is kept";
    plan.error_rad = plan.dropped_rad + free_account(body, first_s, last_s, accuracy_rad).max_error_rad.value();
    return plan;
  }
  plan.error_rad = plan.dropped_rad + plan.tolerance_rad + ErrorBudget::rounding_rad;
  if (plan.error_rad - beyond_rad > accuracy_rad) throw_no_room(accuracy_rad, plan.error_rad);
  if (!full) {
    const KickedOptions kicked{plan.tolerance_rad, first_s, last_s, kMostTorqueEvaluations};
    if (const auto evaluations = KickedMotion::predicted_evaluations(body, plan.kept, kicked)) {
      plan.few_kicks = true;
      plan.model = "splitting, few kicks per turn";
      plan.why = fmt::format("{:.2g} torque evaluations per turn suffice for {:.1e} rad",
                             *evaluations * 2.0 * std::numbers::pi / (rate_rad_s * span_s), plan.tolerance_rad);
      if (plan.kept.smooth()) {
        plan.torque_evaluations = *evaluations;
        plan.cost_why = "from a trial of a hundred turns";
      } else {
        plan.cost_why =
            "facets that come into the light make kinks, which may need another method, and may keep it from "
            "this accuracy";
      }
      return plan;
    }
  }
  const std::size_t tenth = (full ? kMostTorqueEvaluationsInFull : kMostTorqueEvaluations) / 10;
  predict_by_trials(body, first_s, last_s, rate_rad_s, allowed_evaluations(plan.kept, tenth), plan);
  return plan;
}

PlannedMotion planned_motion(const Plan& plan, const FreeBody& body, double first_s, double last_s,
                             std::size_t most_torque_evaluations) {
  PlannedMotion planned;
  if (plan.kept.empty()) {
    planned.motion = std::make_unique<ThetaMotion>(body);
    planned.account = free_account(body, first_s, last_s, plan.error_rad);
    *planned.account.max_error_rad += plan.dropped_rad;
    if (plan.dropped_rad > 0.0) {
      planned.account.error_meaning =
          "bound of the torques that were left out, and rounding; the numbers of the body are taken as exact";
    }
    return planned;
  }
  const std::size_t most = allowed_evaluations(plan.kept, most_torque_evaluations);
  if (plan.torque_evaluations && *plan.torque_evaluations > static_cast<double>(most)) {
    throw ComputationError(fmt::format(
        "the propagation would take about {:.2g} torque evaluations, {} are allowed; allow more by --max-evaluations "
        "(max_evaluations), or ask for less accuracy or a shorter span",
        *plan.torque_evaluations, most));
  }
  std::size_t in_vain = 0;
  if (plan.few_kicks) {
    if (auto motion = KickedMotion::make(body, plan.kept, {plan.tolerance_rad, first_s, last_s, most}, &in_vain)) {
      planned.account = motion->account();
      planned.motion = std::move(motion);
    }
  }
  if (!planned.motion) {
    TorquedOptions options{plan.tolerance_rad, first_s, last_s};
    options.max_torque_evaluations = most - std::min(in_vain, most - 1);
    auto motion = std::make_unique<TorquedMotion>(body, plan.kept, options);
    if (motion->outcome() == Outcome::stopped) {
      throw ComputationError(
          fmt::format("the propagation was ended after {} of the {} torque evaluations that are allowed; allow more "
                      "by --max-evaluations (max_evaluations), or ask for less accuracy or a shorter span",
                      motion->torque_evaluations() + in_vain, most));
    }
    if (motion->outcome() != Outcome::done) {
      throw ComputationError(
          fmt::format("the planned accuracy is not reached: the estimated error of the propagation is {:.1e} rad, "
                      "{:.1e} rad was planned for it{}; "
                      "ask for less accuracy or a shorter span",
                      motion->error_rad(), plan.tolerance_rad,
                      plan.kept.smooth() ? "" : " (facets that come into the light make kinks)"));
    }
    planned.account = motion->account();
    planned.motion = std::move(motion);
  }
  planned.account.torque_evaluations += in_vain;
  *planned.account.max_error_rad += plan.dropped_rad + ErrorBudget::rounding_rad;
  if (plan.dropped_rad > 0.0) planned.account.error_meaning += "; the bound of the torques that were left out is added";
  return planned;
}

}  // namespace polhode
