#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "polhode/body/body.hpp"
#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {

/// A body, and the attitude history of its file, if that has one.
struct BodyAndHistory {
  Body body;
  std::optional<AttitudeHistory> history;
  bool is_table = false;  ///< of attitudes: the body is what its header and its first row say
};

/// FILE#ROW names a row of a table, where there is no file that is called so.
struct RowOfFile {
  explicit RowOfFile(const std::string& path);
  std::string file;
  std::string row;
};

/// A format that bodies and attitude histories are read from. Help, messages and the manual's list are made from, or
/// held against, the table of these; so are the tests and fuzzers of every format.
struct InputFormat {
  std::string_view name;       ///< "CCSDS messages (KVN, XML)"
  std::string_view histories;  ///< what of it holds an attitude history: "AEM, ACM"; empty: none does
  std::string_view samples;    ///< the folder below data/ with samples of it
  bool (*recognises)(std::string_view text);
  /// `place` is for messages; `content_of` opens the files that this one names. Throws InputError with file and line,
  /// FileError if a file that it names cannot be read.
  BodyAndHistory (*read)(const std::string& text, const RowOfFile& place, const ContentOf& content_of);
};

/// All of them, in the order in which a content is held against them.
std::span<const InputFormat> input_formats();

/// The first that recognises the content; null if none does.
const InputFormat* input_format_of(std::string_view text);

/// "CCSDS messages (KVN, XML), tables of attitudes (FITS, CSV, ECSV), …"
std::string names_of_input_formats();

/// "AEM, ACM, FITS, …": those that hold an attitude history.
std::string names_of_histories();

}  // namespace polhode
