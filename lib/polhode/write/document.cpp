#include "polhode/write/document.hpp"

#include <fmt/chrono.h>

#include <cstdlib>
#include <ctime>

namespace polhode {

std::string creator() { return "polhode " POLHODE_VERSION; }

std::string creation_date() {
  std::time_t now = std::time(nullptr);
  if (const char* given = std::getenv("SOURCE_DATE_EPOCH"))
    now = static_cast<std::time_t>(std::strtoll(given, nullptr, 10));
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(now));
}

}  // namespace polhode
