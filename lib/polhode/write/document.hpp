#pragma once

#include <string>
#include <string_view>

namespace polhode {

/// "polhode" and its version, for the headers of files.
std::string creator();

/// Now in UTC as "2000-01-01T12:00:00", or the instant of environment variable SOURCE_DATE_EPOCH (seconds since 1970),
/// with which the same input gives the same bytes.
std::string creation_date();

/// Text as a value on a line of a file: UTF-8, without blanks at its ends. A control character, an end of a line of any
/// kind, or what is no character, becomes a blank; bytes that are not UTF-8 become U+FFFD.
std::string plain_text(std::string_view text);

/// plain_text as a scalar of YAML in double quotes, which is a string of JSON, too.
std::string double_quoted(std::string_view text);

/// plain_text in ASCII, as FITS wants it: a question mark for each other character.
std::string ascii_text(std::string_view text);

}  // namespace polhode
