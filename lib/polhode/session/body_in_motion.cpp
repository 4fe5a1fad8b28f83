#include "polhode/session/body_in_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/ephemeris/row_spacing.hpp"
#include "polhode/motion/attitude_covariance.hpp"
#include "polhode/motion/conditioning.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/known_until.hpp"
#include "polhode/motion/torqued_motion.hpp"

namespace polhode {
namespace {

PrincipalMotion states_of(std::shared_ptr<const Motion> motion) {
  return [motion = std::move(motion)](std::span<const double> high, std::span<const double> low, double* q, double* m) {
    motion->batch({high, low}, StateArrays::of_structures(q, m));
  };
}

}  // namespace

MotionAccount BodyInMotion::account_between(Instant start, Instant stop, TimeScale scale) const {
  const Instant epoch = body.state->epoch;
  const double from_s = (start - epoch).high, to_s = (stop - epoch).high;
  if (under_torques) {
    const double room_s = end_room_s(last_s - first_s);
    if (from_s < first_s - room_s || to_s > last_s + room_s) {
      const auto date = [scale](Instant time) { return format_date(time, scale, 0); };
      throw InputError(
          fmt::format("the scene lasts from {} to {} {}, its epoch {:+} s to {:+} s; rows from {} to {} are asked for "
                      "by start, stop or times ('before' and 'after' in the scene make it longer)",
                      date(epoch + Seconds{first_s, 0.0}), date(epoch + Seconds{last_s, 0.0}), name(scale), first_s,
                      last_s, date(start), date(stop)));
    }
  }
  return account(from_s, to_s);
}

BodyInMotion free_motion_of(Body body, Frame frame, const Method& method) {
  BodyInMotion moving;
  moving.free = free_body(body, frame);
  moving.uncertainty = body.uncertainty;
  moving.body = std::move(body);
  moving.frame = frame;
  moving.motion = method.make(moving.free);
  moving.account = [&method, free = moving.free](double first_s, double last_s) {
    return free_motion_account(method, free, first_s, last_s);
  };
  return moving;
}

double uncertain_at_end_rad(const Scene& scene) {
  if (!scene.body.uncertainty) return 0.0;
  const AttitudeCovariance covariance(scene.body);
  double least_rad = std::numeric_limits<double>::infinity();
  for (const double end_s : {scene.first_s, scene.last_s}) {
    if (end_s != 0.0) least_rad = std::min(least_rad, covariance.sigma_rad(end_s));
  }
  return least_rad;
}

Plan plan_of(const Scene& scene, bool full) {
  return plan_motion(free_body(scene.body, scene.frame), scene.torques, scene.first_s, scene.last_s, scene.accuracy_rad,
                     full, uncertain_at_end_rad(scene),
                     scene.uncertain ? scene.uncertain->acts_on : std::vector<bool>{});
}

std::optional<std::string> scene_worth_text(const Body& body, bool torques_are_uncertain, double farthest_s,
                                            bool beside_covariance) {
  std::optional<std::string> text = worth_text(body, farthest_s);
  if (!torques_are_uncertain || (beside_covariance && !text)) return text;
  return (text ? *text + "; this is the free motion's, and the torques' own numbers are uncertain, too"
               : "the torques' numbers are uncertain") +
         ": `propagate --covariance` and `sample` say what that does to the attitude";
}

namespace {

/// What is not known of the body, and behind it what is not of the torques.
std::shared_ptr<const Uncertainty> with_torques(const Scene& scene) {
  const UncertainTorques& torques = *scene.uncertain;
  Uncertainty all = scene.body.uncertainty ? *scene.body.uncertainty : Uncertainty{};
  const auto of_body = static_cast<Eigen::Index>(all.numbers.size());
  const auto of_torques = static_cast<Eigen::Index>(torques.numbers.size());
  all.numbers.insert(all.numbers.end(), torques.numbers.begin(), torques.numbers.end());
  all.covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(of_body + of_torques, of_body + of_torques));
  all.covariance.bottomRightCorner(of_torques, of_torques) = torques.covariance;
  Body exact = scene.body;
  exact.uncertainty.reset();
  all.body_with = [of_body, of_torques, with = all.body_with, exact,
                   uncertain = scene.uncertain](const Eigen::VectorXd& values) {
    uncertain->torques_with(values.tail(of_torques));  // refuses what no torque has
    return with ? with(values.head(of_body)) : exact;
  };
  return std::make_shared<const Uncertainty>(std::move(all));
}

/// Those of other torques in the same order that the plan keeps.
Torques kept_of(const Plan& plan, const Torques& torques) {
  std::vector<Torque> kept;
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (plan.effects[i].kept) kept.push_back(torques.list()[i]);
  }
  return Torques(std::move(kept));
}

}  // namespace

