#include "polhode/write/column_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/ephemeris/time_grid.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/number_table.hpp"
#include "polhode/write/number_text.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {
namespace {

/// The unit that the end of a column's name says.
std::string_view unit_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> endings{
      {{"_deg", "deg"}, {"_m2", "m2"}, {"_m", "m"}, {"_s", "s"}}};
  if (name.ends_with("magnitude")) return "mag";
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

/// A cell's number; none in it is NaN.
std::optional<double> number_in(const std::string& cell) {
  if (const std::string lower = lower_case(cell); lower.empty() || lower == "nan") return std::nan("");
  return parse_number(cell);
}

bool are_numbers(const ColumnTable::KeptColumn& column) {
  const auto is_number = [](const std::string& cell) { return parse_number(cell).has_value(); };
  return std::any_of(column.cells.begin(), column.cells.end(), is_number) &&
         std::all_of(column.cells.begin(), column.cells.end(),
                     [](const std::string& cell) { return number_in(cell).has_value(); });
}

std::string header_of(const ColumnTable& table, const std::string& date, const std::string& scale) {
  std::string out = "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n";
  out += fmt::format("# - {{name: {}, datatype: string}}\n", date);
  for (const auto& column : table.numbers) {
    const std::string_view unit = unit_of(column.name);
    out += fmt::format("# - {{name: {}, datatype: float64{}{}}}\n", column.name, unit.empty() ? "" : ", unit: ", unit);
  }
  for (const auto& column : table.kept) {
    out += fmt::format("# - {{name: {}, datatype: {}}}\n", double_quoted(column.name),
                       are_numbers(column) ? "float64" : "string");
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

/// As FITS can have it: '_' for a character beyond ASCII, and no longer than a card.
std::string fits_name(const std::string& name) {
  constexpr std::size_t longest = 60;
  std::string out;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80U) out += c;
    if (byte >= 0xC0U) out += '_';  // where a character of several bytes begins
  }
  return out.substr(0, longest);
}

/// The table with a name for every kept column that no other column has, be its letters small or capital, as FITS
/// takes them for the same: "given_" before those of ours, "_2" and so on behind those that come twice.
ColumnTable with_names_of_their_own(ColumnTable table, const std::string& date, bool fits) {
  std::set<std::string> ours{lower_case(date), "time"};
  for (const auto& column : table.numbers) ours.insert(lower_case(column.name));
  std::set<std::string> taken = ours;
  for (std::size_t i = 0; i < table.kept.size(); ++i) {
    std::string& name = table.kept[i].name;
    if (fits) name = fits_name(name);
    if (name.empty()) name = fmt::format("column_{}", i + 1);
    if (ours.contains(lower_case(name)) || lower_case(name).starts_with("date_")) name.insert(0, "given_");
    const std::string first_name = name;
    for (int again = 2; !taken.insert(lower_case(name)).second; ++again) name = fmt::format("{}_{}", first_name, again);
  }
  return table;
}

/// A column of texts as their places among those that differ.
NumberColumn labels_of(const ColumnTable::KeptColumn& column, std::vector<double>& places) {
  NumberColumn out{column.name, {column.name}, "", NumberColumn::Kind::label, {}};
  std::map<std::string_view, double> known;
  for (const std::string& cell : column.cells) {
    const auto [at, is_new] = known.emplace(cell, static_cast<double>(out.labels.size()));
    if (is_new) out.labels.push_back(cell);
    places.push_back(at->second);
  }
  return out;
}

void write_fits_columns(const std::string& path, const ColumnTable& table) {
  NumberTable out;
  out.extension = "OBSERVED";
  out.rows = table.dates.size();
  std::vector<Instant> sorted = table.instants;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  const TimeGrid grid = TimeGrid::of_list(sorted, table.scale);
  std::vector<std::vector<double>> columns(1);
  for (const Instant& instant : table.instants) {
    const auto at = std::lower_bound(sorted.begin(), sorted.end(), instant) - sorted.begin();
    columns[0].push_back(grid.time(static_cast<std::size_t>(at), {}).high);
  }
  out.columns.push_back({"TIME", {"time"}, "s"});
  for (const auto& column : table.numbers) {
    out.columns.push_back({column.name, {column.name}, std::string(unit_of(column.name))});
    columns.push_back(column.values);
  }
  for (const auto& column : table.kept) {
    std::vector<double>& values = columns.emplace_back();
    if (are_numbers(column)) {
      out.columns.push_back({column.name, {column.name}, ""});
      for (const std::string& cell : column.cells) values.push_back(*number_in(cell));
    } else {
      out.columns.push_back(labels_of(column, values));
    }
  }
  const auto text = [&out](const char* keyword, const std::string& value, const char* comment) {
    out.entries.push_back({keyword, "", value, 0.0, false, comment});
  };
  text("TIMESYS", std::string(name(table.scale)), "time scale of TIME, of reception");
  out.entries.push_back({"MJDREF", "", "", grid.reference_mjd(), true, "[d] TIME counts from this MJD"});
  text("TIMEUNIT", "s", "unit of TIME");
  for (const auto& [key, value] : table.about) {
    if (key == "object") {
      text("OBJECT", value, "body");
    } else {
      out.comments.push_back(fmt::format("{}: {}", key, value));
    }
  }
  write_number_table(path, out, [&columns](std::size_t first, std::span<double> to) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = columns[i % columns.size()][first + i / columns.size()];
  });
}

}  // namespace

void write_column_table(const std::string& path, const ColumnTable& table) {
  const bool ecsv = lower_case(path).ends_with(".ecsv"), fits = is_fits_path(path);
  if ((ecsv || fits) && (table.scale == TimeScale::et || table.scale == TimeScale::gps)) {
    throw TimeScaleError(fmt::format("astropy knows no time scale {}; take TDB, UTC, TAI or TT", name(table.scale)));
  }
  const std::string scale = lower_case(name(table.scale)), date = "date_" + scale;
  const ColumnTable named = with_names_of_their_own(table, date, fits);
  if (fits) {
    write_fits_columns(path, named);
    return;
  }
  OutputBytes file(path);
  std::string text = ecsv ? header_of(named, date, scale) : std::string();
  text += date;
  for (const auto& column : named.numbers) text += "," + column.name;
  for (const auto& column : named.kept) text += "," + kept_cell(column.name);
  text += '\n';
  constexpr std::size_t enough = std::size_t{1} << 20U;
  for (std::size_t row = 0; row < named.dates.size(); ++row) {
    text += named.dates[row];
    for (const auto& column : named.numbers) append_number(text, ',', column.values[row]);
    for (const auto& column : named.kept) text.append(",").append(kept_cell(column.cells[row]));
    text += '\n';
    if (text.size() < enough) continue;
    file.write(text);
    text.clear();
  }
  file.write(text);
  file.commit();
}

}  // namespace polhode
