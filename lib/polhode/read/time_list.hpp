#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/time/scale.hpp"

namespace polhode {

/// Dates separated by commas; or, if a file of that name exists, its lines, one date each, `#` comments, or the column
/// of dates of a table (CSV or ECSV; date_column.hpp). A date names its scale ("2029-04-13T21:46:00 UTC") or has
/// `missing`; without either it is refused. Throws InputError with file and line.
std::vector<Instant> read_time_list(const std::string& list_or_path, std::optional<TimeScale> missing);

/// The lines of such a file, from memory; `path` is for messages.
std::vector<Instant> parse_time_lines(std::string_view text, std::optional<TimeScale> missing, const std::string& path);

}  // namespace polhode
