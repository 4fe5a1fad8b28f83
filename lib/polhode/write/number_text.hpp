#pragma once

#include <charconv>
#include <string>
#include <string_view>

namespace polhode {

/// A separator and the shortest decimal text that reads back as the same double, to the end of `out`.
inline void append_number(std::string& out, char separator, double value) {
  char text[32];
  text[0] = separator;
  out.append(text, std::to_chars(text + 1, text + sizeof text, value).ptr);
}
inline void append_number(std::string& out, std::string_view before, double value) {
  out.append(before.substr(0, before.size() - 1));
  append_number(out, before.back(), value);
}

}  // namespace polhode
