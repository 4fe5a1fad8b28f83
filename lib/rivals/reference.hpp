#pragma once

#include <vector>

#include "polhode/motion/motion.hpp"
#include "rivals/state.hpp"
#include "rivals/taylor.hpp"

namespace polhode::rivals {

/// A free body in quadruple precision: I1, I2, I3, q0..q3, m1..m3.
struct QuadrupleBody {
  Quadruple moments[3];
  Quadruple q[4];
  Quadruple m[3];
};

QuadrupleBody in_quadruple(const FreeBody& body);

/// The answer that the methods are measured against: Taylor's method of order about 40 in quadruple precision. It knows
/// no elliptic or theta function. Where the momentum repeats within the span, half a period is integrated and the rest
/// follows from the turn that it makes, so a billion turns cost no more than one.
/// Error about 1e-32 times the condition number. On the separatrix itself, where rounding grows exponentially, the
/// answer becomes NaN once nothing is left of it.
class QuadrupleReference {
 public:
  /// Good for instants from t_min_s to t_max_s, t_min_s <= 0 <= t_max_s. `tolerance` is that of Taylor's method. Throws
  /// InputError for another span, a tolerance that is not positive, and what checked() refuses.
  QuadrupleReference(const QuadrupleBody& body, double t_min_s, double t_max_s, double tolerance = 1e-33);

  /// Unit quaternion and momentum in units of |m|.
  ScaledState<Quadruple> at(double t_s) const;

 private:
  struct Segment {
    Quadruple start;
    Taylor<Quadruple> series;
  };

  ScaledState<Quadruple> without_common_turn(Quadruple tau) const;

  Quadruple time_unit_ = 0;         // I2 / |m|
  bool constant_momentum_ = false;  // rest, a sphere, or rotation about an axis
  ScaledState<Quadruple> start_;
  Quadruple rotation_[3] = {};     // angular velocity of a constant momentum
  std::vector<Segment> segments_;  // ascending in start
  bool periodic_ = false;          // the momentum passes m2 = 0 at begin_ and end_, half a period apart
  Quadruple begin_ = 0, end_ = 0;
  Quadruple covered_from_ = 0, covered_to_ = 0;
  Quadruple turn_[4];  // of half a period, in inertial axes
  int axis_ = 0;       // about which the body flips in half a period
};

/// The condition number of the state at each time: the response, in radians and in units of |m|, to relative changes
/// of the ten inputs, summed over the inputs, from differences of references. Saturates near 1e18.
std::vector<double> condition_numbers(const FreeBody& body, const std::vector<double>& times_s);

}  // namespace polhode::rivals
