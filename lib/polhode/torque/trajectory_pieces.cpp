#include "polhode/torque/trajectory_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace polhode {
namespace {

constexpr int kNodes = TrajectoryPieces::kDegree + 1;
constexpr double kSmall = 2e-15;  // of the last two coefficients of Chebyshev's series, to the distance

/// What takes the values at Chebyshev's nodes to the coefficients of his polynomials, and these to those of powers.
struct Bases {
  Eigen::Matrix<double, kNodes, kNodes> chebyshev_of_values, powers_of_chebyshev;
  std::array<double, kNodes> nodes;

  Bases() {
    powers_of_chebyshev.setZero();
    for (int i = 0; i < kNodes; ++i) {
      const double angle = std::numbers::pi * (i + 0.5) / kNodes;
      nodes[static_cast<std::size_t>(i)] = std::cos(angle);
      for (int n = 0; n < kNodes; ++n) chebyshev_of_values(n, i) = (n == 0 ? 1.0 : 2.0) / kNodes * std::cos(n * angle);
    }
    powers_of_chebyshev(0, 0) = powers_of_chebyshev(1, 1) = 1.0;
    for (int n = 2; n < kNodes; ++n) {
      powers_of_chebyshev.col(n).tail(kNodes - 1) = 2.0 * powers_of_chebyshev.col(n - 1).head(kNodes - 1);
      powers_of_chebyshev.col(n) -= powers_of_chebyshev.col(n - 2);
    }
  }
};

const Bases& bases() {
  static const Bases all;
  return all;
}

}  // namespace

bool TrajectoryPieces::fit(double from_s, double to_s, Piece& piece) const {
  const Bases& b = bases();
  piece.middle_s = 0.5 * (from_s + to_s);
  const double half_s = 0.5 * (to_s - from_s);
  piece.per_half = 1.0 / half_s;
  Eigen::Matrix<double, kNodes, 6> values;
  for (int i = 0; i < kNodes; ++i) {
    const OrbitState<double> state =
        trajectory_.state(piece.middle_s + half_s * b.nodes[static_cast<std::size_t>(i)]);
    values.row(i) << state.position_m.transpose(), state.velocity_m_s.transpose();
  }
  const Eigen::Matrix<double, kNodes, 6> chebyshev = b.chebyshev_of_values * values;
  const auto tail = chebyshev.bottomRows(2).cwiseAbs();
  const double distance_m = values.leftCols(3).rowwise().norm().minCoeff();
  const double speed_m_s = values.rightCols(3).rowwise().norm().maxCoeff();
  const double rounding_s = std::numeric_limits<double>::epsilon() * (std::abs(from_s) + std::abs(to_s));
  const double small = kSmall + rounding_s * speed_m_s / distance_m;
  const bool good = tail.leftCols(3).maxCoeff() <= small * distance_m && tail.rightCols(3).maxCoeff() <= small * speed_m_s;
  const Eigen::Matrix<double, kNodes, 6> powers = b.powers_of_chebyshev * chebyshev;
  for (int n = 0; n < kNodes; ++n) piece.coefficients[n] = powers.row(n).transpose();
  return good;
}

TrajectoryPieces::TrajectoryPieces(const Trajectory& trajectory, double first_s, double last_s)
    : trajectory_(trajectory) {
  if (trajectory.orbit() == nullptr || !(last_s > first_s)) return;
  double from_s = first_s, length_s = last_s - first_s;
  while (from_s < last_s) {
    const OrbitState<double> state = trajectory.state(from_s);
    length_s = std::min({length_s, last_s - from_s, 3.0 * state.position_m.norm() / state.velocity_m_s.norm()});
    if ((last_s - from_s) / length_s > 4.0 * kMostPieces) break;
    Piece piece;
    const double least_s = 1e-3 * length_s;
    while (!fit(from_s, from_s + length_s, piece) && length_s > least_s) length_s *= 0.8;
    if (!(length_s > least_s) || !(from_s + length_s > from_s) || pieces_.size() == kMostPieces) break;
    from_s = length_s >= last_s - from_s ? last_s : from_s + length_s;
    ends_s_.push_back(from_s);
    pieces_.push_back(piece);
    length_s *= 1.2;
  }
  if (from_s < last_s) pieces_.clear(), ends_s_.clear();
}

OrbitState<double> TrajectoryPieces::state(double t_s, std::size_t& piece) const {
  if (pieces_.empty()) return trajectory_.state(t_s);
  const std::size_t last = pieces_.size() - 1;
  if (piece > last || t_s > ends_s_[piece] || (piece > 0 && t_s < ends_s_[piece - 1])) {
    piece = std::min(last, static_cast<std::size_t>(std::lower_bound(ends_s_.begin(), ends_s_.end(), t_s) -
                                                    ends_s_.begin()));
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
