#include "polhode/read/time_list.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/read/date_column.hpp"
#include "polhode/read/text.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

/// The column of dates of a table, whose line of names this is; nothing if it is not one.
struct DateColumn {
  DateReader read;
  bool comma = false;
  std::size_t cells = 0;
  std::size_t index = 0;

  static std::optional<DateColumn> of(std::string_view names_line, std::string_view header_scale) {
    DateColumn out;
    out.comma = names_line.find(',') != std::string_view::npos;
    const std::vector<std::string_view> names = table_cells(names_line, out.comma);
    out.cells = names.size();
    for (const std::string_view name : names) {
      out.read = date_column(name, header_scale);
      if (out.read) return out;
      ++out.index;
    }
    return std::nullopt;
  }

  Instant date(std::string_view line) const {
    const std::vector<std::string_view> in_line = table_cells(line, comma);
    if (in_line.size() != cells) {
      throw InputError(fmt::format("{} cells; {} are wanted", in_line.size(), cells));
    }
    return read(in_line[index]);
  }
};

}  // namespace

std::vector<Instant> read_time_list(const std::string& list_or_path, std::optional<TimeScale> missing) {
  std::error_code not_a_path;
  if (std::filesystem::exists(list_or_path, not_a_path)) {
    return parse_time_lines(read_text_file(list_or_path), missing, list_or_path);
  }
  std::vector<Instant> instants;
  std::string_view rest = list_or_path;
  for (;;) {
    const std::size_t comma = rest.find(',');
    try {
      instants.push_back(parse_date_with_scale(trimmed(rest.substr(0, comma)), missing).instant);
    } catch (const InputError& error) {
      if (comma != std::string_view::npos || !instants.empty()) throw;
      throw InputError(fmt::format("there is no file '{}', and as a date: {}", list_or_path, error.what()));
    }
    if (comma == std::string_view::npos) return instants;
    rest.remove_prefix(comma + 1);
  }
}

std::vector<Instant> parse_time_lines(std::string_view text, std::optional<TimeScale> missing,
                                      const std::string& path) {
  std::vector<Instant> instants;
  std::string_view header_scale;
  std::optional<DateColumn> column;
  bool is_first = true;
  text = without_mark(text);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view whole = take_line(text);
    const std::string_view content = trimmed(whole.substr(0, whole.find('#')));
    try {
      if (content.empty()) {
        const std::string_view comment = trimmed(whole);
        if (comment.starts_with('#')) {
          const std::string_view scale = scale_in_ecsv_header(trimmed(comment.substr(1)));
          if (!scale.empty()) header_scale = scale;
        }
        continue;
      }
      if (is_first) column = DateColumn::of(content, header_scale);
      if (!column) {
        instants.push_back(parse_date_with_scale(content, missing).instant);
      } else if (!is_first) {
        instants.push_back(column->date(content));
      }
      is_first = false;
    } catch (const InputError& error) {
      throw InputError({path, line}, error.what());
    }
  }
  if (instants.empty()) throw InputError({path, 0}, "the list holds no date");
  return instants;
}

}  // namespace polhode
