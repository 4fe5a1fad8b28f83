#include "polhode/read/time_list.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/date_column.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

/// Whether a first line that is no date is rather the names of a table's columns.
bool looks_like_names(std::string_view line) {
  const std::string upper = upper_case(line);
  for (const std::string_view mark : {"JD", "MJD"}) {
    if (upper.starts_with(mark) && upper.find_first_of("0123456789") == mark.size() + 1) return false;
  }
  return line.find(',') != std::string_view::npos || (upper[0] >= 'A' && upper[0] <= 'Z') || upper[0] == '"';
}

}  // namespace

std::vector<Instant> read_time_list(const std::string& list_or_path, std::optional<TimeScale> missing) {
  std::error_code not_a_path;
  if (std::filesystem::exists(list_or_path, not_a_path)) {
    return parse_time_lines(read_text_file(list_or_path), missing, list_or_path);
  }
  std::vector<Instant> instants;
  std::string_view rest = list_or_path;
  for (;;) {
    const std::size_t comma = rest.find(',');
    try {
      instants.push_back(parse_date_with_scale(trimmed(rest.substr(0, comma)), missing).instant);
    } catch (const InputError& error) {
      if (comma != std::string_view::npos || !instants.empty()) throw;
      throw InputError(fmt::format("there is no file '{:.200}', and as a date: {}", list_or_path, error.what()));
    }
    if (comma == std::string_view::npos) return instants;
    rest.remove_prefix(comma + 1);
  }
}

std::vector<Instant> parse_time_lines(std::string_view text, std::optional<TimeScale> missing,
                                      const std::string& path) {
  if (text.starts_with("SIMPLE  =") || text.find('\0') != std::string_view::npos) {
    throw InputError(
        {path, 0},
        "is no text; a list of times is a file of text with one date a line, or a CSV or ECSV table with a "
        "column of dates");
  }
  std::vector<Instant> instants;
  TextTable table(text, path, TextTable::Comments::anywhere);
  if (const std::optional<DateColumn> column = DateColumn::in(table)) {
    while (table.next()) instants.push_back(column->date(table));
  } else {
    text = without_mark(text);
    for (std::size_t line = 1; !text.empty(); ++line) {
      const std::string_view whole = take_line(text);
      const std::string_view content = trimmed(whole.substr(0, whole.find('#')));
      if (content.empty()) continue;
      if (instants.empty() && looks_like_names(content)) {
        throw InputError(
            {path, line},
            fmt::format("'{:.60}' is no date, and names no column of dates; such columns are date_utc, jd_tdb, mjd_tt "
                        "and the like, whose names say the scale, or a Time that astropy wrote to an ECSV table",
                        content));
      }
      located({path, line}, [&] { instants.push_back(parse_date_with_scale(content, missing).instant); });
    }
  }
  if (instants.empty()) throw InputError({path, 0}, "the list holds no date");
  return instants;
}

}  // namespace polhode
