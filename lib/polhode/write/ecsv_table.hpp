#pragma once

#include <string>
#include <vector>

namespace polhode {

/// A column of an ECSV table: its name, unit (empty: none), type ("float64", "int64" or "string") and what it is.
struct EcsvColumn {
  std::string name;
  std::string unit;
  std::string datatype;
  std::string description;
};

/// A table of any content, as ECSV 1.0 that astropy.table reads: columns, rows of fields as text (quoted here where
/// needed), and comment lines that say what it is. Throws FileError.
void write_ecsv_table(const std::string& path, const std::vector<std::string>& comments,
                      const std::vector<EcsvColumn>& columns, const std::vector<std::vector<std::string>>& rows);

}  // namespace polhode
