#pragma once

#include <memory>
#include <vector>

#include "polhode/motion/propagated_motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// The motion of a rigid body under torques that have power series, by steps of these series (series_motion.md), from t
/// = 0 both ways. Every step carries along, to first order, how far the run is from the motion: what earlier steps left
/// out of their series, and their roundings. error_rad() is that distance, at its largest, times a safety factor.
/// evaluations() are coefficients of series: the orders of all steps.
class SeriesMotion final : public PropagatedMotion {
 public:
  /// Whether it serves for these torques.
  static bool serves(const Torques& torques);

  using Options = PropagationOptions;
  /// Torques in principal axes.
  SeriesMotion(const FreeBody& body, const Torques& torques, const Options& options);

  /// The first time that it is asked within a step, the step's series is computed, and kept if there is room (64 MB).
  State at(double t_high_s, double t_low_s = 0.0) const override;
  void batch(const TimeArrays& times, const StateArrays& out) const override;
  /// By the equations of a small change of the motion, in series of the same orders as the steps (series_partials.cpp).
  std::unique_ptr<const Partials> partials(const FreeBody& body, const Torques& torques_named,
                                           std::span<const TorqueParameter> parameters) const override;

 private:
  struct Leg;        // between two jumps of the torques
  struct Place;      // a step of a leg
  struct Series;     // of the state about the start of a step
  struct Expansion;  // a step and its series
  struct Memory;     // of series
  class SeriesPartials;
  class Builder;
  Place place(double t_s) const;
  bool is_in(const Place& place, double t_s) const;
  static Quaternion q_at_start(const Place& place);
  void expand(const Place& place, Series& series) const;
  State state(const Expansion& expansion, double t_high_s, double t_low_s) const;

  Vector3 moments_;
  std::shared_ptr<const std::vector<Leg>> forward_, backward_;  // away from t = 0
  std::shared_ptr<Memory> memory_;
};

}  // namespace polhode
