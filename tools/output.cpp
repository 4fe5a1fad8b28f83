#include "output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode::tools {

void write_standard_output(std::string_view text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return;
  const std::string message = std::string("cannot write to standard output: ") + std::strerror(errno);
  if (errno == EPIPE) throw PipeClosed(message);
  throw FileError(message);
}

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : '\0');
    if (c < 0x20 || c == 0x7f) {
      out += fmt::format("\\x{:02x}", c);
    } else if (c == 0xc2 && next >= 0x80 && next < 0xa0) {  // U+0080 to U+009F
      out += fmt::format("\\x{:02x}", next);
      ++i;
    } else {
      out += text[i];
    }
  }
  return out;
}

void say(std::string_view text) {
  constexpr std::size_t most = 1000, kept_at_begin = 600, kept_at_end = 300;
  std::string shown(text);
  if (shown.size() > most) shown.replace(kept_at_begin, shown.size() - kept_at_begin - kept_at_end, " [...] ");
  const std::string line = "polhode: " + printable(shown) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

void warn(std::string_view file, std::string_view warning) {
  say(warning.starts_with(file) ? fmt::format("warning: {}", warning) : fmt::format("warning: {}: {}", file, warning));
}

}  // namespace polhode::tools
