#pragma once

#include <CLI/App.hpp>

namespace polhode::tools {

// Each adds its subcommand to the program; the work is done in the callback, which throws InputError or FileError.
void add_eval(CLI::App& app);

}  // namespace polhode::tools
