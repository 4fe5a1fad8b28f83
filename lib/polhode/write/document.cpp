#include "polhode/write/document.hpp"

#include <fmt/chrono.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <ctime>

namespace polhode {
namespace {

constexpr char32_t broken = 0xFFFD;

/// Takes the first character off UTF-8 text; a byte that begins none counts as `broken`.
char32_t take_character(std::string_view& text) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80 ? 1 : first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  constexpr std::array<char32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  constexpr std::array<unsigned, 5> mask{0, 0x7F, 0x1F, 0x0F, 0x07};
  char32_t character = first & mask[length];
  bool good = (first < 0x80 || first >= 0xC2) && first < 0xF5 && length <= text.size();
  for (std::size_t i = 1; good && i < length; ++i) {
    good = (byte(i) & 0xC0U) == 0x80;
    character = character << 6U | (byte(i) & 0x3FU);
  }
  const bool surrogate = character >= 0xD800 && character <= 0xDFFF;
  good = good && character >= least[length] && character <= 0x10FFFF && !surrogate;
  text.remove_prefix(good ? length : 1);
  return good ? character : broken;
}

bool is_blank(char32_t c) {
  const bool control = c < 0x20 || (c >= 0x7F && c < 0xA0);
  const bool ends_line = c == 0x2028 || c == 0x2029;
  const bool no_character = (c & 0xFFFEU) == 0xFFFE || (c >= 0xFDD0 && c <= 0xFDEF);
  return control || ends_line || no_character || c == ' ';
}

/// `text` with `put` for each character that is not blank.
template <class Put>
std::string cleaned(std::string_view text, const Put& put) {
  std::string out;
  std::size_t blanks = 0;  // not put yet
  while (!text.empty()) {
    const std::string_view before = text;
    const char32_t c = take_character(text);
    if (is_blank(c)) {
      ++blanks;
      continue;
    }
    if (!out.empty()) out.append(blanks, ' ');
    blanks = 0;
    put(out, c, before.substr(0, before.size() - text.size()));
  }
  return out;
}

}  // namespace

std::string plain_text(std::string_view text) {
  return cleaned(text, [](std::string& out, char32_t c, std::string_view bytes) {
    out += c == broken ? std::string_view("\xEF\xBF\xBD") : bytes;
  });
}

std::string double_quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : plain_text(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string ascii_text(std::string_view text) {
  return cleaned(text,
                 [](std::string& out, char32_t c, std::string_view) { out += c < 0x7F ? static_cast<char>(c) : '?'; });
}

std::string creator() { return "polhode " POLHODE_VERSION; }

std::string creation_date() {
  std::time_t now = std::time(nullptr);
  if (const char* given = std::getenv("SOURCE_DATE_EPOCH"))
    now = static_cast<std::time_t>(std::strtoll(given, nullptr, 10));
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(now));
}

}  // namespace polhode
