#pragma once

#include <cstddef>
#include <vector>

#include "polhode/motion/propagated_motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode::rivals {

/// The motion under torques in long double, to check the library's engines: Gragg's modified midpoint rule with
/// polynomial extrapolation in the square of the step, order 16 in 97 evaluations (Hairer, Norsett & Wanner, Solving
/// ODEs I, section II.9). It has nothing in common with them but the torques.
///
/// Steps are chosen by an estimate of their error. The whole span is then done again at half the steps, until two such
/// runs agree; error_rad() is a tenth of their largest difference (the finer one is kept, whose error is smaller
/// still), and four times the difference where the torques have kinks. A state between the ends of steps is a shorter
/// step from the last end.
class ExtrapolatedMotion final : public PropagatedMotion {
 public:
  using Options = PropagationOptions;
  /// Torques are in the axes of body.named_from_principal.
  ExtrapolatedMotion(const FreeBody& body, const Torques& torques, const Options& options);

  /// Throws InputError for a time outside of what was propagated; NaN gives NaN.
  State at(double t_high_s, double t_low_s = 0.0) const override;

 private:
  using Vector = Vector3Of<long double>;
  struct Place {
    Eigen::Quaternion<long double> q_inertial_from_body;
    Vector momentum_body;
  };
  struct Node {
    double t_s;
    Place place;
  };
  /// Between two jumps of the torques, away from t = 0.
  struct Leg {
    Torques torques;
    std::vector<Node> nodes;
  };
  using Path = std::vector<Leg>;  // one direction
  class Method;                   // of one step

  Place stepped(const Leg& leg, const Node& from, long double length_s, double* error);
  bool choose_steps(Path& path, double local_tolerance_rad);
  bool halve(const Path& coarse, Path& fine);

  Vector3 moments_;
  Place start_;
  std::size_t most_evaluations_;
  Path forward_, backward_;
};

}  // namespace polhode::rivals
