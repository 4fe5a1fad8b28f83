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

/// A double as two halves of 26 bits at most (Dekker, Veltkamp), for |a| < 2^996.
struct Halves {
  explicit Halves(double a) {
    constexpr double splitter = 0x1p27 + 1.0;
    const double scaled = a * splitter;
    high = scaled - (scaled - a);
    low = a - high;
  }
  double high;
  double low;
};

/// n * a with the rounding error of the leading product kept. Without fma, which is a function call where not every
/// machine has the instruction, and so keeps a loop from working on several rows at once.
inline Seconds times_number(double n, Seconds a) {
  const double product = n * a.high;
  const Halves x(n);
  const Halves y(a.high);
  const double error = ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low;
  return Seconds{product, error} + Seconds{n * a.low, 0.0};
}

double power_of_ten(int exponent) {  // exact up to 22
  double power = 1.0;
  for (int i = 0; i < exponent; ++i) power *= 10.0;
  return power;
}

/// `t` moved to the nearest multiple of 1 / unit. Whole seconds are split off first, so that the count of decimal units
/// stays an exact integer.
Seconds to_multiple(Seconds t, double unit) {
  const double whole = std::floor(t.high);
  const double ticks = std::nearbyint(((t.high - whole) + t.low) * unit);
  const double fraction = ticks / unit;
  const double rest = std::fma(-fraction, unit, ticks) / unit;
  return Seconds{whole, 0.0} + Seconds{fraction, rest};
}

bool is_multiple(Seconds t, int decimals) {
  const Seconds moved = to_multiple(t, power_of_ten(decimals)) - t;
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
  if (!(step.high > 0.0) || !std::isfinite(step.high) || !std::isfinite(step.low)) {
    throw InputError(fmt::format("the step is {} s; it must be positive", step.high));
  }
  if (span.high < 0.0) throw InputError(fmt::format("stop is {} s before start; it must not be", -span.high));
  const double steps = span.high / step.high;
  if (!(steps < static_cast<double>(most_rows))) {
    throw InputError(fmt::format("a step of {} s makes {:.3g} rows; at most {}", step.high, steps, most_rows));
  }
  // TDB swings about TT by 1.7 ms, at most 3.3e-10 of itself: what is a whole number of steps in one scale is one in
  // all.
  const double swing_s = std::min(4e-3, 5e-10 * span.high);
  const double slack = std::max(1e-6, std::min(0.01, swing_s / step.high));
  grid.count_ = static_cast<std::size_t>(steps + slack) + 1;
  grid.step_ = step;
  return grid;
}

TimeGrid TimeGrid::with_count(Instant start, Instant stop, std::size_t count, TimeScale scale) {
  if (count == 0 || count > most_rows) {
    throw InputError(fmt::format("the count of rows is {}; it is at least 1 and at most {}", count, most_rows));
  }
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
  Seconds out;
  times(index, resolution, {&out, 1});
  return out;
}

void TimeGrid::times(std::size_t first, TimeResolution resolution, std::span<Seconds> out) const {
  if (first > count_ || out.size() > count_ - first) {
    throw InputError(fmt::format("rows {} to {} are asked for, there are {}", first + 1, first + out.size(), count_));
  }
  if (resolution.kind == TimeResolution::Kind::decimals && !(0 <= resolution.decimals && resolution.decimals <= 15)) {
    throw InputError(fmt::format("{} decimals of a second are asked for, 0 to 15 are allowed", resolution.decimals));
  }
  if (list_.empty()) {
    const Seconds start = start_;
    const Seconds step = step_;
    const auto begin = static_cast<double>(first);  // counts below 2^53 are exact
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = start + times_number(begin + static_cast<double>(static_cast<int>(i)), step);
    }
  } else {
    std::copy_n(list_.begin() + static_cast<std::ptrdiff_t>(first), out.size(), out.begin());
  }
  switch (resolution.kind) {
    case TimeResolution::Kind::one_double:
      for (Seconds& t : out) t.low = 0.0;
      break;
    case TimeResolution::Kind::two_doubles:
      break;
    case TimeResolution::Kind::decimals: {
      const double unit = power_of_ten(resolution.decimals);
      for (Seconds& t : out) t = to_multiple(t, unit);
      break;
    }
  }
}

