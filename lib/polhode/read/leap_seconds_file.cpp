#include "polhode/read/leap_seconds_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

struct Word {
  std::string text;  // upper case
  std::size_t line;
};

// The words of all data blocks; parentheses, commas and equal signs separate, = being a word of its own.
std::vector<Word> data_words(std::string_view text) {
  std::vector<Word> words;
  bool in_data = false;
  std::size_t line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find("\\begindata") != std::string::npos || line.find("\\begintext") != std::string::npos) {
      in_data = line.find("\\begindata") != std::string::npos;
      continue;
    }
    if (!in_data) continue;
    std::string word;
    const auto finish = [&] {
      if (!word.empty()) words.push_back({word, line_number});
      word.clear();
    };
    for (const char c : line) {
      const auto byte = static_cast<unsigned char>(c);
      if (c == '=') {
        finish();
        words.push_back({"=", line_number});
      } else if (std::isspace(byte) != 0 || c == ',' || c == '(' || c == ')') {
        finish();
      } else {
        word += static_cast<char>(std::toupper(byte));
      }
    }
    finish();
  }
  return words;
}

// "@1972-JAN-1"
LeapSecond month_of(const Word& word, const std::string& path) {
  constexpr std::array<std::string_view, 12> months{"JAN", "FEB", "MAR", "APR", "MAY", "JUN",
                                                    "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"};
  const std::string_view text = word.text;
  const auto month = std::find(months.begin(), months.end(), text.size() == 11 ? text.substr(6, 3) : "");
  int year = 0;
  const bool good = month != months.end() && text[0] == '@' && text[5] == '-' && text.substr(9) == "-1" &&
                    std::from_chars(text.data() + 1, text.data() + 5, year).ptr == text.data() + 5;
  if (!good) {
    throw InputError({path, word.line},
                     fmt::format("found '{:.40}', the first day of a month is wanted, as @1972-JAN-1", word.text));
  }
  return {year, static_cast<int>(month - months.begin()) + 1, 0.0};
}

}  // namespace

std::vector<LeapSecond> read_leap_seconds(const std::string& path) {
  return parse_leap_seconds(read_text_file(path), path);
}

std::vector<LeapSecond> parse_leap_seconds(std::string_view text, const std::string& path) {
  const std::vector<Word> words = data_words(text);
  const auto key =
      std::find_if(words.begin(), words.end(), [](const Word& word) { return word.text == "DELTET/DELTA_AT"; });
  if (words.end() - key < 2 || key[1].text != "=") {
    throw InputError({path, 0}, "no DELTET/DELTA_AT in a \\begindata block; a NAIF leap-second kernel is wanted");
  }
  std::vector<LeapSecond> table;
  for (auto word = key + 2; word != words.end() && (word + 1 == words.end() || word[1].text != "="); word += 2) {
    double offset_s = 0.0;
    const char* end = word->text.data() + word->text.size();
    if (std::from_chars(word->text.data(), end, offset_s).ptr != end) {
      throw InputError({path, word->line}, fmt::format("found '{:.40}', seconds of TAI - UTC are wanted", word->text));
    }
    if (word + 1 == words.end()) throw InputError({path, word->line}, "seconds of TAI - UTC without their date");
    table.push_back(month_of(word[1], path));
    table.back().tai_minus_utc_s = offset_s;
  }
  return table;
}

}  // namespace polhode
