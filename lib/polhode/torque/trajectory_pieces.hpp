#pragma once

#include <cstddef>
#include <vector>

#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// A Kepler orbit over a span as polynomials in time, piece by piece: its states to a few roundings, for less than a
/// tenth of the time that its equation takes to solve. A table, or an orbit of very many turns, is asked itself.
class TrajectoryPieces {
 public:
  static constexpr int kDegree = 13;
  static constexpr std::size_t kMostPieces = 50'000;

  TrajectoryPieces(const Trajectory& trajectory, double first_s, double last_s);

  /// Also a little beyond the span. `piece` is where to look first, and where it was found.
  OrbitState<double> state(double t_s, std::size_t& piece) const;

 private:
  using Values = Eigen::Array<double, 6, 1>;  // position, velocity
  struct Piece {
    double middle_s, per_half;  // of 1 / half its length
    Values coefficients[kDegree + 1];
  };
  bool fit(double from_s, double to_s, Piece& piece) const;

  Trajectory trajectory_;
  std::vector<double> ends_s_;  // of the pieces
  std::vector<Piece> pieces_;   // none: the trajectory itself
};

}  // namespace polhode
