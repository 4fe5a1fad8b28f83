#include "polhode/time/duration_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace polhode {

std::string duration_text(double seconds) {
  constexpr double minute_s = 60.0, hour_s = 3600.0, day_s = 86400.0, year_s = 365.25 * day_s;
  const double size_s = std::abs(seconds);
  if (size_s < 2.0 * minute_s) return fmt::format("{:.3g} s", seconds);
  if (size_s < 2.0 * hour_s) return fmt::format("{:.3g} min", seconds / minute_s);
  if (size_s < 2.0 * day_s) return fmt::format("{:.3g} h", seconds / hour_s);
  if (size_s < 2.0 * year_s) return fmt::format("{:.3g} d", seconds / day_s);
  return fmt::format("{:.3g} years", seconds / year_s);
}

}  // namespace polhode