Instant TimeGrid::instant(Seconds time) const { return instant_from_j2000(reference_since_j2000_ + time, scale_); }

void TimeGrid::elapsed_tt(std::span<const Seconds> times, Instant epoch, std::span<double> high, std::span<double> low,
                          ScaleNodes& nodes) const {
  constexpr double node_distance_s = 43200.0;
  if (!(nodes.reference == reference_) || nodes.scale != scale_) nodes = {scale_, reference_};
  // Elapsed TT minus elapsed seconds of scale_, since the reference, at TT nodes: zero, or for TDB a few milliseconds
  // that bend over days.
  const auto difference = [&](double node) {
    const Seconds elapsed{node * node_distance_s, 0.0};
    return (elapsed - (since_j2000(reference_ + elapsed, scale_) - reference_since_j2000_)).high;
  };
  const auto move_to = [&](double cell) {  // keeps the nodes that the two cells have in common
    const ScaleNodes old = nodes;
    nodes.cell = cell;
    auto& v = nodes.values;
    for (int k = 0; k < 6; ++k) {
      const double place = cell + k - old.cell;  // NaN at first
      v[static_cast<std::size_t>(k)] =
          place >= 0.0 && place < 6.0 ? old.values[static_cast<std::size_t>(place)] : difference(cell + k - 2.0);
    }
    // The quintic through (-2, v0) … (3, v5).
    nodes.polynomial = {v[2],
                        v[0] / 20 - v[1] / 2 - v[2] / 3 + v[3] - v[4] / 4 + v[5] / 30,
                        -v[0] / 24 + v[1] * 2 / 3 - v[2] * 5 / 4 + v[3] * 2 / 3 - v[4] / 24,
                        -v[0] / 24 - v[1] / 24 + v[2] * 5 / 12 - v[3] * 7 / 12 + v[4] * 7 / 24 - v[5] / 24,
                        v[0] / 24 - v[1] / 6 + v[2] / 4 - v[3] / 6 + v[4] / 24,
                        -v[0] / 120 + v[1] / 24 - v[2] / 12 + v[3] / 12 - v[4] / 24 + v[5] / 120};
  };
  const Seconds reference_elapsed = reference_ - epoch;
  for (std::size_t i = 0; i < times.size();) {
    const double cell = std::floor(times[i].high / node_distance_s);
    if (cell != nodes.cell) {
      const std::size_t neighbour = i + 1 < times.size() ? i + 1 : i - (i > 0 ? 1 : 0);
      const bool sparse = !(std::abs(times[neighbour].high - times[i].high) < node_distance_s) || times.size() < 6;
      if (sparse) {
        const Seconds t = instant(times[i]) - epoch;
        high[i] = t.high;
        low[i] = t.low;
        ++i;
        continue;
      }
      move_to(cell);
    }
    const double cell_end_s = (cell + 1.0) * node_distance_s;
    const auto beyond = std::partition_point(times.begin() + static_cast<std::ptrdiff_t>(i) + 1, times.end(),
                                             [cell_end_s](Seconds t) { return t.high < cell_end_s; });
    const auto end = static_cast<std::size_t>(beyond - times.begin());
    const std::array<double, 6> c = nodes.polynomial;
    const auto at = [&c](double x) { return ((((c[5] * x + c[4]) * x + c[3]) * x + c[2]) * x + c[1]) * x + c[0]; };
    for (; i < end; ++i) {
      const double x = times[i].high / node_distance_s - cell;
      const double between = at(x + at(x) / node_distance_s);  // x, a place in scale_, led to TT
      const Seconds t = exact_sum(reference_elapsed.high, times[i].high);
      high[i] = t.high;
      low[i] = t.low + (reference_elapsed.low + times[i].low + between);
    }
  }
}

}  // namespace polhode
