#pragma once

#include <charconv>
#include <string>

namespace polhode {

/// A separator and the shortest decimal text that reads back as the same double, to the end of `out`.
inline void append_number(std::string& out, char separator, double value) {
  char text[32];
  text[0] = separator;
  out.append(text, std::to_chars(text + 1, text + sizeof text, value).ptr);
}

}  // namespace polhode
