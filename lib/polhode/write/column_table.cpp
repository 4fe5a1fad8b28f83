#include "polhode/write/column_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/number_text.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {
namespace {

/// The unit that the end of a column's name says.
std::string_view unit_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> endings{
      {{"_deg", "deg"}, {"_m2", "m2"}, {"_m", "m"}, {"_s", "s"}}};
  if (name == "magnitude") return "mag";
  for (const auto& [ending, unit] : endings) {
    if (name.ends_with(ending)) return unit;
  }
  return {};
}

std::string kept_cell(const std::string& text) {
  if (text.find_first_of(",\"#\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + "\"";
}

std::string header_of(const ColumnTable& table, const std::string& date, const std::string& scale) {
  std::string out = "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n";
  out += fmt::format("# - {{name: {}, datatype: string}}\n", date);
  for (const auto& column : table.numbers) {
    const std::string_view unit = unit_of(column.name);
    out += fmt::format("# - {{name: {}, datatype: float64{}{}}}\n", column.name, unit.empty() ? "" : ", unit: ", unit);
  }
  for (const auto& column : table.kept) {
    const bool numbers = std::all_of(column.cells.begin(), column.cells.end(),
                                     [](const std::string& cell) { return parse_number(cell).has_value(); });
    out += fmt::format("# - {{name: {}, datatype: {}}}\n", double_quoted(column.name), numbers ? "float64" : "string");
  }
  out += "# meta: !!omap\n";
  for (const auto& [key, text] : table.about) out += fmt::format("# - {{{}: {}}}\n", key, double_quoted(text));
  out += fmt::format(
      "# - __serialized_columns__:\n#     {0}:\n#       __class__: astropy.time.core.Time\n#       format: isot\n"
      "#       precision: {1}\n#       scale: {2}\n#       value: !astropy.table.SerializedColumn {{name: {0}}}\n"
      "# schema: astropy-2.0\n",
      date, std::min(table.decimals, 9), scale);
  return out;
}

}  // namespace

bool is_column_table(const std::string& path) {
  const std::string lower = lower_case(path);
  return lower.ends_with(".csv") || lower.ends_with(".ecsv");
}

void write_column_table(const std::string& path, const ColumnTable& table, bool ecsv) {
  if (ecsv && (table.scale == TimeScale::et || table.scale == TimeScale::gps)) {
    throw TimeScaleError(fmt::format("astropy knows no time scale {}; take TDB, UTC, TAI or TT", name(table.scale)));
  }
  const std::string scale = lower_case(name(table.scale)), date = "date_" + scale;
  OutputBytes file(path);
  std::string text = ecsv ? header_of(table, date, scale) : std::string();
  text += date;
  for (const auto& column : table.numbers) text += "," + column.name;
  for (const auto& column : table.kept) text += "," + kept_cell(column.name);
  text += '\n';
  constexpr std::size_t enough = std::size_t{1} << 20U;
  for (std::size_t row = 0; row < table.dates.size(); ++row) {
    text += table.dates[row];
    for (const auto& column : table.numbers) append_number(text, ',', column.values[row]);
    for (const auto& column : table.kept) text.append(",").append(kept_cell(column.cells[row]));
    text += '\n';
    if (text.size() < enough) continue;
    file.write(text);
    text.clear();
  }
  file.write(text);
  file.commit();
}

}  // namespace polhode
