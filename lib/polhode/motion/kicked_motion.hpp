#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "polhode/motion/motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

struct KickedOptions {
  double tolerance_rad = 0.0;          ///< wanted error of the attitude, worst of the span
  double first_s = 0.0, last_s = 0.0;  ///< the span, which holds t = 0
  std::size_t max_torque_evaluations = 100'000'000;
};

/// The motion of many turns under torques that are weak beside the inertia forces, to a low accuracy at a few torque
/// evaluations per turn: Strang's splitting (exact free motion between kicks) at steps of up to a seventh of a turn.
///
/// Such a run follows a motion close to the true one, displaced by a swing of the size of torque/(momentum x rate), and
/// an initial state that is off by this swing has other mean rates: that, not the step, ruins a plain run with few
/// kicks. Here the first steps are short and grow over thirty turns so smoothly that the mean motion (the adiabatic
/// invariants) is taken along; what is left is the second-order difference of the mean rates. It is measured: the whole
/// span is run at steps 1.6 times as long too, and the largest angle between the two runs is the error of the finer
/// one, which is kept. The step is chosen by a trial of a hundred turns at the start.
///
/// A state is exact free motion from the middle between two kicks: rows cost no torque evaluations.
class KickedMotion final : public Motion {
 public:
  /// Nothing where the span has too few turns, the surroundings change too fast, the motion is too near the separatrix,
  /// a torque jumps, or the tolerance is not met, or not within the limit of evaluations: another method is then
  /// needed. What was spent in vain is added to `in_vain`. Torques are in the axes of
  /// body.named_from_principal. Throws InputError for what checked() refuses, a span without 0, a tolerance that is not
  /// positive and finite.
  static std::unique_ptr<const KickedMotion> make(const FreeBody& body, const Torques& torques,
                                                  const KickedOptions& options, std::size_t* in_vain = nullptr);

  /// Torque evaluations that make() would take, from a trial at the start; nothing as for make().
  static std::optional<double> predicted_evaluations(const FreeBody& body, const Torques& torques,
                                                     const KickedOptions& options);

  /// Throws InputError for a time outside of the span by more than end_room_s(); NaN gives NaN.
  State at(double t_high_s, double t_low_s = 0.0) const override;

  double error_rad() const { return error_rad_; }                  ///< estimated, worst of the span
  std::size_t torque_evaluations() const { return evaluations_; }  ///< of all runs, trials included
  MotionAccount account() const;                                   ///< what ran; the tolerance is promised

 private:
  /// Half way between two kicks.
  struct Node {
    double t_s;
    State state;
  };
  class Runner;

  KickedMotion(const FreeBody& body, const KickedOptions& options)
      : moments_(body.principal_moments), options_(options) {}
  static std::unique_ptr<const KickedMotion> make(const FreeBody& body, const KickedOptions& options, Runner& runner);
  /// The longest step whose error at the end of the span is within the tolerance, by a trial at the start; or nothing.
  static std::optional<double> chosen_step_rad(const FreeBody& body, const KickedOptions& options, Runner& runner);
  /// Fills the nodes; false where the motion leaves what the method is for.
  bool run(const FreeBody& body, double step_rad, Runner& runner);
  std::size_t nearest(double t_s) const;

  Vector3 moments_;
  KickedOptions options_;
  std::vector<Node> nodes_;  // ascending
  double error_rad_ = 0.0;
  std::size_t evaluations_ = 0;
};

}  // namespace polhode
