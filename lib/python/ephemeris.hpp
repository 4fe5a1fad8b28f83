#pragma once

// Rows of attitudes that are asked for: what motions and histories share.

#include <functional>
#include <optional>
#include <vector>

#include "polhode/write/ephemeris_formats.hpp"
#include "python/objects.hpp"

namespace polhode::python {

/// Ephemeris: rows to be, of a motion or of an attitude history.
struct EphemerisObject {
  /// How many rows there are may depend on what a format's readers do between them; null: as by great circles.
  std::function<std::vector<Ephemeris>(const EphemerisFormat* format)> make;
  bool promises_interpolation = false;
};

/// A wanted time: a date, a span as '+30 d' from `from` in seconds of `scale`, or seconds from `epoch` as TT counts
/// them.
Instant wanted(const nb::object& time, Instant epoch, Instant from, TimeScale scale);

/// The instants of a list of times, of a comma-separated text, or of a file: in order, each once.
std::vector<Instant> wanted_list(const nb::object& times, Instant epoch);

/// Where rows are.
struct Spacing {
  std::optional<Given<Duration>> step;
  std::optional<std::size_t> count;
  std::optional<Given<PlaneAngle>> tolerance;
  nb::object times = nb::none();

  void check() const;
};

}  // namespace polhode::python
