#pragma once

#include <CLI/App.hpp>
#include <cstddef>
#include <string>

namespace polhode::tools {

/// Adds an option that takes a whole decimal number from `least` to `most`: 010 is ten.
CLI::Option* add_whole_number(CLI::App& command, const std::string& name, std::size_t& number, std::size_t least,
                              std::size_t most, const std::string& description);

}  // namespace polhode::tools
