#pragma once

#include <string>

#include "polhode/body/body.hpp"

namespace polhode {

/// A body from any file that describes one; its content, not its name, says which kind it is. Throws InputError with
/// file and line, FileError if it cannot be read.
Body read_body(const std::string& path);

}  // namespace polhode
