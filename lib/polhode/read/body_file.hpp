#pragma once

#include <string>
#include <string_view>

#include "polhode/body/body.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {

/// A body file: TOML with the keys of tools/manual/body-files.md. `path` is for messages, and where a mesh
/// that it names is looked for. Throws InputError with file and line, FileError if the mesh cannot be read.
Body parse_body_file(std::string_view text, const std::string& path, const ContentOf& content_of = read_text_file);

}  // namespace polhode
