#include "polhode/motion/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polhode/base/error.hpp"
#include "polhode/motion/theta.hpp"

namespace polhode {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // clang 14 does not deduce it

double largest_norm(const Matrix3& matrix) { return matrix.norm(); }

/// No attitude and no momentum of this length feels a larger torque at time t.
double largest_torque(const Torque& torque, double t_s, const FreeBody& body) {
  const Vector3& I = body.principal_moments;
  const double momentum = body.momentum_body.norm();
  return std::visit(
      Overloaded{
          [&](const GravityGradient& one) {
            const double r = one.trajectory.state(t_s).position_m.norm();
            return 1.5 * one.mu_m3_s2 / (r * r * r) * (I[2] - I[0]);
          },
          [](const ConstantTorque& one) { return one.torque.norm(); },
          [&](const ThrusterPulse& one) {
            return one.start_s <= t_s && t_s <= one.end_s() ? one.torque_body.norm() : 0.0;
          },
          [&](const LinearDamping& one) { return one.coefficients.cwiseQuotient(I).cwiseAbs().maxCoeff() * momentum; },
          [&](const EddyCurrents& one) {
            const OrbitState<double> orbit = one.trajectory.state(t_s);
            const double r = orbit.position_m.norm(), v = orbit.velocity_m_s.norm();
            const double field = 2.0 * one.dipole_t_m3 / (r * r * r);
            return largest_norm(one.magnetic_tensor_s_m4) * field * field * (momentum / I[0] + 6.0 * v / r);
          },
          [&](const InternalDissipation& one) {
            return one.relaxation * momentum * momentum * momentum * 0.5 * (1.0 / I[0] - 1.0 / I[2]);
          },
          [&](const Sunlight& one) { return one.largest_torque(t_s); }},
      torque);
}

/// Integral of the largest torque over the span.
double largest_impulse(const Torque& torque, const FreeBody& body, double first_s, double last_s) {
  if (const auto* pulse = std::get_if<ThrusterPulse>(&torque)) {
    const double on_s = std::min(last_s, pulse->end_s()) - std::max(first_s, pulse->start_s);
    return std::max(0.0, on_s) * pulse->torque_body.norm();
  }
  const Torques alone({torque});
  double sum = 0.0;
  for (double t = first_s; t < last_s;) {
    const double step = std::min({0.02 * alone.time_scale_s(t), last_s - t, 0.25 * (last_s - first_s)});
    // The larger of the ends, and 5 % for what may lie between them (r changes by 2 % in a step).
    sum += 1.05 * step * std::max(largest_torque(torque, t, body), largest_torque(torque, t + step, body));
    t = step < last_s - t ? t + step : last_s;
  }
  return sum;
}

/// rad of attitude per relative change of the momentum, worst of all directions and times of the span.
double free_sensitivity(const FreeBody& body, double first_s, double last_s) {
  const ThetaMotion motion(body);
  const double momentum = body.momentum_body.norm();
  double worst = 1.0;
  for (const double size : {1e-7, 1e-4}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        FreeBody pushed = body;
        pushed.momentum_body += sign * size * momentum * Vector3::Unit(axis);
        const ThetaMotion other(pushed);
        for (int i = -4; i <= 4; ++i) {
          const double t = i < 0 ? first_s * i / -4.0 : last_s * i / 4.0;
          worst = std::max(
              worst, rotation_angle_rad(motion.at(t).q_inertial_from_body, other.at(t).q_inertial_from_body) / size);
        }
      }
    }
  }
  return worst * std::sqrt(3.0);  // a direction between the axes
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

}  // namespace

