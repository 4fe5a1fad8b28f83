#include "polhode/read/body.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/read/range.hpp"

namespace polhode {

Body read_body(const std::string& path, const ContentOf& content_of) {
  return read_body_and_history(path, content_of).body;
}

BodyAndHistory read_body_and_history(const std::string& path, const ContentOf& content_of) {
  const RowOfFile place(path);
  return parse_body_and_history(content_of(place.file), place, content_of);
}

BodyAndHistory parse_body_and_history(const std::string& text, const RowOfFile& place, const ContentOf& content_of) {
  if (text.starts_with("{\"")) {
    throw InputError(
        {place.file, 0},
        "looks like JSON lines, which are written but not read; attitudes are read from " + names_of_histories());
  }
  const InputFormat* format = input_format_of(text);
  if (format == nullptr)
    throw InputError({place.file, 0}, fmt::format("no kind of file that is known: {}", names_of_input_formats()));
  BodyAndHistory found = format->read(text, place, content_of);
  located({place.file, 0}, [&] { check_range(found.body); });
  return found;
}

std::optional<AttitudeHistory> read_attitude_history(const std::string& path) {
  return parse_attitude_history(read_text_file(path), path);
}

std::optional<AttitudeHistory> parse_attitude_history(const std::string& text, const std::string& name) {
  const InputFormat* format = input_format_of(text);
  if (format == nullptr || format->histories.empty()) return std::nullopt;
  return format->read(text, RowOfFile(name), read_text_file).history;
}

}  // namespace polhode
