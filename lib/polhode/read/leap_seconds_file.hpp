#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "polhode/time/leap_seconds.hpp"

namespace polhode {

/// The table DELTET/DELTA_AT of a NAIF leap-second kernel (LSK, a SPICE text kernel), for set_leap_seconds. Throws
/// InputError with file and line, FileError if it cannot be read.
std::vector<LeapSecond> read_leap_seconds(const std::string& path);

/// The same from memory; `path` is for messages.
std::vector<LeapSecond> parse_leap_seconds(std::string_view text, const std::string& path);

}  // namespace polhode
