#include "utc.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cstdio>

#include <string>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/read/leap_seconds_file.hpp"
#include "polhode/time/scale.hpp"

namespace polhode::tools {

namespace {
std::string leap_seconds_path;
}

const std::string& leap_seconds_file() { return leap_seconds_path; }

void add_leap_seconds(CLI::App& command) {
  command.add_option_function<std::string>(
      "--leap-seconds",
      [](const std::string& path) {
        const std::vector<LeapSecond> table = read_leap_seconds(path);
        in_file(path, [&] { set_leap_seconds(table); });
        leap_seconds_path = path;
      },
      "table of leap seconds to use: a NAIF leap-second kernel");
}

void UtcDoubts::look_at(Instant instant) {
  if (said_) return;
  if (const auto doubt = utc_doubt(instant)) {
    say(fmt::format("note: {}: {}", format_date(instant, TimeScale::utc, 0), *doubt));
    said_ = true;
  }
}

}  // namespace polhode::tools
