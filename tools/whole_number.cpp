#include "whole_number.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"

namespace polhode::tools {

CLI::Option* add_whole_number(CLI::App& command, const std::string& name, std::function<void(std::size_t)> take,
                              std::size_t least, std::size_t most, const std::string& description) {
  const auto read = [take = std::move(take), name, least, most](const std::string& text) {
    const std::optional<long long> value = parse_integer(text);
    if (!value || *value < static_cast<long long>(least) || *value > static_cast<long long>(most)) {
      throw InputError(
          fmt::format("{}: found '{:.40}', a whole number from {} to {} is wanted", name, text, least, most));
    }
    take(static_cast<std::size_t>(*value));
  };
  return command.add_option_function<std::string>(name, read, description)->type_name("UINT");
}

}  // namespace polhode::tools
