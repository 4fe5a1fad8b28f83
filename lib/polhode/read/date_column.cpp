#include "polhode/read/date_column.hpp"

#include <fmt/format.h>

#include <array>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"

namespace polhode {
namespace {

/// A decimal number without an exponent, as dates have it.
std::string without_exponent(const std::string& cell) {
  const std::optional<double> number = parse_number(cell);
  if (!number || cell.find_first_of("eE") == std::string::npos) return cell;
  return fmt::format("{:.20f}", *number);
}

}  // namespace

DateReader date_column(const TextTable& table, std::size_t column) {
  const std::string_view name = table.names()[column];
  const std::string_view header_scale = table.header().scale();
  struct Kind {
    std::string_view begin;
    std::string_view before;  // what parse_date wants before the number
  };
  constexpr std::array kinds{Kind{"date_", ""}, Kind{"jd_", "JD "}, Kind{"mjd_", "MJD "}};
  for (const Kind& kind : kinds) {
    if (!name.starts_with(kind.begin)) continue;
    const TimeScale scale = table.located([&] { return time_scale(name.substr(kind.begin.size())); });
    table.check_unit(column, kind.before.empty() ? "" : "d");
    return [scale, before = kind.before](std::string_view cell) {
      return before.empty() ? parse_date(cell, scale) : parse_date(fmt::format("{}{}", before, cell), scale);
    };
  }
  if (name != "time") return {};
  if (header_scale.empty()) {
    throw table.error("the header says no scale of the column time; date_tdb names one");
  }
  table.check_unit(column, "");
  return [scale = table.located([&] { return time_scale(header_scale); })](std::string_view cell) {
    return parse_date(cell, scale);
  };
}

std::optional<DateColumn> DateColumn::in(const TextTable& table) {
  DateColumn out;
  const std::size_t columns = table.names().size();
  const EcsvHeader::Time& time = table.header().time();
  if (!time.format.empty()) {
    out.time_ = time;
    const bool two = !time.jd1.empty() && !time.jd2.empty();
    out.first_ = table.column(two ? time.jd1 : time.value.empty() ? time.name : time.value);
    out.second_ = two ? table.column(time.jd2) : out.first_;
    if (out.first_ < columns && out.second_ < columns) {
      for (const std::size_t column : {out.first_, out.second_}) {
        table.check_unit(column, two || contains_word("jd mjd", time.format) ? "d" : "");
      }
      return out;
    }
  }
  for (out.first_ = 0; out.first_ < columns; ++out.first_) {
    out.read_ = date_column(table, out.first_);
    out.second_ = out.first_;
    if (!out.read_) continue;
    table.column(table.names()[out.first_]);  // once
    return out;
  }
  return std::nullopt;
}

Instant DateColumn::date(const TextTable& table) const {
  return table.located(
      [&] { return read_ ? read_(table.cell(first_)) : date(table.cell(first_), table.cell(second_)); });
}

Instant DateColumn::date(const std::string& first, const std::string& second) const {
  const TimeScale scale = time_scale(time_.scale);
  if (first_ != second_) {
    return parse_date(fmt::format("JD {} {}", without_exponent(first), without_exponent(second)), scale);
  }
  if (time_.format == "jd" || time_.format == "mjd") {
    return parse_date(fmt::format("{} {}", upper_case(time_.format), without_exponent(first)), scale);
  }
  if (contains_word("isot iso fits datetime", time_.format)) return parse_date(first, scale);
  throw InputError(fmt::format("the times of column {} are of astropy's format {:.20}; isot, iso, jd and mjd are read",
                               time_.value.empty() ? time_.name : time_.value, time_.format));
}

}  // namespace polhode
