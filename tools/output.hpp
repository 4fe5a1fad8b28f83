#pragma once

#include <numbers>
#include <string>
#include <string_view>

namespace polhode::tools {

inline constexpr double degrees = 180.0 / std::numbers::pi;  ///< in a radian

/// All of the text to standard output. Throws FileError if it does not arrive.
void write_standard_output(std::string_view text);

/// The text for a terminal: control characters, which could move its cursor and change its colours, as \x1b and the
/// like, ends of lines too.
std::string printable(std::string_view text);

/// "polhode: ", the text as printable() has it and the end of a line to standard error. Of a very long text the middle
/// is left out. A standard error that is closed or full is nobody's failure: the exit status says what became of the
/// output.
void say(std::string_view text);

/// "polhode: warning: FILE: …"; the file once, where the warning begins with it.
void warn(std::string_view file, std::string_view warning);

}  // namespace polhode::tools
