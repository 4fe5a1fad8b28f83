#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "polhode/motion/propagated_motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// The motion of a rigid body under torques of which nothing but values is known (facets in sunlight, say), by steps of
/// Dormand and Prince's method of order 8 (values/dormand_prince.hpp), from t = 0 both ways. Unknowns are the angular
/// momentum in inertial axes and the attitude, and where the torques are small beside the inertia forces what takes the
/// place of the energy, to which the attitude is set after every step: slow ones, so that errors of a step add up in
/// the phase, but not in the rate.
///
/// Every run chooses its steps by the estimate of their error. The span is run again with finer steps, from a start a
/// rounding aside, until two runs agree well enough: error_rad() is what their difference leaves to fear of the finer
/// one, which is kept (values/builder.hpp has the figures). Where the torques have kinks (Torques::smooth()), at which
/// no order of a method holds, error_rad() is the difference where the steps are corrected for them (few facets), and
/// twice that else.
class ValueMotion final : public PropagatedMotion {
 public:
  using Options = PropagationOptions;
  /// Torques in principal axes.
  ValueMotion(const FreeBody& body, const Torques& torques, const Options& options);

  /// Throws InputError for a time beyond what was propagated by more than end_room_s(); NaN gives NaN.
  State at(double t_high_s, double t_low_s = 0.0) const override;
  /// Where times ascend, or several lie in a step, much faster than one by one; the same bits.
  void batch(const TimeArrays& times, const StateArrays& out) const override;
  /// By differences of each step's end from starts and parameters a little to either side: within some 1e-8 of a
  /// column's size; where torques have kinks, as far as a step's end is smooth.
  std::unique_ptr<const Partials> partials(const FreeBody& body, const Torques& torques_named,
                                           std::span<const TorqueParameter> parameters) const override;

 private:
  struct Node;                    // a step's end
  struct Leg;                     // between two jumps of the torques, away from t = 0
  using Path = std::vector<Leg>;  // one direction
  class Rates;
  class Builder;
  struct Place {
    const Leg* leg = nullptr;
    std::size_t step = 0;
    bool operator==(const Place&) const = default;
  };
  class Step;
  class ValuePartials;
  Place place(double t_s, const Place& before) const;

  Vector3 moments_;
  std::shared_ptr<const Path> forward_, backward_;
};

}  // namespace polhode
