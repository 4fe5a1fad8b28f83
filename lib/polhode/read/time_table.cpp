#include "polhode/read/time_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/date_column.hpp"
#include "polhode/read/text_table.hpp"

namespace polhode {

std::optional<std::vector<double>> TimeTable::numbers(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  const std::vector<std::string>& cells = columns[static_cast<std::size_t>(found - names.begin())];
  std::vector<double> out;
  for (std::size_t row = 0; row < cells.size(); ++row) {
    const std::optional<double> number = parse_number(cells[row]);
    if (!number) {
      throw InputError({path, lines[row]},
                       fmt::format("column {:.40} holds '{:.40}', a number is wanted", name, cells[row]));
    }
    out.push_back(*number);
  }
  return out;
}

std::optional<TimeTable> parse_time_table(const std::string& text, const std::string& path) {
  if (text.find('\0') != std::string::npos) return std::nullopt;
  TextTable table(text, path, TextTable::Comments::anywhere);
  const std::optional<DateColumn> dates = DateColumn::in(table);
  if (!dates) return std::nullopt;
  TimeTable out;
  out.path = path;
  std::vector<std::size_t> kept;
  for (std::size_t column = 0; column < table.names().size(); ++column) {
    if (dates->holds(column)) continue;
    kept.push_back(column);
    out.names.push_back(table.names()[column]);
  }
  out.columns.resize(kept.size());
  while (table.next()) {
    out.instants.push_back(dates->date(table));
    out.lines.push_back(table.here().line);
    for (std::size_t k = 0; k < kept.size(); ++k) out.columns[k].push_back(table.cell(kept[k]));
  }
  if (out.instants.empty()) throw InputError({path, 0}, "the table holds no row");
  return out;
}

}  // namespace polhode
