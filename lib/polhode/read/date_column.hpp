#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "polhode/time/scale.hpp"

namespace polhode {

/// The cells of a line of a table, between commas or, if `comma` is not set, between white space; without quotes.
std::vector<std::string_view> table_cells(std::string_view line, bool comma);

/// "utc" of a comment "scale: utc" in the header of an ECSV table, else empty.
std::string_view scale_in_ecsv_header(std::string_view comment);

/// Reads the cells of a column of dates. Throws InputError for a cell that is none.
using DateReader = std::function<Instant(std::string_view)>;

/// The reader for a column of that name: "date_utc", "jd_tdb", "mjd_tt" and the like, or "time" with the scale that an
/// ECSV header gives. Empty if the name is not one of dates. Throws InputError where the scale is missing or unknown.
DateReader date_column(std::string_view name, std::string_view header_scale);

}  // namespace polhode