Plan plan_motion(const FreeBody& body, const Torques& torques, double first_s, double last_s, double accuracy_rad,
                 bool full) {
  if (!(accuracy_rad > 0.0)) {
    throw InputError(fmt::format("the accuracy is {}, a positive angle in radians is wanted", accuracy_rad));
  }
  if (!(first_s <= 0.0 && last_s >= 0.0 && std::isfinite(last_s - first_s))) {
    throw InputError(fmt::format("the span is {} s to {} s, a finite one that holds 0 is wanted", first_s, last_s));
  }
  Plan plan;
  const double momentum = body.momentum_body.norm();
  const double rate_rad_s = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
  plan.sensitivity = momentum > 0.0 ? free_sensitivity(body, first_s, last_s) : std::numeric_limits<double>::infinity();

  std::vector<std::size_t> by_size;
  for (const Torque& torque : torques.list()) {
    PlannedEffect effect;
    effect.name = torque_name(torque);
    if (momentum > 0.0) {
      const double impulse = largest_impulse(torque, body, first_s, last_s);
      effect.secular_rad = 2.0 * plan.sensitivity * impulse / momentum;
      const double span_s = std::max(last_s - first_s, 1e-300);
      effect.periodic_rad = impulse / span_s / (momentum * rate_rad_s);
    } else {
      effect.secular_rad = effect.periodic_rad = std::numeric_limits<double>::infinity();
    }
    by_size.push_back(plan.effects.size());
    plan.effects.push_back(std::move(effect));
  }
  std::sort(by_size.begin(), by_size.end(),
            [&](std::size_t a, std::size_t b) { return plan.effects[a].secular_rad < plan.effects[b].secular_rad; });
  std::vector<Torque> kept;
  for (const std::size_t i : by_size) {  // the smallest first, while they fit into half the accuracy
    PlannedEffect& effect = plan.effects[i];
    effect.kept = full || !(plan.dropped_rad + effect.secular_rad <= 0.5 * accuracy_rad);
    if (effect.kept) {
      effect.why = full ? "everything was asked for" : "its bound is above what is left of half the accuracy";
    } else {
      effect.why = "below half the accuracy, with all that is dropped";
      plan.dropped_rad += effect.secular_rad;
    }
  }
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (plan.effects[i].kept) kept.push_back(torques.list()[i]);
  }
  plan.kept = Torques(std::move(kept));
  if (plan.kept.empty()) {
    name_free_model(body, accuracy_rad, plan);
    plan.error_rad = plan.dropped_rad;
    return plan;
  }

  plan.tolerance_rad = full ? std::min(1e-9, 0.5 * accuracy_rad) : 0.5 * accuracy_rad;
  plan.error_rad = plan.dropped_rad + plan.tolerance_rad;
  // A trial over the first hundredth, but a few turns at least, tells the method and the cost.
  const double least_s = rate_rad_s > 0.0 ? 20.0 / rate_rad_s : last_s - first_s;
  const double share = std::min(1.0, std::max(0.01, least_s / std::max(last_s - first_s, 1e-300)));
  const TorquedMotion trial(body, plan.kept, {plan.tolerance_rad, share * first_s, share * last_s});
  plan.model = trial.method();
  plan.why = fmt::format("steps chosen for {:.1e} rad", plan.tolerance_rad);
  plan.torque_evaluations = static_cast<double>(trial.torque_evaluations()) / share;
  return plan;
}

std::unique_ptr<FreeMotion> planned_motion(const Plan& plan, const FreeBody& body, double first_s, double last_s) {
  if (plan.kept.empty()) return std::make_unique<ThetaMotion>(body);
  auto motion = std::make_unique<TorquedMotion>(body, plan.kept, TorquedOptions{plan.tolerance_rad, first_s, last_s});
  if (motion->outcome() != Outcome::done) {
    throw ComputationError(fmt::format("{}: the estimated error is {:.1e} rad, {:.1e} rad was planned",
                                       outcome_name(motion->outcome()), motion->error_rad(), plan.tolerance_rad));
  }
  return motion;
}

double phase_horizon_s(const FreeBody& body, double relative_period_uncertainty, double accuracy_rad) {
  const double rate_rad_s = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
  return accuracy_rad / (rate_rad_s * relative_period_uncertainty);
}

}  // namespace polhode
