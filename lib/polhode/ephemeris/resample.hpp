#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

/// Which instants of an attitude history are wanted: its own rows, unless `step` or `count` or `list` says otherwise.
struct WantedTimes {
  std::optional<Instant> start, stop;  ///< of the span; absent: the history's first and last
  std::optional<Seconds> step;         ///< distance of rows, from the span's start and from each segment's on
  std::size_t count = 0;               ///< rows in each segment, both ends included; 0: not given
  std::vector<Instant> list;           ///< these instants, increasing; then no start and no stop
};

/// An attitude history as ephemerides, one for each of its segments that holds wanted times: no row is interpolated
/// between segments, or lies outside of the rows or the usable span of its segment. Rates are those of the rows at the
/// rows, elsewhere those of the interpolation. The rows refer to `frame`, or if there is none to the history's own.
///
/// Throws InputError if start, stop or an instant of the list is outside of the history, if start is after stop, if no
/// row lies within, if the history's clock has no known scale, and for what Ephemeris refuses.
std::vector<Ephemeris> resample(const AttitudeHistory& history, const WantedTimes& wanted, TimeScale scale,
                                std::optional<Frame> frame);

}  // namespace polhode
