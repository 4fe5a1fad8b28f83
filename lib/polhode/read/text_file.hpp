#pragma once

#include <string>

namespace polhode {

/// The whole of a file as bytes. Throws InputError for a directory and for an empty file, FileError where it cannot be
/// read.
std::string read_text_file(const std::string& path);

}  // namespace polhode
