#pragma once

#include <string>
#include <string_view>

#include "polhode/time/instant.hpp"

namespace polhode {

/// Time scales that text and numbers may carry. TDB is the geocentric TDB of ERFA's eraDtdb (that of astropy).
enum class TimeScale { tt, tai, utc, tdb };

/// "TT", "TAI", "UTC", "TDB".
std::string_view name(TimeScale scale);

/// The scale of that name, any case. Throws InputError naming the allowed ones.
TimeScale time_scale(std::string_view name);

/// A calendar date in a scale: "2000-01-01T12:00:00.5", "2000-001T12:00:00", date alone, or "JD 2451545.0" /
/// "MJD 51544.5". UTC may say second 60 where a leap second stands. Throws InputError.
Instant parse_date(std::string_view text, TimeScale scale);

/// The calendar date "YYYY-MM-DDThh:mm:ss.fff" of an instant with that many decimals of the second, correctly rounded
/// (with :60 in UTC leap seconds).
std::string format_date(Instant instant, TimeScale scale, int decimals);

/// Elapsed seconds of `scale` from 2000-01-01T12:00:00 read on that same scale (for utc: of TAI, since UTC has no
/// uniform count; J2000 then read on TAI).
Seconds since_j2000(Instant instant, TimeScale scale);

/// The inverse of since_j2000.
Instant instant_from_j2000(Seconds since, TimeScale scale);

}  // namespace polhode
