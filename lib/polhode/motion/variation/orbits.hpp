#pragma once

#include <vector>

#include "polhode/motion/variation/window.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode::variation {

/// The trajectories of a body's torques, asked for at few times: in between polynomials through positions and
/// velocities (Hermite), each for as long as it holds, a few windows or many.
class Orbits {
 public:
  /// None is asked for a time beyond end_s.
  Orbits(const std::vector<Trajectory>& trajectories, double end_s, const Kernel& kernel)
      : trajectories_(trajectories), end_s_(end_s), kernel_(kernel) {}

  /// Makes polynomials from `from_s` on, at least to `to_s`, unless there are. They are off by no more than this part
  /// of the distance: through 7 times, or 13. Where not even these serve from the one to the other, as for a table with
  /// jumps in its derivatives, there are none.
  void cover(double from_s, double to_s, double relative);

  /// Positions and velocities at the times base_s + since_base_s, which were to be covered; without polynomials every
  /// one is asked for.
  void find(std::size_t trajectory, double base_s, const AtPoints& since_base_s, AtPoints* states);

  /// How often the trajectories were asked.
  std::size_t asked() const { return asked_; }

 private:
  static constexpr int kTimes = 12;  // intervals between them
  static constexpr int kTerms = 2 * (kTimes + 1);
  struct Series {
    double states[kTimes + 1][6];    // by time, the last first
    double coefficients[kTerms][6];  // of position and velocity, by degree
  };

  bool covers(double t_s) const { return (t_s - from_s_) * (t_s - to_s_) <= 0.0; }
  void interpolate(int times);
  double tail() const;
  double rounding() const;

  const std::vector<Trajectory>& trajectories_;
  double end_s_;
  const Kernel& kernel_;
  double from_s_ = 0.0, to_s_ = 0.0, wanted_s_ = 0.0;
  int terms_ = 0;
  bool resolved_ = false;
  Series series_[Torques::kMostTrajectories];
  std::size_t asked_ = 0;
};

}  // namespace polhode::variation
