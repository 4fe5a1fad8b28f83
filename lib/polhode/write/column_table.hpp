#pragma once

#include <string>
#include <utility>
#include <vector>

#include "polhode/time/scale.hpp"

namespace polhode {

/// Numbers and texts that belong to dates, to be written as a table.
struct ColumnTable {
  struct NumberColumn {
    std::string name;
    std::vector<double> values;
  };
  struct KeptColumn {
    std::string name;
    std::vector<std::string> cells;
  };

  TimeScale scale = TimeScale::tdb;
  int decimals = 3;                   ///< of the dates' seconds
  std::vector<std::string> dates;     ///< the first column, date_tdb or the like
  std::vector<NumberColumn> numbers;  ///< named with their units: range_m, phase_deg
  std::vector<KeptColumn> kept;
  std::vector<std::pair<std::string, std::string>> about;  ///< for the header of ECSV, keys and texts
};

/// Whether a path ends as one of the two formats: ".csv" or ".ecsv", in any case.
bool is_column_table(const std::string& path);

/// As CSV or, where `ecsv`, with the header that astropy.table reads. Throws FileError; InputError for a time scale
/// that astropy does not know.
void write_column_table(const std::string& path, const ColumnTable& table, bool ecsv);

}  // namespace polhode
