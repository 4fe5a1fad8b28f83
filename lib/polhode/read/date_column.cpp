#include "polhode/read/date_column.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/read/text.hpp"
#include "polhode/time/clock.hpp"

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
    ScaleClock clock(time_scale(name.substr(kind.begin.size())));
    return [clock = std::move(clock), before = kind.before](std::string_view cell) mutable {
      return before.empty() ? clock.parse_date(cell) : clock.parse_date(fmt::format("{}{}", before, cell));
    };
  }
  if (name != "time") return {};
  if (header_scale.empty()) {
    throw InputError("the header says no scale of the column time; date_tdb names one");
  }
  return
      [clock = ScaleClock(time_scale(header_scale))](std::string_view cell) mutable { return clock.parse_date(cell); };
}

}  // namespace polhode
