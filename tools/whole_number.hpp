#pragma once

#include <CLI/App.hpp>
#include <cstddef>
#include <functional>
#include <string>

namespace polhode::tools {

/// The most that --max-evaluations takes: years of work.
inline constexpr std::size_t most_evaluations_asked = 1'000'000'000'000'000;

/// Adds an option that takes a whole decimal number from `least` to `most`: 010 is ten.
CLI::Option* add_whole_number(CLI::App& command, const std::string& name, std::function<void(std::size_t)> take,
                              std::size_t least, std::size_t most, const std::string& description);

/// The same into a variable, which may be optional.
template <class Number>
CLI::Option* add_whole_number(CLI::App& command, const std::string& name, Number& number, std::size_t least,
                              std::size_t most, const std::string& description) {
  const auto take = [&number](std::size_t given) { number = given; };
  return add_whole_number(command, name, std::function<void(std::size_t)>(take), least, most, description);
}

}  // namespace polhode::tools
