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
};

/// The table [inertia] of a body file: sets `body.inertia`, and notes what a mesh is like.
void read_inertia(const TomlTable& table, Body& body, const BodyFileSurroundings& around);

}  // namespace polhode
