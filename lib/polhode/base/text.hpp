#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace polhode {

/// The finite decimal number that is all of `text` (a leading + is allowed), or nothing.
std::optional<double> parse_number(std::string_view text);

/// The decimal integer that is all of `text` (a leading + is allowed), or nothing.
std::optional<long long> parse_integer(std::string_view text);

/// Without white space at either end.
std::string_view trimmed(std::string_view text);

/// Without a byte-order mark.
std::string_view without_mark(std::string_view text);

/// ASCII letters in upper case; in lower case.
std::string upper_case(std::string_view text);
std::string lower_case(std::string_view text);

/// Takes the next word between white space off `text`; empty if none is left.
std::string_view take_word(std::string_view& text);

/// The words between white space.
std::vector<std::string_view> split_words(std::string_view text);

/// Whether `word` is one of the words between white space.
bool contains_word(std::string_view words, std::string_view word);

/// FNV-1a: whether two texts are the same; nobody is kept from making others that look so.
std::uint64_t text_digest(std::string_view text);

/// Takes the next line off `text`, without its end (LF, CR LF or CR).
std::string_view take_line(std::string_view& text);

}  // namespace polhode
