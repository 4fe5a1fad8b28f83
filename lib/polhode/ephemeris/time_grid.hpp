#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "polhode/time/instant.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

/// What a file format can say about the time of a row. Wanted times are moved to the nearest time that the format has,
/// so that a row holds the attitude at exactly the instant that stands beside it.
struct TimeResolution {
  enum class Kind {
    one_double,   ///< seconds from the reference in one double
    two_doubles,  ///< seconds from the reference in an unevaluated sum of two doubles
    decimals,     ///< seconds with `decimals` decimals
  };
  Kind kind = Kind::one_double;
  int decimals = 0;  ///< 0 to 15
};

/// The times of an ephemeris, generated in its time scale as seconds of that scale from `reference()`, the midnight
/// that begins the scale's day of the first row. In UTC these are elapsed SI seconds: leap seconds count, as in FITS.
class TimeGrid {
 public:
  static constexpr std::size_t most_rows = 1'000'000'000'000'000;  ///< their numbers are exact as doubles

  /// start, start + step, … as far as stop, which is included where it is hit within a millionth of the step, or in
  /// another time scale: the swing of TDB about TT (4 ms at most, and a hundredth of the step) keeps no row away.
  /// Throws InputError unless step > 0 and start <= stop, and for more than most_rows.
  static TimeGrid with_step(Instant start, Instant stop, Seconds step, TimeScale scale);

  /// 1 <= `count` <= most_rows times, equally spaced from start to a later stop, both included; one is start alone.
  /// Throws InputError for others.
  static TimeGrid with_count(Instant start, Instant stop, std::size_t count, TimeScale scale);

  /// The given instants, strictly increasing. Throws InputError if not, or if there are none.
  static TimeGrid of_list(std::span<const Instant> instants, TimeScale scale);

  std::size_t size() const { return count_; }
  TimeScale scale() const { return scale_; }

  /// The midnight from which the rows' seconds count, and its Modified Julian Date (a whole number) in scale().
  Instant reference() const { return reference_; }
  double reference_mjd() const { return reference_mjd_; }

  /// Distance of equally spaced rows; absent for a list.
  std::optional<Seconds> step() const { return list_.empty() ? std::optional(step_) : std::nullopt; }

  /// The fewest decimals of a second, at least 3, that hold every time of the grid exactly; 9 where none up to 9 does,
  /// and more (to 15) where the step is below a microsecond.
  int decimals() const;

  /// Seconds of scale() from the reference for row `index`, moved to the resolution.
  Seconds time(std::size_t index, TimeResolution resolution) const;

  /// The same for rows first, first + 1, … to fill `out`. Throws InputError for rows that there are not, or decimals
  /// out of range.
  void times(std::size_t first, TimeResolution resolution, std::span<Seconds> out) const;

  /// The instant that time() names.
  Instant instant(Seconds time) const;

  /// What elapsed_tt() keeps from one call to the next: start with an empty one, one per thread.
  struct ScaleNodes {
    TimeScale scale = TimeScale::tt;
    Instant reference;
    double cell = std::numeric_limits<double>::quiet_NaN();  // no node yet
    std::array<double, 6> values{};                          // at nodes cell - 2 … cell + 3
    std::array<double, 6> polynomial{};                      // through them, in powers of the place in the cell, 0 to 1
  };

  /// TT seconds from `epoch` to each of the `times` of this grid (increasing, as time() gives them). Where rows are
  /// close, the difference of the two scales is interpolated between nodes half a day apart, which costs less than
  /// 1e-13 s.
  void elapsed_tt(std::span<const Seconds> times, Instant epoch, std::span<double> high, std::span<double> low,
                  ScaleNodes& nodes) const;

 private:
  TimeGrid(TimeScale scale, Instant first);

  TimeScale scale_;
  Instant reference_;
  double reference_mjd_ = 0.0;
  Seconds reference_since_j2000_;  // of scale_
  std::size_t count_ = 0;
  Seconds start_;              // from the reference
  Seconds step_;               // uniform grids
  std::vector<Seconds> list_;  // lists, from the reference
};

}  // namespace polhode
