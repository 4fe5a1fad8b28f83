#include "polhode/ephemeris/row_spacing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/error_budget.hpp"
#include "polhode/body/inertia.hpp"

namespace polhode {
namespace {

constexpr std::array places{0.25, 0.5, 0.75};  // within a gap; the errors peak near its middle

/// Rows of which an interpolation takes `count`, at positions 0, 1, …; the gap that is looked at begins at `gap`.
struct Window {
  int count;
  int gap;
};

Quaternion great_circle(const Quaternion& a, const Quaternion& b, double part) {
  const Quaternion turn = a.conjugate() * b;
  const double sine = turn.vec().norm();
  const double half = std::atan2(sine, turn.w());
  const double scale = sine > 0.0 ? std::sin(part * half) / sine : 0.0;
  Quaternion partial;
  partial.w() = std::cos(part * half);
  partial.vec() = scale * turn.vec();
  return a * partial;
}

Quaternion lagrange(std::span<const Quaternion> rows, double position) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < rows.size(); ++j) {
      if (j != i) {
        weight *= (position - static_cast<double>(j)) / (static_cast<double>(i) - static_cast<double>(j));
      }
    }
    sum += weight * rows[i].coeffs();
  }
  return Quaternion(sum).normalized();
}

/// Measures the error of an interpolation between rows.
class Gauge {
 public:
  Gauge(const PrincipalMotion& motion, RowInterpolation interpolation)
      : motion_(motion), interpolation_(interpolation) {}

  /// Largest error in a gap; the window's first row is at begin_s, rows are step_s apart.
  double error_rad(double begin_s, double step_s, Window window) {
    const auto rows = static_cast<std::size_t>(window.count);
    times_.clear();
    for (std::size_t i = 0; i < rows; ++i) times_.push_back(begin_s + static_cast<double>(i) * step_s);
    for (const double place : places) times_.push_back(begin_s + (window.gap + place) * step_s);
    low_.assign(times_.size(), 0.0);
    q_.resize(4 * times_.size());
    m_.resize(3 * times_.size());
    motion_(times_, low_, q_.data(), m_.data());
    attitudes_.clear();
    for (std::size_t i = 0; i < times_.size(); ++i) {
      attitudes_.push_back(from_scalar_first(Eigen::Map<const Eigen::Vector4d>(&q_[4 * i])));
    }
    double worst = 0.0;
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Quaternion between = interpolation_ == RowInterpolation::great_circle
                                     ? great_circle(attitudes_[0], attitudes_[1], places[k])
                                     : lagrange({attitudes_.data(), rows}, window.gap + places[k]);
      const double error = rotation_angle_rad(between, attitudes_[rows + k]);
      if (!(error <= worst)) worst = error;  // keeps a NaN
    }
    return worst;
  }

 private:
  const PrincipalMotion& motion_;
  RowInterpolation interpolation_;
  std::vector<double> times_, low_, q_, m_;
  std::vector<Quaternion> attitudes_;
};

}  // namespace

