#include "polhode/ephemeris/time_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

/// n * a with the rounding error of the leading product kept.
Seconds times(double n, Seconds a) { return exact_product(n, a.high) + Seconds{n * a.low, 0.0}; }

double power_of_ten(int exponent) {  // exact up to 22
  double power = 1.0;
  for (int i = 0; i < exponent; ++i) power *= 10.0;
  return power;
}

/// `t` moved to the nearest multiple of 10^-decimals. Whole seconds are split off first, so that the count of decimal
/// units stays an exact integer.
Seconds to_decimals(Seconds t, int decimals) {
  const double unit = power_of_ten(decimals);
  const double whole = std::floor(t.high);
  const double ticks = std::nearbyint(((t.high - whole) + t.low) * unit);
  const double fraction = ticks / unit;
  const double rest = std::fma(-fraction, unit, ticks) / unit;
  return Seconds{whole, 0.0} + Seconds{fraction, rest};
}

bool is_multiple(Seconds t, int decimals) {
  const Seconds moved = to_decimals(t, decimals) - t;
  return std::abs(moved.high) <= 1e-15 * std::max(1.0, std::abs(t.high) * 1e-9);
}

}  // namespace

TimeGrid::TimeGrid(TimeScale scale, Instant first) : scale_(scale) {
  const std::string date = format_date(first, scale, 9).substr(0, 10);
  reference_ = parse_date(date, scale);
  reference_since_j2000_ = since_j2000(reference_, scale);
  using namespace std::chrono;
  const year_month_day day{year(std::stoi(date.substr(0, 4))), month(unsigned(std::stoi(date.substr(5, 2)))),
                           std::chrono::day(unsigned(std::stoi(date.substr(8, 2))))};
  constexpr int mjd_of_1970 = 40587;
  reference_mjd_ = sys_days(day).time_since_epoch().count() + mjd_of_1970;
  start_ = since_j2000(first, scale) - reference_since_j2000_;
}

TimeGrid TimeGrid::with_step(Instant start, Instant stop, Seconds step, TimeScale scale) {
  TimeGrid grid(scale, start);
  const Seconds span = since_j2000(stop, scale) - grid.reference_since_j2000_ - grid.start_;
  if (!(step.high > 0.0) || !std::isfinite(step.high)) {
    throw InputError(fmt::format("the step is {} s; it must be positive", step.high));
  }
  if (span.high < 0.0) throw InputError(fmt::format("stop is {} s before start; it must not be", -span.high));
  const double steps = span.high / step.high;
  constexpr double most_rows = 1e15;
  if (!(steps < most_rows)) {
    throw InputError(fmt::format("a step of {} s makes {:.3g} rows; at most {:.0e}", step.high, steps, most_rows));
  }
  grid.count_ = static_cast<std::size_t>(steps + 1e-6) + 1;
  grid.step_ = step;
  return grid;
}

TimeGrid TimeGrid::with_count(Instant start, Instant stop, std::size_t count, TimeScale scale) {
  if (count == 0) throw InputError("the count of rows is 0; at least 1");
  TimeGrid grid(scale, start);
  grid.count_ = count;
  if (count == 1) return grid;
  const Seconds span = since_j2000(stop, scale) - grid.reference_since_j2000_ - grid.start_;
  if (!(span.high > 0.0)) {
    throw InputError(fmt::format("stop is not after start, which leaves no room for {} rows", count));
  }
  const double intervals = static_cast<double>(count - 1);
  const double high = span.high / intervals;
  grid.step_ = {high, (std::fma(-high, intervals, span.high) + span.low) / intervals};
  return grid;
}

TimeGrid TimeGrid::of_list(std::span<const Instant> instants, TimeScale scale) {
  if (instants.empty()) throw InputError("the list of times is empty; at least one");
  TimeGrid grid(scale, instants.front());
  grid.count_ = instants.size();
  grid.list_.reserve(instants.size());
  for (const Instant& instant : instants) {
    grid.list_.push_back(since_j2000(instant, scale) - grid.reference_since_j2000_);
    if (grid.list_.size() > 1) {
      const Seconds ahead = grid.list_.back() - grid.list_[grid.list_.size() - 2];
      if (!(ahead.high > 0.0)) {
        throw InputError(fmt::format("time {} of the list is {}, not after the one before it; times must increase",
                                     grid.list_.size(), format_date(instant, scale, 9)));
      }
    }
  }
  return grid;
}

