#pragma once

#include <string>

namespace polhode {

/// "polhode" and its version, for the headers of files.
std::string creator();

/// Now in UTC as "2000-01-01T12:00:00", or the instant of environment variable SOURCE_DATE_EPOCH (seconds since 1970),
/// with which the same input gives the same bytes.
std::string creation_date();

}  // namespace polhode
