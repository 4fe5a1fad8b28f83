#pragma once

#include <string_view>

namespace polhode::tools {

/// All of the text to standard output. Throws FileError if it does not arrive.
void write_standard_output(std::string_view text);

}  // namespace polhode::tools
