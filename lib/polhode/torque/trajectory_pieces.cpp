#include "polhode/torque/trajectory_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace polhode {
namespace {

constexpr int kNodes = TrajectoryPieces::kDegree + 1;
constexpr double kSmall = 3e-16;  // of the last two coefficients of Chebyshev's series, to the distance or speed

using Extended = long double;
using Square = Eigen::Matrix<Extended, kNodes, kNodes>;

/// What takes the values at Chebyshev's nodes to the coefficients of his polynomials, and these to those of powers.
struct Bases {
  Square chebyshev_of_values, powers_of_chebyshev;
  std::array<Extended, kNodes> nodes;

  Bases() {
    powers_of_chebyshev.setZero();
    for (int i = 0; i < kNodes; ++i) {
      const Extended angle = std::numbers::pi_v<Extended> * (i + Extended(0.5)) / kNodes;
      nodes[static_cast<std::size_t>(i)] = std::cos(angle);
      for (int n = 0; n < kNodes; ++n) {
        chebyshev_of_values(n, i) = Extended(n == 0 ? 1 : 2) / kNodes * std::cos(n * angle);
      }
    }
    powers_of_chebyshev(0, 0) = powers_of_chebyshev(1, 1) = 1;
    for (int n = 2; n < kNodes; ++n) {
      powers_of_chebyshev.col(n).tail(kNodes - 1) = 2 * powers_of_chebyshev.col(n - 1).head(kNodes - 1);
      powers_of_chebyshev.col(n) -= powers_of_chebyshev.col(n - 2);
    }
  }
};

const Bases& bases() {
  static const Bases all;
  return all;
}

}  // namespace

double TrajectoryPieces::fit(double from_s, double to_s, Piece& piece) const {
  const Bases& b = bases();
  piece.middle_s = 0.5 * (from_s + to_s);
  const double half_s = std::max(to_s - piece.middle_s, piece.middle_s - from_s);
  piece.per_half = 1.0 / half_s;
  Eigen::Matrix<Extended, kNodes, 6> values;
  for (int i = 0; i < kNodes; ++i) {
    const OrbitState<Extended> state =
        trajectory_.state(piece.middle_s + half_s * b.nodes[static_cast<std::size_t>(i)]);
    values.row(i) << state.position_m.transpose(), state.velocity_m_s.transpose();
  }
  const Eigen::Matrix<Extended, kNodes, 6> chebyshev = b.chebyshev_of_values * values;
  const Eigen::Matrix<Extended, kNodes, 6> powers = b.powers_of_chebyshev * chebyshev;
  for (int n = 0; n < kNodes; ++n) piece.coefficients[n] = powers.row(n).cast<double>().transpose();
  const auto tail = chebyshev.bottomRows(2).cwiseAbs();
  return static_cast<double>(std::max(tail.leftCols(3).maxCoeff() / values.leftCols(3).rowwise().norm().minCoeff(),
                                      tail.rightCols(3).maxCoeff() / values.rightCols(3).rowwise().norm().minCoeff()));
}

TrajectoryPieces::TrajectoryPieces(const Trajectory& trajectory, double first_s, double last_s, std::size_t most)
    : trajectory_(trajectory) {
  if (trajectory.orbit() == nullptr) return;
  double from_s = first_s, longest_s = last_s - first_s;
  while (from_s < last_s && pieces_.size() < most) {
    const OrbitState<double> state = trajectory.state(from_s);
    const double rest_s = last_s - from_s;
    double length_s = std::min({longest_s, rest_s, 2.0 * state.position_m.norm() / state.velocity_m_s.norm()});
    if (!(rest_s < 4.0 * static_cast<double>(most) * length_s)) break;
    Piece piece;
    double tail = fit(from_s, from_s + length_s, piece);
    const auto other_length = [&tail] { return 0.95 * std::pow(kSmall / std::max(tail, 1e-30), 1.0 / kDegree); };
    for (int i = 0; tail > kSmall && i < 20; ++i) {
      length_s *= std::clamp(other_length(), 0.3, 0.9);
      tail = fit(from_s, from_s + length_s, piece);
    }
    if (!(tail <= kSmall)) break;
    from_s = length_s == rest_s ? last_s : from_s + length_s;
    ends_s_.push_back(from_s);
    pieces_.push_back(piece);
    longest_s = length_s * std::clamp(other_length(), 0.9, 1.5);
    // No sliver at the end.
    if (longest_s < last_s - from_s && longest_s > 0.5 * (last_s - from_s)) longest_s = 0.5 * (last_s - from_s);
  }
  if (from_s < last_s) pieces_.clear(), ends_s_.clear();
}

OrbitState<double> TrajectoryPieces::state(double t_s, std::size_t& piece) const {
  if (pieces_.empty()) return trajectory_.state(t_s);
  const std::size_t last = pieces_.size() - 1;
  if (piece > last || t_s > ends_s_[piece] || (piece > 0 && t_s < ends_s_[piece - 1])) {
    piece = std::min(last,
                     static_cast<std::size_t>(std::lower_bound(ends_s_.begin(), ends_s_.end(), t_s) - ends_s_.begin()));
  }
  const Piece& p = pieces_[piece];
  const double x = (t_s - p.middle_s) * p.per_half, x2 = x * x;
  Values even = p.coefficients[kDegree - 1], odd = p.coefficients[kDegree];
  for (int n = kDegree - 3; n >= 0; n -= 2) {
    even = even * x2 + p.coefficients[n];
    odd = odd * x2 + p.coefficients[n + 1];
  }
  even += x * odd;
  return {even.head<3>(), even.tail<3>()};
}

}  // namespace polhode
