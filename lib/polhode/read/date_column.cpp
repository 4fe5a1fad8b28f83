#include "polhode/read/date_column.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/read/text.hpp"

namespace polhode {

std::vector<std::string_view> table_cells(std::string_view line, bool comma) {
  if (!comma) return split_words(line);
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    std::string_view cell = trimmed(line.substr(at, end - at));
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
    cells.push_back(cell);
    at = end + 1;
  }
  return cells;
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