BodyInMotion planned_motion_of(const Scene& scene, bool full, std::optional<std::size_t> most_evaluations) {
  BodyInMotion moving;
  moving.body = scene.body;
  moving.frame = scene.frame;
  moving.free = free_body(scene.body, scene.frame);
  moving.under_torques = true;
  moving.first_s = scene.first_s;
  moving.last_s = scene.last_s;
  const Plan plan = plan_of(scene, full);
  PlannedMotion planned =
      planned_motion(plan, moving.free, scene.first_s, scene.last_s,
                     most_evaluations.value_or(full ? kMostTorqueEvaluationsInFull : kMostTorqueEvaluations));
  moving.motion = std::move(planned.motion);
  moving.uncertainty = scene.uncertain ? with_torques(scene) : scene.body.uncertainty;
  moving.motion_of = [plan, first_s = scene.first_s, last_s = scene.last_s, full, uncertain = scene.uncertain](
                         const FreeBody& other, const Eigen::VectorXd& numbers, double tolerance_rad) {
    const std::size_t most = full ? kMostTorqueEvaluationsInFull : kMostTorqueEvaluations;
    Plan own = plan;
    if (uncertain) {
      const auto of_torques = static_cast<Eigen::Index>(uncertain->numbers.size());
      own.kept = kept_of(plan, uncertain->torques_with(numbers.tail(of_torques)));
    }
    if (tolerance_rad < plan.tolerance_rad) {
      own.tolerance_rad = tolerance_rad;
      own.few_kicks = false;
    }
    own.torque_evaluations.reset();
    own.dropped_rad = 0.0;
    return planned_motion(own, other, first_s, last_s, most);
  };
  moving.account = [account = std::move(planned.account)](double, double) { return account; };
  return moving;
}

std::size_t rows_for_tolerance(const BodyInMotion& moving, Instant start, Instant stop, TimeScale scale,
                               double tolerance_rad, RowInterpolation interpolation) {
  const MotionAccount account = moving.account_between(start, stop, scale);
  if (!account.max_error_rad) {
    throw InputError(fmt::format("a tolerance needs a promised error of the rows, which {} does not give ({})",
                                 account.method, account.error_meaning));
  }
  const Instant epoch = moving.body.state->epoch;
  return polhode::rows_for_tolerance(states_of(moving.motion), moving.free.principal_moments, (start - epoch).high,
                                     (stop - epoch).high, tolerance_rad, *account.max_error_rad, interpolation);
}

Ephemeris rows_of(const BodyInMotion& moving, TimeGrid times, std::optional<double> tolerance_rad,
                  const EphemerisFormat* format, bool covariance) {
  const Instant first = times.instant(times.time(0, {}));
  const Instant last = times.instant(times.time(times.size() - 1, {}));
  const MotionAccount account = moving.account_between(first, last, times.scale());
  const Body& body = moving.body;
  EphemerisDescription description;
  description.object = body.name;
  description.object_id = body.id;
  description.source = body.source;
  description.method = account.method;
  description.promised_error_rad = account.max_error_rad;
  description.error_meaning = account.error_meaning;
  if (moving.under_torques) description.torque_evaluations = account.torque_evaluations;
  const Instant epoch = body.state->epoch;
  const double farthest_s = std::max(std::abs((first - epoch).high), std::abs((last - epoch).high));
  const bool torques_are_uncertain = moving.uncertainty != body.uncertainty;
  if (auto caution = scene_worth_text(body, torques_are_uncertain, farthest_s, covariance)) {
    description.cautions.push_back(*std::move(caution));
  }
  if (tolerance_rad && format != nullptr) {
    description.tolerance_rad = tolerance_rad;
    description.interpolation = format->interpolation_text;
    if (format->interpolation == RowInterpolation::lagrange_degree_7) {
      description.ccsds_interpolation = "LAGRANGE";
      description.ccsds_interpolation_degree = 7;
    }
  }
  CovarianceRows uncertain;
  if (covariance) {
    uncertain = covariance_rows(moving, (first - epoch).high, (last - epoch).high);
    if (uncertain.caution) description.cautions.push_back(*std::move(uncertain.caution));
  }
  Ephemeris ephemeris(std::move(description), body, moving.frame, std::move(times), states_of(moving.motion));
  if (covariance) ephemeris.set_covariance(std::move(uncertain.rows));
  return ephemeris;
}

}  // namespace polhode
