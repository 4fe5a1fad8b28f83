#pragma once

#include <charconv>
#include <string>

namespace polhode {

/// The shortest decimal text that reads back as the same double, to the end of `out`.
inline void append_number(std::string& out, double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  out.append(text, end);
}

}  // namespace polhode
