#pragma once

#include <optional>
#include <string>

#include "polhode/read/input_formats.hpp"

namespace polhode {

/// A body from any file that describes one; its content, not its name, says which kind it is. Throws InputError with
/// file and line, FileError if it cannot be read.
Body read_body(const std::string& path, const ContentOf& content_of = read_text_file);

/// The same with the attitude history of the file.
BodyAndHistory read_body_and_history(const std::string& path, const ContentOf& content_of = read_text_file);

/// As read_body_and_history, from memory; `content_of` opens the files that this one names.
BodyAndHistory parse_body_and_history(const std::string& text, const RowOfFile& place, const ContentOf& content_of);

/// The attitude history in a file, or nothing if its format has none.
std::optional<AttitudeHistory> read_attitude_history(const std::string& path);

/// The same from memory; `name` stands for the file in messages.
std::optional<AttitudeHistory> parse_attitude_history(const std::string& text, const std::string& name);

}  // namespace polhode
