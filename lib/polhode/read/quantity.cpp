#include "polhode/read/quantity.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

struct Quantity {
  std::string number;
  std::string_view unit;
};

/// Splits "1.5 min"; without a unit it is `usual`.
Quantity quantity(std::string_view text, const char* what, std::string_view usual) {
  std::string_view number = trimmed(text);
  if (number.starts_with('+')) number.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc{} || !std::isfinite(value)) {
    throw InputError(
        fmt::format("'{:.60}' is no {}: a number with its unit is wanted, as '1.5 {}'", text, what, usual));
  }
  const std::string_view unit = trimmed(std::string_view(end, number.data() + number.size()));
  return {std::string(number.data(), end), unit.empty() ? usual : unit};
}

/// Runs `factor` of the unit; its error says what the text was to be.
template <class Factor>
double unit_of(const Quantity& quantity, std::string_view text, const char* what, const Factor& factor) {
  try {
    return factor(quantity.unit);
  } catch (const InputError& error) {
    throw InputError(fmt::format("'{:.60}' is no {}: {}", text, what, error.what()));
  }
}

}  // namespace

Seconds parse_duration(std::string_view text) {
  const Quantity q = quantity(text, "span of time", "s");
  const double unit_s = unit_of(q, text, "span of time", duration_unit_s);
  const double high = std::strtod(q.number.c_str(), nullptr);
  const long double rest = std::strtold(q.number.c_str(), nullptr) - static_cast<long double>(high);
  const Seconds span = exact_product(high, unit_s) + Seconds{static_cast<double>(rest) * unit_s, 0.0};
  constexpr double longest_s = 1e18;  // the age of the universe, twice
  if (std::abs(span.high) <= longest_s) return span;
  throw InputError(fmt::format("'{:.60}' is too long a span of time; at most {:g} s", text, longest_s));
}

double parse_angle_rad(std::string_view text) {
  const Quantity q = quantity(text, "angle", "rad");
  return std::strtod(q.number.c_str(), nullptr) * unit_of(q, text, "angle", angle_unit_rad);
}

double parse_tolerance_rad(std::string_view text) {
  const double tolerance_rad = parse_angle_rad(text);
  if (tolerance_rad >= smallest_tolerance_rad) return tolerance_rad;
  throw InputError(fmt::format("found '{:.60}', an angle of {} rad or more is wanted: doubles hold no less", text,
                               smallest_tolerance_rad));
}

}  // namespace polhode
