#pragma once

#include <CLI/App.hpp>
#include <string>

#include "polhode/time/instant.hpp"

namespace polhode::tools {

/// Adds --leap-seconds, the table to use in place of ERFA's.
void add_leap_seconds(CLI::App& command);

/// The file that --leap-seconds named; empty: none.
const std::string& leap_seconds_file();

/// Doubtful UTC is converted all the same, and said once on standard error.
class UtcDoubts {
 public:
  void look_at(Instant instant);

 private:
  bool said_ = false;
};

}  // namespace polhode::tools
