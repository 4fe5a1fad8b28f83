#pragma once

#include <string>

#include "polhode/body/body.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {

/// A body from any file that describes one; its content, not its name, says which kind it is. Throws InputError with
/// file and line, FileError if it cannot be read.
Body read_body(const std::string& path, const ContentOf& content_of = read_text_file);

}  // namespace polhode
