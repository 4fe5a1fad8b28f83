#include <erfa.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

#include "polhode/time/scale_detail.hpp"

namespace polhode::detail {
namespace {

constexpr double day_s = 86400.0;
constexpr double piece_s = 8.0 * day_s;
constexpr int terms = 14;
using Piece = std::array<double, terms>;  // Chebyshev coefficients

double computed_s(double tt_s) { return eraDtdb(2451545.0, tt_s / day_s, 0.0, 0.0, 0.0, 0.0); }

Piece make_piece(double index) {
  Piece value{}, coefficients{};
  for (int j = 0; j < terms; ++j) {
    const double x = std::cos(std::numbers::pi * (j + 0.5) / terms);
    value[static_cast<std::size_t>(j)] = computed_s((index + 0.5 + 0.5 * x) * piece_s);
  }
  for (int k = 0; k < terms; ++k) {
    double sum = 0.0;
    for (int j = 0; j < terms; ++j) {
      sum += value[static_cast<std::size_t>(j)] * std::cos(std::numbers::pi * k * (j + 0.5) / terms);
    }
    coefficients[static_cast<std::size_t>(k)] = sum * (k == 0 ? 1.0 : 2.0) / terms;
  }
  return coefficients;
}

}  // namespace

double tdb_minus_tt_s(double tt_s) {
  constexpr double farthest_s = 1e13;  // beyond, eraDtdb means nothing, and pieces are too many to count
  if (!(std::abs(tt_s) < farthest_s)) return computed_s(tt_s);
  constexpr std::size_t most_pieces = 65536;  // 14 centuries, 10 MB
  thread_local std::unordered_map<std::int64_t, Piece> pieces;
  const double index = std::floor(tt_s / piece_s);
  const auto key = static_cast<std::int64_t>(index);
  auto found = pieces.find(key);
  if (found == pieces.end()) {
    if (pieces.size() == most_pieces) pieces.clear();
    found = pieces.emplace(key, make_piece(index)).first;
  }
  const Piece& coefficients = found->second;
  const double x = 2.0 * (tt_s / piece_s - index) - 1.0;
  double b1 = 0.0, b2 = 0.0;  // Clenshaw
  for (std::size_t k = terms - 1; k > 0; --k) {
    const double b0 = 2.0 * x * b1 - b2 + coefficients[k];
    b2 = b1;
    b1 = b0;
  }
  return x * b1 - b2 + coefficients[0];
}

}  // namespace polhode::detail
