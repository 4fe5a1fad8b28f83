#include "output.hpp"

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
  const std::string line = "polhode: " + std::string(text) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace polhode::tools
