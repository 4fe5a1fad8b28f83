#include "polhode/read/quantity.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <span>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/read/text.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

struct QuantityUnit {
  std::string_view name;
  double size;
};

struct Quantity {
  std::string number;
  double unit;
};

/// Splits "1.5 min" and looks up the unit, the first one if none stands there.
Quantity quantity(std::string_view text, const char* what, std::span<const QuantityUnit> units) {
  const std::string_view whole = trimmed(text);
  std::size_t end = whole.size();
  // A unit is the letters at the end, but the e of an exponent has digits behind it.
  while (end > 0 && std::isalpha(static_cast<unsigned char>(whole[end - 1])) != 0) --end;
  const std::string_view number = trimmed(whole.substr(0, end));
  const std::string_view unit = whole.substr(end);
  std::string allowed;
  const std::string_view wanted = unit.empty() ? units.front().name : unit;
  double size = 0.0;
  for (const QuantityUnit& u : units) {
    if (u.name == wanted) size = u.size;
    allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", u.name);
  }
  if (!parse_number(number) || size == 0.0) {
    throw InputError(fmt::format("'{:.60}' is no {}: a number, then one of {}", text, what, allowed));
  }
  return {std::string(number), size};
}

}  // namespace

Seconds parse_duration(std::string_view text) {
  constexpr std::array units{QuantityUnit{"s", 1.0}, QuantityUnit{"min", 60.0}, QuantityUnit{"h", hour_s},
                             QuantityUnit{"d", day_s}, QuantityUnit{"ms", 1e-3}};
  const Quantity q = quantity(text, "span of time", units);
  const double high = *parse_number(q.number);
  const long double rest = std::strtold(q.number.c_str(), nullptr) - static_cast<long double>(high);
  return exact_product(high, q.unit) + Seconds{static_cast<double>(rest) * q.unit, 0.0};
}

double parse_angle_rad(std::string_view text) {
  constexpr std::array units{QuantityUnit{"rad", 1.0},
                             QuantityUnit{"deg", degree},
                             QuantityUnit{"arcmin", degree / 60.0},
                             QuantityUnit{"arcsec", degree / 3600.0},
                             QuantityUnit{"mas", degree / 3.6e6},
                             QuantityUnit{"uas", degree / 3.6e9}};
  const Quantity q = quantity(text, "angle", units);
  return *parse_number(q.number) * q.unit;
}

}  // namespace polhode
