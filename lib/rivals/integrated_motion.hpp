#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "polhode/motion/motion.hpp"
#include "polhode/motion/splitting.hpp"
#include "polhode/torque/torques.hpp"
#include "rivals/state.hpp"
#include "rivals/step_control.hpp"

namespace polhode::rivals {

/// Torques, and what leads from a body's own units to the user's.
struct Forcing {
  Torques torques;            ///< without jumps
  Vector3 principal_moments;  ///< user's unit
  double momentum;            ///< |m| at t = 0, user's unit
  double time_unit_s;
  double start_s;  ///< on the torques' clock, where the problem's time is 0
  // Of kicks between steps of a free method.
  const SplittingScheme* scheme = nullptr;
  double free_step = 0.0;  ///< longest of the free method
};

/// A body in its own units, |m| = 1 and I2 = 1 (at t = 0), so that no method is troubled by the user's.
struct Problem {
  InverseMoments<double> body;
  ScaledState<double> start;
  double step = 0.0;
  double tolerance = 0.0;
  std::int64_t max_evaluations = 0;
  const Forcing* forcing = nullptr;  ///< null: free
};

/// Advances from time 0 through `times`, which move away from 0 in one direction; fills as many states, with NaN from
/// where the method cannot go on. Returns the number of evaluations of the right-hand side or of an exact part; more
/// than permitted means that the span was too long. Under torques the evaluations are those of the torques.
using Run = std::int64_t (*)(const Problem& problem, std::span<const double> times, ScaledState<double>* out);

/// A motion that an integrator answers: at() integrates from t = 0, batch() passes once through the sorted times.
class IntegratedMotion final : public Motion {
 public:
  IntegratedMotion(const FreeBody& body, const StepControl& control, Run run);
  /// Under torques, for a `run` that knows them; at rest at t = 0 there are no units of its own, and no answer but NaN.
  /// `scheme` is for the runs of kicked.hpp.
  IntegratedMotion(const FreeBody& body, const Torques& torques, const StepControl& control, Run run,
                   const SplittingScheme* scheme = nullptr);

  State at(double t_high_s, double t_low_s = 0.0) const override;
  void batch(const TimeArrays& times, const StateArrays& out) const override { integrate(times, out); }

  /// batch(), and the number of evaluations that it took; more than permitted where it gave up for that.
  std::int64_t integrate(const TimeArrays& times, const StateArrays& out) const;

 private:
  std::int64_t advance(std::span<const double> times, ScaledState<double>* out) const;

  Problem problem_;
  std::optional<Forcing> forcing_;
  Run run_;
  double momentum_;   ///< |m| in the user's unit
  double time_unit_;  ///< I2 / |m|, s
};

}  // namespace polhode::rivals
