#pragma once

#include <string>
#include <string_view>

#include "polhode/body/body.hpp"

namespace polhode {

/// A body file: TOML with the keys of tools/manual/body-files.md. `path` is for messages. Throws InputError with file
/// and line.
Body parse_body_file(std::string_view text, const std::string& path);

}  // namespace polhode
