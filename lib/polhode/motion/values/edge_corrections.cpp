#include "polhode/motion/values/edge_corrections.hpp"

#include <algorithm>
#include <cmath>

namespace polhode {
namespace {

namespace dp = dormand_prince;
using Five = Eigen::Matrix<double, 5, 1>;

/// The coefficients of powers of the polynomial that has these values at 0, 1/4, 1/2, 3/4, 1.
Eigen::Matrix<double, 5, 5> powers_of_values() {
  Eigen::Matrix<double, 5, 5> m;
  m << 3, 0, 0, 0, 0, -25, 48, -36, 16, -3, 70, -208, 228, -112, 22, -80, 288, -384, 224, -48, 32, -128, 192, -128, 32;
  return m / 3.0;
}

/// Gauss's five points and weights on 0 to 1.
constexpr double kPoints[5] = {0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155, 0.95308992296933200};
constexpr double kWeights[5] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
                                0.11846344252809454};

double value(const Five& p, double x) { return p[0] + x * (p[1] + x * (p[2] + x * (p[3] + x * p[4]))); }

/// One part of the torque: a cosine, and the derivatives of unknowns per cosine.
struct Part {
  Five cosine;
  Eigen::Matrix<double, 5, 4> per_cosine;  // of powers

  Eigen::Array4d rate(double x) const {
    const double x2 = x * x;
    const Five powers(1.0, x, x2, x2 * x, x2 * x2);
    return value(cosine, x) * (per_cosine.transpose() * powers).array();
  }
  /// Where the cosine is 0, between two places where its signs are different.
  double root() const {
    double low = 0.0, high = 1.0;
    const bool is_lit_first = cosine[0] > 0.0;
    double x = cosine[0] / (cosine[0] - value(cosine, 1.0));
    for (int i = 0; i < 30; ++i) {
      const double c = value(cosine, x);
      ((c > 0.0) == is_lit_first ? low : high) = x;
      const double slope = cosine[1] + x * (2.0 * cosine[2] + x * (3.0 * cosine[3] + x * 4.0 * cosine[4]));
      double next = x - c / slope;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      const bool done = std::abs(next - x) < 1e-10;
      x = next;
      if (done) break;
    }
    return x;
  }
};

}  // namespace

bool EdgeCorrections::find(const std::array<std::vector<Torques::Edge>, 5>& edges,
                           const std::array<Eigen::Matrix<double, 4, 3>, 5>& columns, double h) {
  static const Eigen::Matrix<double, 5, 5> from_values = powers_of_values();
  increment.setZero(), fifth.setZero(), third.setZero();
  bool found = false;
  for (std::size_t e = 0; e < edges[0].size(); ++e) {
    const bool is_lit_first = edges[0][e].cosine > 0.0;
    if (is_lit_first == (edges[4][e].cosine > 0.0)) continue;
    found = true;
    Five cosines;
    Eigen::Matrix<double, 5, 4> per_cosine;
    for (std::size_t i = 0; i < 5; ++i) {
      cosines[static_cast<Eigen::Index>(i)] = edges[i][e].cosine;
      per_cosine.row(static_cast<Eigen::Index>(i)) = (columns[i] * edges[i][e].torque_per_cosine).transpose();
    }
    const Part part{from_values * cosines, from_values * per_cosine};
    const double x = part.root();
    const double from = is_lit_first ? 0.0 : x, length = is_lit_first ? x : 1.0 - x;
    Eigen::Array4d whole = Eigen::Array4d::Zero();
    for (int i = 0; i < 5; ++i) whole += kWeights[i] * part.rate(from + length * kPoints[i]);
    increment.head<4>() += length * whole;
    for (std::size_t i = 0; i < dp::kStages; ++i) {
      const double at = dp::kAbscissae[i], weight = dp::kWeights[dp::kStages][i];
      if ((at < x) != is_lit_first || (weight == 0.0 && dp::kFifthOrderError[i] == 0.0)) continue;
      const Eigen::Array4d rate = part.rate(at);
      increment.head<4>() -= weight * rate;
      fifth.head<4>() -= dp::kFifthOrderError[i] * rate;
      third.head<4>() -= (weight - dp::kThirdOrder[i]) * rate;
    }
  }
  increment *= h;
  return found;
}

}  // namespace polhode
