#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "polhode/read/text_table.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

/// Reads the cells of a column of dates. Throws InputError for a cell that is none.
using DateReader = std::function<Instant(std::string_view)>;

/// The reader for a column whose name is "date_utc", "jd_tdb", "mjd_tt" and the like, or "time" with the scale that an
/// ECSV header gives. Empty if the name is not one of dates. Throws InputError, with the line of the names, where the
/// scale is missing or unknown, or the header gives a unit that is not the name's.
DateReader date_column(const TextTable& table, std::size_t column);

/// The column of dates of a table, or the two whose sum is a JD.
class DateColumn {
 public:
  /// The first one: a Time that astropy wrote to an ECSV table, else one for which date_column() has a reader. Nothing
  /// if there is none. Throws InputError as date_column().
  static std::optional<DateColumn> in(const TextTable& table);

  /// Of the table's row. Throws InputError for what is no date, or a format of astropy that is not read.
  Instant date(const TextTable& table) const;

  /// Whether this column of the table is it, or one of the two.
  bool holds(std::size_t column) const { return column == first_ || column == second_; }

 private:
  Instant date(const std::string& first, const std::string& second) const;

  std::size_t first_ = 0, second_ = 0;
  DateReader read_;        // of a column whose name says what it is
  EcsvHeader::Time time_;  // else
};

}  // namespace polhode