int TimeGrid::decimals() const {
  constexpr int fewest = 3;
  constexpr int usual = 9;
  for (int d = fewest; d <= usual; ++d) {
    const bool fits = list_.empty()
                          ? is_multiple(start_, d) && is_multiple(step_, d)
                          : std::all_of(list_.begin(), list_.end(), [d](Seconds t) { return is_multiple(t, d); });
    if (fits) return d;
  }
  double shortest = std::abs(step_.high);
  if (!list_.empty()) {
    shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < list_.size(); ++i) shortest = std::min(shortest, (list_[i] - list_[i - 1]).high);
  }
  const double wanted = shortest > 0.0 ? 3.0 - std::floor(std::log10(shortest)) : 0.0;
  return static_cast<int>(std::clamp(wanted, double{usual}, 15.0));
}

Seconds TimeGrid::time(std::size_t index, TimeResolution resolution) const {
  const Seconds t = list_.empty() ? start_ + times(static_cast<double>(index), step_) : list_[index];
  switch (resolution.kind) {
    case TimeResolution::Kind::one_double:
      return {t.high, 0.0};
    case TimeResolution::Kind::two_doubles:
      return t;
    case TimeResolution::Kind::decimals:
      return to_decimals(t, resolution.decimals);
  }
  return t;
}

Instant TimeGrid::instant(Seconds time) const { return instant_from_j2000(reference_since_j2000_ + time, scale_); }

void TimeGrid::elapsed_tt(std::span<const Seconds> times, Instant epoch, std::span<double> high, std::span<double> low,
                          ScaleNodes& nodes) const {
  constexpr double node_distance_s = 43200.0;
  if (!(nodes.reference == reference_) || nodes.scale != scale_) nodes = {scale_, reference_};
  // Elapsed TT minus elapsed seconds of scale_, since the reference: zero, or for TDB a few milliseconds that bend over
  // days.
  const auto difference = [&](double node) {
    const Seconds at{node * node_distance_s, 0.0};
    return (instant(at) - reference_ - at).high;
  };
  const auto move_to = [&](double cell) {  // keeps the nodes that the two cells have in common
    const ScaleNodes old = nodes;
    nodes.cell = cell;
    for (int k = 0; k < 6; ++k) {
      const double place = cell + k - old.cell;  // NaN at first
      nodes.values[static_cast<std::size_t>(k)] =
          place >= 0.0 && place < 6.0 ? old.values[static_cast<std::size_t>(place)] : difference(cell + k - 2.0);
    }
  };
  const Seconds reference_elapsed = reference_ - epoch;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double position = times[i].high / node_distance_s;
    const double cell = std::floor(position);
    if (cell != nodes.cell) {
      const std::size_t neighbour = i + 1 < times.size() ? i + 1 : i - (i > 0 ? 1 : 0);
      const bool sparse = !(std::abs(times[neighbour].high - times[i].high) < node_distance_s) || times.size() < 6;
      if (sparse) {
        const Seconds t = instant(times[i]) - epoch;
        high[i] = t.high;
        low[i] = t.low;
        continue;
      }
      move_to(cell);
    }
    // Quintic through the nodes at -2 ... 3 of the cell, by its Lagrange weights.
    const double x = position - cell;
    const double a = x + 2.0, b = x + 1.0, c = x, d = x - 1.0, e = x - 2.0, f = x - 3.0;
    const double ab = a * b, cd = c * d, ef = e * f;
    const auto& v = nodes.values;
    const double between =
        cd * (ef * (a * v[1] / 24.0 - b * v[0] / 120.0) + ab * (e * v[5] / 120.0 - f * v[4] / 24.0)) +
        ab * ef * (c * v[3] - d * v[2]) / 12.0;
    const Seconds t = reference_elapsed + times[i] + Seconds{between, 0.0};
    high[i] = t.high;
    low[i] = t.low;
  }
}

}  // namespace polhode
