#include "polhode/read/text_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "polhode/base/error.hpp"

namespace polhode {

std::string read_text_file(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw InputError({path, 0}, "is a directory, a file is wanted");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw FileError("cannot open " + path + ": " + std::strerror(errno));
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) throw FileError("cannot read " + path + ": " + std::strerror(errno));
  if (text.str().empty()) throw InputError({path, 0}, "the file is empty");
  return std::move(text).str();
}

}  // namespace polhode
