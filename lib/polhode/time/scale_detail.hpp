#pragma once

// Shared by the sources of this folder only.

#include <string>
#include <string_view>

#include "polhode/time/instant.hpp"
#include "polhode/time/scale.hpp"

namespace polhode::detail {

/// TDB - TT at the geocentre, s; the argument counts TT (or TDB, all the same) from J2000, s.
double tdb_minus_tt_s(double tt_s);

/// Seconds of a uniform scale from J2000 of a date's text.
Seconds parse_uniform(std::string_view text, TimeScale scale);

/// The calendar text of a reading of a uniform scale, seconds from J2000 on that scale.
std::string format_uniform(Seconds reading, int decimals);

}  // namespace polhode::detail
