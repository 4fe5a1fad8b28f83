#include "polhode/read/date_column.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"

namespace polhode {

std::vector<std::string_view> table_cells(std::string_view line, bool comma) {
  const auto is_blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  std::vector<std::string_view> cells;
  std::string_view rest = trimmed(line);
  bool more = comma || !rest.empty();
  while (more) {
    std::size_t end = 0;
    bool quoted = false;
    while (end < rest.size() && (quoted || !(comma ? rest[end] == ',' : is_blank(rest[end])))) {
      if (rest[end] == '"') quoted = !quoted;
      ++end;
    }
    if (quoted) end = std::min(comma ? rest.find(',') : rest.find_first_of(" \t"), rest.size());  // never closed
    std::string_view cell = trimmed(rest.substr(0, end));
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
    cells.push_back(cell);
    more = end < rest.size();
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (!comma) rest = trimmed(rest);
  }
  return cells;
}

namespace {

/// "time" of "!astropy.table.SerializedColumn {name: time}".
std::string column_name(std::string_view value) {
  constexpr std::string_view key = "name: ";
  const std::size_t at = value.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view name = trimmed(value.substr(at + key.size(), value.rfind('}') - at - key.size()));
  if (name.size() > 1 && (name.front() == '\'' || name.front() == '"') && name.back() == name.front()) {
    name = name.substr(1, name.size() - 2);
  }
  return std::string(name);
}

/// A decimal number without an exponent, as dates have it.
std::string without_exponent(std::string_view cell) {
  const std::optional<double> number = parse_number(cell);
  if (!number || cell.find_first_of("eE") == std::string_view::npos) return std::string(cell);
  return fmt::format("{:.20f}", *number);
}

}  // namespace

void EcsvTime::take(std::string_view comment) {
  const std::size_t colon = comment.find(':');
  if (colon == std::string_view::npos) return;
  const std::string_view key = comment.substr(0, colon), value = trimmed(comment.substr(colon + 1));
  if (key == "__class__") {
    inside_ = !found() && value == "astropy.time.core.Time";
    if (inside_) name_ = last_key_;
  } else if (value.empty()) {
    last_key_ = key;
    inside_ = false;
  } else if (inside_) {
    if (key == "format") format_ = value;
    if (key == "scale") scale_ = value;
    if (key == "value") value_ = column_name(value);
    if (key == "jd1") jd1_ = column_name(value);
    if (key == "jd2") jd2_ = column_name(value);
  }
}

std::vector<std::string> EcsvTime::columns() const {
  if (!jd1_.empty() && !jd2_.empty()) return {jd1_, jd2_};
  return {value_.empty() ? name_ : value_};
}

Instant EcsvTime::date(std::string_view first, std::string_view second) const {
  const TimeScale scale = time_scale(scale_);
  if (!jd1_.empty() && !jd2_.empty()) {
    return parse_date(fmt::format("JD {} {}", without_exponent(first), without_exponent(second)), scale);
  }
  if (format_ == "jd" || format_ == "mjd") {
    return parse_date(fmt::format("{} {}", upper_case(format_), without_exponent(first)), scale);
  }
  if (format_ == "isot" || format_ == "iso" || format_ == "fits" || format_ == "datetime") {
    return parse_date(first, scale);
  }
  throw InputError(fmt::format("the times of column {} are of astropy's format {:.20}; isot, iso, jd and mjd are read",
                               columns().front(), format_));
}

std::string_view scale_in_ecsv_header(std::string_view comment) {
  return comment.starts_with("scale:") ? trimmed(comment.substr(6)) : std::string_view();
}

DateReader date_column(std::string_view name, std::string_view header_scale) {
  struct Kind {
    std::string_view begin;
    std::string_view before;  // what parse_date wants before the number
  };
  constexpr std::array kinds{Kind{"date_", ""}, Kind{"jd_", "JD "}, Kind{"mjd_", "MJD "}};
  for (const Kind& kind : kinds) {
    if (!name.starts_with(kind.begin)) continue;
    const TimeScale scale = time_scale(name.substr(kind.begin.size()));
    return [scale, before = kind.before](std::string_view cell) {
      return before.empty() ? parse_date(cell, scale) : parse_date(fmt::format("{}{}", before, cell), scale);
    };
  }
  if (name != "time") return {};
  if (header_scale.empty()) {
    throw InputError("the header says no scale of the column time; date_tdb names one");
  }
  return [scale = time_scale(header_scale)](std::string_view cell) { return parse_date(cell, scale); };
}

}  // namespace polhode
