#include "polhode/read/time_list.hpp"

#include <filesystem>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/read/text.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {

std::vector<Instant> read_time_list(const std::string& list_or_path, TimeScale missing) {
  std::vector<Instant> instants;
  std::error_code not_a_path;
  if (!std::filesystem::exists(list_or_path, not_a_path)) {
    std::string_view rest = list_or_path;
    for (;;) {
      const std::size_t comma = rest.find(',');
      instants.push_back(parse_date_with_scale(trimmed(rest.substr(0, comma)), missing).instant);
      if (comma == std::string_view::npos) return instants;
      rest.remove_prefix(comma + 1);
    }
  }
  return parse_time_lines(read_text_file(list_or_path), missing, list_or_path);
}

std::vector<Instant> parse_time_lines(std::string_view text, TimeScale missing, const std::string& path) {
  std::vector<Instant> instants;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view whole = take_line(text);
    const std::string_view date = trimmed(whole.substr(0, whole.find('#')));
    if (date.empty()) continue;
    try {
      instants.push_back(parse_date_with_scale(date, missing).instant);
    } catch (const InputError& error) {
      throw InputError({path, line}, error.what());
    }
  }
  return instants;
}

}  // namespace polhode
