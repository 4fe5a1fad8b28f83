#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/time/scale.hpp"

namespace polhode {

/// The cells of a line of a table, between commas or, if `comma` is not set, between white space; without the quotes
/// between which a cell may hold either.
std::vector<std::string_view> table_cells(std::string_view line, bool comma);

/// "utc" of a comment "scale: utc" in the header of an ECSV table, else empty.
std::string_view scale_in_ecsv_header(std::string_view comment);

/// The first column of times in the header of an ECSV table that astropy wrote.
class EcsvTime {
 public:
  /// The header's lines one after the other, each without its '#' and trimmed.
  void take(std::string_view comment);

  bool found() const { return !format_.empty(); }
  /// The columns that hold it: one, or the two of a JD as a sum.
  std::vector<std::string> columns() const;
  /// Of the cells of these columns. Throws InputError for what is no date, or a format of astropy that is not read.
  Instant date(std::string_view first, std::string_view second) const;

 private:
  bool inside_ = false;
  std::string last_key_, name_, format_, scale_, value_, jd1_, jd2_;
};

/// Reads the cells of a column of dates. Throws InputError for a cell that is none.
using DateReader = std::function<Instant(std::string_view)>;

/// The reader for a column of that name: "date_utc", "jd_tdb", "mjd_tt" and the like, or "time" with the scale that an
/// ECSV header gives. Empty if the name is not one of dates. Throws InputError where the scale is missing or unknown.
DateReader date_column(std::string_view name, std::string_view header_scale);

}  // namespace polhode
