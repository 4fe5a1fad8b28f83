#pragma once

// Shared by the sources of this folder only.

#include <string>

#include "polhode/time/instant.hpp"

namespace polhode::detail {

/// TDB - TT at the geocentre, s; the argument counts TT (or TDB, all the same) from J2000, s.
double tdb_minus_tt_s(double tt_s);

/// The calendar text of a reading of a uniform scale, seconds from J2000 on that scale.
std::string format_uniform(Seconds reading, int decimals);

}  // namespace polhode::detail
