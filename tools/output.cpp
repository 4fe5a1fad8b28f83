#include "output.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "polhode/base/error.hpp"

namespace polhode::tools {

void write_standard_output(std::string_view text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    throw FileError(std::string("cannot write to standard output: ") + std::strerror(errno));
  }
}

}  // namespace polhode::tools
