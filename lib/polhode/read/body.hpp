#pragma once

#include <optional>
#include <string>

#include "polhode/body/body.hpp"
#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {

/// A body from any file that describes one; its content, not its name, says which kind it is. Throws InputError with
/// file and line, FileError if it cannot be read.
Body read_body(const std::string& path, const ContentOf& content_of = read_text_file);

/// The same with the attitude history of the file, if it has one (read/attitude_history_file.hpp).
struct BodyAndHistory {
  Body body;
  std::optional<AttitudeHistory> history;
  bool is_table = false;  ///< of attitudes: the body is what its header and its first row say
};
BodyAndHistory read_body_and_history(const std::string& path, const ContentOf& content_of = read_text_file);

/// FILE#ROW names a row of a table, where there is no file that is called so.
struct RowOfFile {
  explicit RowOfFile(const std::string& path);
  std::string file;
  std::string row;
};

/// As read_body_and_history, from memory; `content_of` opens the files that this one names.
BodyAndHistory parse_body_and_history(const std::string& text, const RowOfFile& place, const ContentOf& content_of);

}  // namespace polhode
