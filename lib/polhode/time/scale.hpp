#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "polhode/time/instant.hpp"

namespace polhode {

/// Time scales that text and numbers may carry.
enum class TimeScale {
  tt,
  tai,
  utc,  ///< TAI less leap seconds; before 1972 with the drifting offset of IERS; before 1960 and beyond the table of
        ///< leap seconds computed all the same, see utc_doubt()
  tdb,  ///< at the geocentre, from eraDtdb: the TDB of astropy
  gps,  ///< TAI - 19 s
  et,   ///< SPICE's ET: TDB from SPICE's own formula (1.657 ms sin E), up to some tens of microseconds off `tdb`
};

/// "TT", "TAI", "UTC", "TDB", "GPS", "ET".
std::string_view name(TimeScale scale);

/// The scale of that name, any case; "TDT" is TT. Throws InputError naming the allowed ones.
TimeScale time_scale(std::string_view name);

/// A date in a scale, no scale in the text: "2000-01-01T12:00:00.5" (seconds or the time of day may be left out, a
/// space may stand for the T), "2000-001T12:00:00" (day of the year), "JD 2451545.0", "MJD 51544.5", or a JD or MJD as
/// a pair of numbers whose sum counts: "JD 2451545 0.25". Years 0000 to 9999. UTC may say second 60 where a leap
/// second stands; a JD or MJD in UTC counts a fraction of that day's own length, as ERFA and astropy do. Digits are
/// kept to far less than a nanosecond. Throws InputError.
Instant parse_date(std::string_view text, TimeScale scale);

/// An instant and the scale it was written in.
struct Date {
  Instant instant;
  TimeScale scale = TimeScale::tdb;
};

/// As parse_date, with the scale as a last word ("2029-04-13T21:46:00 UTC") or "Z" for UTC. Without one, `missing` is
/// the scale; without either, InputError.
Date parse_date_with_scale(std::string_view text, std::optional<TimeScale> missing = std::nullopt);

/// The calendar date "YYYY-MM-DDThh:mm:ss.fff" of an instant with that many decimals of the second (0 to 15), correctly
/// rounded (with :60 in UTC leap seconds). Years 0000 to 9999, else InputError.
std::string format_date(Instant instant, TimeScale scale, int decimals);

/// Elapsed seconds of `scale` from 2000-01-01T12:00:00 read on that same scale (for utc: of TAI, since UTC has no
/// uniform count; J2000 then read on TAI).
Seconds since_j2000(Instant instant, TimeScale scale);

/// The inverse of since_j2000.
Instant instant_from_j2000(Seconds since, TimeScale scale);

/// A modified Julian date (JD - 2400000.5) as the whole day and the fraction of that day, 0 to 1. In UTC a day with a
/// leap second is 86401 s long, as in ERFA and astropy.
struct ModifiedJulianDate {
  double day = 0.0;
  double fraction = 0.0;
};
ModifiedJulianDate modified_julian_date(Instant instant, TimeScale scale);

/// Why UTC is in doubt at this instant, in a sentence: before 1960, when there was none, or years beyond the last leap
/// second that is known. Empty where UTC is sure.
std::optional<std::string> utc_doubt(Instant instant);

}  // namespace polhode
