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
  int decimals = 3;                                        ///< of the dates' seconds
  std::vector<std::string> dates;                          ///< the first column, date_tdb or the like
  std::vector<Instant> instants;                           ///< the same, which FITS has as numbers
  std::vector<NumberColumn> numbers;                       ///< named with their units: range_m, phase_deg
  std::vector<KeptColumn> kept;                            ///< whose names are changed where another column has them
  std::vector<std::pair<std::string, std::string>> about;  ///< for the header, keys and texts
};

/// As FITS, CSV or ECSV (with the header that astropy.table reads), by the path's ending; another one is CSV. Throws
/// FileError; InputError for a time scale that the format's readers misread.
void write_column_table(const std::string& path, const ColumnTable& table);

}  // namespace polhode
