#pragma once

#include <string>

#include "polhode/body/body.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/toml_table.hpp"
#include "polhode/read/uncertain_numbers.hpp"

namespace polhode {

/// What reading a body file has to do with besides the table at hand.
struct BodyFileSurroundings {
  const std::string& path;
  const ContentOf& content_of;
  UncertainNumbers& numbers;
  bool wants_changes = false;  ///< what numbers do is asked for, where that takes time
  bool is_clone = false;       ///< with numbers that the file does not have: what it says of them need not hold
};

/// The table [inertia] of a body file; notes what a mesh is like.
Inertia read_inertia(const TomlTable& table, Body& body, const BodyFileSurroundings& around);

}  // namespace polhode
