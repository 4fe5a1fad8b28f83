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

void say(std::string_view text) {
  constexpr std::size_t most = 1000, kept_at_begin = 600, kept_at_end = 300;
  std::string shown(text);
  if (shown.size() > most) shown.replace(kept_at_begin, shown.size() - kept_at_begin - kept_at_end, " [...] ");
  std::string line = "polhode: ";
  for (const char c : shown) {
    const bool is_control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    is_control ? line += fmt::format("\\x{:02x}", c) : line += c;
  }
  line += '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace polhode::tools
