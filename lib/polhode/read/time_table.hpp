#pragma once

#include <optional>
#include <string>
#include <vector>

#include "polhode/time/scale.hpp"

namespace polhode {

/// A table with a column of dates, row by row, with all its cells: what observations were written down in.
struct TimeTable {
  std::string path;
  std::vector<Instant> instants;
  std::vector<std::size_t> lines;                 ///< of the rows in the file
  std::vector<std::string> names;                 ///< of the columns that hold no dates
  std::vector<std::vector<std::string>> columns;  ///< of each, the cells

  /// The numbers of a column; nothing if there is none of that name. Throws InputError for a cell that is no number.
  std::optional<std::vector<double>> numbers(const std::string& name) const;
};

/// The table of a file (CSV, ECSV; date_column.hpp); nothing if it is none. Throws InputError with file and line.
std::optional<TimeTable> parse_time_table(const std::string& text, const std::string& path);

}  // namespace polhode