std::size_t rows_for_tolerance(const PrincipalMotion& motion, const Vector3& principal_moments, double first_s,
                               double last_s, double tolerance_rad, double rows_error_rad,
                               RowInterpolation interpolation) {
  if (!(tolerance_rad > 0.0) || !std::isfinite(tolerance_rad)) {
    throw InputError(fmt::format("the tolerance is {} rad; it must be positive", tolerance_rad));
  }
  if (!(rows_error_rad >= 0.0)) {
    throw InputError(fmt::format("the error of the rows is {} rad; it must be 0 or more", rows_error_rad));
  }
  const double left_rad = tolerance_rad - rows_error_rad;
  if (!(rows_error_rad <= ErrorBudget::rows_of_tolerance * tolerance_rad)) {
    throw InputError(fmt::format("a tolerance of {} rad cannot be kept: the rows themselves are good to {:.1e} rad",
                                 tolerance_rad, rows_error_rad));
  }
  const double span_s = last_s - first_s;
  if (!std::isfinite(span_s))
    throw InputError(fmt::format("the span is {} s to {} s; it must be finite", first_s, last_s));
  if (!motion) throw InputError("rows are asked for of no motion");
  check_principal_moments(principal_moments);
  if (!(span_s >= 0.0)) throw InputError(fmt::format("stop is {} s before start; it must not be", -span_s));
  if (span_s == 0.0) return 1;
  const bool circle = interpolation == RowInterpolation::great_circle;
  const int window_rows = circle ? 2 : 8;
  const double order = circle ? 2.0 : 8.0;
  const double wanted = ErrorBudget::measured_between_rows * left_rad;
  Gauge gauge(motion, interpolation);

  constexpr double most_gaps = 1e12;
  constexpr std::size_t looked_at = 50000;
  const auto worst_error = [&](double gaps) {
    const double step_s = span_s / gaps;
    // Windows at the ends are one-sided; in between the gap is the middle one.
    double worst = 0.0;
    const auto look = [&](double first_row, int gap) {
      const double error = gauge.error_rad(first_s + first_row * step_s, step_s, {window_rows, gap});
      if (!(error <= worst)) worst = error;
      return worst <= wanted;
    };
    const double last_first_row = gaps + 1.0 - window_rows;
    for (int gap = 0; gap < window_rows - 1; ++gap) {
      if (!look(0.0, gap) || !look(last_first_row, gap)) return worst;
    }
    const double first_rows = last_first_row + 1.0;
    const auto looks = static_cast<std::size_t>(std::min(first_rows, static_cast<double>(looked_at)));
    for (std::size_t i = 0; i < looks; ++i) {
      const double first_row = std::floor((static_cast<double>(i) + 0.5) / static_cast<double>(looks) * first_rows);
      if (!look(first_row, (window_rows - 1) / 2)) return worst;
    }
    return worst;
  };

  // The rate, at a thousand instants, bounds the gaps from below: the error alone would be small again after a turn.
  constexpr std::size_t probes = 1000;
  std::vector<double> at(probes), low(probes), q(4 * probes), m(3 * probes);
  for (std::size_t i = 0; i < probes; ++i) at[i] = std::lerp(first_s, last_s, static_cast<double>(i) / (probes - 1));
  motion(at, low, q.data(), m.data());
  double fastest_rad_s = 0.0;
  for (std::size_t i = 0; i < probes; ++i) {
    const double rate_rad_s = Eigen::Map<const Vector3>(&m[3 * i]).cwiseQuotient(principal_moments).stableNorm();
    if (!(rate_rad_s <= fastest_rad_s)) fastest_rad_s = rate_rad_s;  // keeps a NaN
  }
  double gaps = std::max({std::ceil(1.1 * fastest_rad_s * span_s), static_cast<double>(window_rows - 1), 1.0});
  if (!(gaps <= most_gaps)) {
    throw InputError(
        fmt::format("the body turns by {:.3g} rad between start and stop; rows 1 rad apart are needed at the least, "
                    "and there may be "
                    "{:g} rows: take a shorter span",
                    fastest_rad_s * span_s, most_gaps));
  }
  const double fewest = gaps;
  // Up by the order of the interpolation until it holds; then down again as long as it does, in finer steps.
  double error = worst_error(gaps);
  while (!(error <= wanted)) {
    if (!(gaps < most_gaps) || std::isnan(error)) {
      throw InputError(fmt::format("no step keeps an interpolation between rows within {} rad", tolerance_rad));
    }
    gaps = std::ceil(gaps * std::clamp(std::pow(error / wanted, 1.0 / order), 1.02, 64.0));
    error = worst_error(gaps);
  }
  constexpr double finest = 0.98;
  for (double factor : {0.8, 0.9, 0.95, finest}) {
    while (std::ceil(gaps * factor) >= fewest && std::ceil(gaps * factor) < gaps &&
           worst_error(std::ceil(gaps * factor)) <= wanted) {
      gaps = std::ceil(gaps * factor);
    }
  }
  return static_cast<std::size_t>(gaps) + 1;
}

}  // namespace polhode
