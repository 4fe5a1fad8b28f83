#include "polhode/ephemeris/resample.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

/// Two files, or two scales, round the time of one row differently.
constexpr Seconds time_rounding{1e-6, 0.0};

/// The spans of the segments, for messages.
std::string spans(const AttitudeHistory& history, TimeScale scale) {
  constexpr std::size_t most = 4;
  std::string text;
  for (std::size_t i = 0; i < history.segments.size() && i < most; ++i) {
    const AttitudeSegment& s = history.segments[i];
    text += fmt::format("{}{} to {}", i == 0 ? "" : ", ", format_date(s.first(), scale, 3),
                        format_date(s.last(), scale, 3));
  }
  return text + (history.segments.size() > most ? fmt::format(", … {} segments", history.segments.size()) : "") + " " +
         std::string(name(scale));
}

const AttitudeSegment& segment_of(const AttitudeHistory& history, Instant time, TimeScale scale) {
  for (const AttitudeSegment& s : history.segments) {
    if (s.is_usable_at(time)) return s;
  }
  throw InputError(fmt::format("{} {} is outside of the attitude history, which can be used from {}",
                               format_date(time, scale, 3), name(scale), spans(history, scale)));
}

EphemerisDescription describe(const AttitudeHistory& history, const AttitudeSegment& segment, bool own_rows) {
  EphemerisDescription d;
  d.object = history.object;
  d.object_id = history.object_id;
  d.source = history.source;
  d.body_axes = segment.body == "BODY" ? "" : segment.body;
  d.method = own_rows ? "rows of an attitude history"
                      : fmt::format("interpolation of an attitude history, {} of degree {}", name(segment.method),
                                    segment.degree);
  if (own_rows && segment.method_stated) {
    d.ccsds_interpolation = name(segment.method);
    d.ccsds_interpolation_degree = segment.degree;
  }
  return d;
}

/// The wanted times between two instants of a segment; nothing if there are none.
std::optional<TimeGrid> times_between(const AttitudeSegment& segment, const WantedTimes& wanted, Instant first,
                                      Instant last, TimeScale scale) {
  if (wanted.count != 0) return TimeGrid::with_count(first, last, wanted.count, scale);
  if (wanted.step) {
    TimeGrid grid = TimeGrid::with_step(first, last, *wanted.step, scale);
    // A grid may end a millionth of a step late, which is outside.
    const Instant end = grid.instant(grid.time(grid.size() - 1, {TimeResolution::Kind::two_doubles}));
    if (!(last + time_rounding < end)) return grid;
    return TimeGrid::with_step(first, last + Seconds{-0.5 * wanted.step->high, 0.0}, *wanted.step, scale);
  }
  std::vector<Instant> rows;
  for (const AttitudeSample& row : segment.samples) {
    if (!(row.time + time_rounding < first) && !(last + time_rounding < row.time)) rows.push_back(row.time);
  }
  return rows.empty() ? std::nullopt : std::optional(TimeGrid::of_list(rows, scale));
}

}  // namespace

std::vector<Ephemeris> resample(const AttitudeHistory& history, const WantedTimes& wanted, TimeScale scale,
                                std::optional<Frame> frame) {
  if (!history.absolute_time) {
    throw InputError("the times of the attitude history are of a clock that cannot be related to a time scale");
  }
  for (const AttitudeSegment& segment : history.segments) checked(segment);
  refuse_overlaps(history);
  std::vector<Ephemeris> out;
  const auto add = [&](const AttitudeSegment& segment, TimeGrid grid) {
    const bool own_rows = wanted.list.empty() && !wanted.step && wanted.count == 0;
    out.emplace_back(describe(history, segment, own_rows), segment, frame, std::move(grid));
  };
  if (!wanted.list.empty()) {
    for (std::size_t i = 0; i < wanted.list.size();) {
      const AttitudeSegment& segment = segment_of(history, wanted.list[i], scale);
      const std::size_t begin = i;
      while (i < wanted.list.size() && segment.is_usable_at(wanted.list[i])) ++i;
      add(segment, TimeGrid::of_list(std::span(wanted.list).subspan(begin, i - begin), scale));
    }
    return out;
  }
  if (wanted.start) segment_of(history, *wanted.start, scale);
  if (wanted.stop) segment_of(history, *wanted.stop, scale);
  if (wanted.start && wanted.stop && *wanted.stop < *wanted.start) throw InputError("stop is before start");
  for (const AttitudeSegment& segment : history.segments) {
    Instant first = segment.first();
    Instant last = segment.last();
    if (wanted.start && first < *wanted.start) first = *wanted.start;
    if (wanted.stop && *wanted.stop < last) last = *wanted.stop;
    // Of a segment that the span only touches nothing is wanted, unless it is all there is.
    const bool touches = !(first < last);
    const bool instant_wanted =
        segment.samples.size() == 1 || (wanted.start && wanted.stop && !(*wanted.start < *wanted.stop));
    if (last < first || (touches && !instant_wanted)) continue;
    if (std::optional<TimeGrid> grid = times_between(segment, wanted, first, last, scale)) {
      add(segment, *std::move(grid));
    }
  }
  if (out.empty())
    throw InputError("no row of the attitude history lies within its usable span, or from start to stop");
  return out;
}

}  // namespace polhode
