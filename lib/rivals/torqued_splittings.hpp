#pragma once

#include <cmath>
#include <limits>

#include "polhode/motion/splitting.hpp"
#include "rivals/fixed_step.hpp"

namespace polhode::rivals {

/// A splitting between kicks of the torque and steps of a free method: as SplittingRun, with another kernel than the
/// exact motion. A drift is as many equal steps of the kernel as make them no longer than Forcing::free_step; the last
/// drift of a step and the first of the next are one.
template <class Kernel>
class KernelSplitting {
 public:
  KernelSplitting(const Problem& problem, double start, const ScaledState<double>&, double step)
      : problem_(problem), forcing_(*problem.forcing), start_(start), step_(step) {
    const SplittingScheme& scheme = *forcing_.scheme;
    for (std::size_t i = 0; i <= scheme.kicks; ++i) free_steps_ += parts(scheme.drift(i) * step);
  }

  void advance(ScaledState<double>& y, std::int64_t steps) {
    // A step of the free method costs less than a torque, but more than a fifth of it.
    if (5.0 * static_cast<double>(problem_.max_evaluations) < free_steps_ * static_cast<double>(steps)) {
      y.m[0] = y.q[0] = std::numeric_limits<double>::quiet_NaN();
      return;
    }
    const SplittingScheme& scheme = *forcing_.scheme;
    double pending = 0.0;
    for (std::int64_t n = 0; n < steps; ++n) {
      double drifted = 0.0;
      for (std::size_t i = 0; i < scheme.kicks; ++i) {
        drifted += scheme.drift(i);
        drift(y, pending + scheme.drift(i) * step_);
        kick(y, start_ + (static_cast<double>(taken_ + n) + drifted) * step_, scheme.kick(i) * step_);
        pending = 0.0;
      }
      pending = scheme.drift(scheme.kicks) * step_;
    }
    drift(y, pending);
    taken_ += steps;
    evaluations += static_cast<std::int64_t>(scheme.kicks) * steps;
  }

  std::int64_t evaluations = 0;  ///< torques

 private:
  double parts(double length) const { return std::max(1.0, std::ceil(std::abs(length) / forcing_.free_step - 1e-9)); }

  void drift(ScaledState<double>& y, double length) const {
    const double n = parts(length);
    Kernel(problem_.body, y, length / n).advance(y, static_cast<std::int64_t>(n));
  }

  void kick(ScaledState<double>& y, double t, double length) const {
    FreeBody body{forcing_.principal_moments, {y.q[0], y.q[1], y.q[2], y.q[3]}, {y.m[0], y.m[1], y.m[2]}};
    body.momentum_body *= forcing_.momentum;
    apply_kick(body, forcing_.start_s + t * forcing_.time_unit_s, length * forcing_.time_unit_s, forcing_.torques);
    const Eigen::Vector4d q = scalar_first(body.q_inertial_from_body);
    for (int i = 0; i < 4; ++i) y.q[i] = q[i];
    for (int i = 0; i < 3; ++i) y.m[i] = body.momentum_body[i] / forcing_.momentum;
  }

  const Problem& problem_;
  const Forcing& forcing_;
  double start_, step_;
  double free_steps_ = 0.0;  // of the kernel per step, about
  std::int64_t taken_ = 0;   // steps
};

/// Our own SplittingRun at a fixed step, in the form of the others.
class ExactSplitting {
 public:
  ExactSplitting(const Problem& problem, double start, const ScaledState<double>& y, double step)
      : forcing_(*problem.forcing),
        step_s_(step * forcing_.time_unit_s),
        run_({forcing_.principal_moments,
              {y.q[0], y.q[1], y.q[2], y.q[3]},
              forcing_.momentum * Vector3(y.m[0], y.m[1], y.m[2])},
             forcing_.start_s + start * forcing_.time_unit_s, forcing_.torques, *forcing_.scheme) {}

  void advance(ScaledState<double>& y, std::int64_t steps) {
    for (std::int64_t n = 0; n < steps; ++n) run_.step(step_s_);
    const State state = run_.state();
    const Eigen::Vector4d q = scalar_first(state.q_inertial_from_body);
    for (int i = 0; i < 4; ++i) y.q[i] = q[i];
    for (int i = 0; i < 3; ++i) y.m[i] = state.momentum_body[i] / forcing_.momentum;
    evaluations = static_cast<std::int64_t>(run_.torque_evaluations());
  }

  std::int64_t evaluations = 0;  ///< torques

 private:
  const Forcing& forcing_;
  double step_s_;
  SplittingRun run_;
};

}  // namespace polhode::rivals
