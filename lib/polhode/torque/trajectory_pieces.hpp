#pragma once

#include <cstddef>
#include <vector>

#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// A Kepler orbit over a span as polynomials in time, piece by piece: its states within 1e-15 of distance and speed
/// (made from long double, they hold where a double of the time since periapsis no longer does), for a fifth of the
/// time that its equation takes to solve. A table, or an orbit that needs more pieces than allowed, is asked itself.
class TrajectoryPieces {
 public:
  static constexpr int kDegree = 13;
  /// What a piece costs, in solutions of Kepler's equation.
  static constexpr double kCost = 80.0;

  TrajectoryPieces(const Trajectory& trajectory, double first_s, double last_s, std::size_t most = 50'000);

  /// Also a little beyond the span. `piece` is where to look first, and where it was found.
  OrbitState<double> state(double t_s, std::size_t& piece) const;

  std::size_t pieces() const { return pieces_.size(); }

 private:
  using Values = Eigen::Array<double, 6, 1>;  // position, velocity
  struct Piece {
    double middle_s, per_half;  // of 1 / half its length
    Values coefficients[kDegree + 1];
  };
  /// Returns how large the last coefficients are, beside the distance or speed.
  double fit(double from_s, double to_s, Piece& piece) const;

  Trajectory trajectory_;
  std::vector<double> ends_s_;  // of the pieces
  std::vector<Piece> pieces_;   // none: the trajectory itself
};

}  // namespace polhode
