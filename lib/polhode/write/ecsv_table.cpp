#include "polhode/write/ecsv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "polhode/write/document.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {

namespace {

std::string csv(const std::string& text) {
  if (!text.empty() && text.find_first_of(",\"\n ") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
  return out;
}

}  // namespace

void write_ecsv_table(const std::string& path, const std::vector<std::string>& comments,
                      const std::vector<EcsvColumn>& columns, const std::vector<std::vector<std::string>>& rows) {
  std::string text = "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n";
  for (const EcsvColumn& c : columns) {
    fmt::format_to(std::back_inserter(text), "# - {{name: {}, {}datatype: {}, description: {}}}\n", c.name,
                   c.unit.empty() ? "" : fmt::format("unit: {}, ", c.unit), c.datatype, double_quoted(c.description));
  }
  if (!comments.empty()) text += "# meta:\n#   comments:\n";
  for (const std::string& c : comments) fmt::format_to(std::back_inserter(text), "#   - {}\n", double_quoted(c));
  text += "# schema: astropy-2.0\n";
  std::vector<std::string> fields(columns.size());
  std::transform(columns.begin(), columns.end(), fields.begin(), [](const EcsvColumn& c) { return c.name; });
  fmt::format_to(std::back_inserter(text), "{}\n", fmt::join(fields, ","));
  for (const std::vector<std::string>& row : rows) {
    fields.resize(row.size());
    std::transform(row.begin(), row.end(), fields.begin(), csv);
    fmt::format_to(std::back_inserter(text), "{}\n", fmt::join(fields, ","));
  }
  OutputBytes file(path);
  file.write(text);
  file.commit();
}

}  // namespace polhode
