#pragma once

#include <numbers>
#include <string_view>

namespace polhode::tools {

inline constexpr double degrees = 180.0 / std::numbers::pi;  ///< in a radian

/// All of the text to standard output. Throws FileError if it does not arrive.
void write_standard_output(std::string_view text);

/// "polhode: ", the text and the end of a line to standard error. As a text may quote what a file holds, control
/// characters are written as \x1b and the like, and of a very long text the middle is left out. A standard error that
/// is closed or full is nobody's failure: the exit status says what became of the output.
void say(std::string_view text);

}  // namespace polhode::tools
