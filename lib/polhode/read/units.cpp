#include "polhode/read/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"

namespace polhode {
namespace {

/// A size as a fraction, so that deg/day is one division, and the powers of degrees, radians, time, length and mass.
/// Angles count as a kind of their own: deg/s is no frequency.
struct Unit {
  double numerator = 1.0;
  double denominator = 1.0;
  std::array<double, 5> powers{};

  bool measures_as(const Unit& other) const {
    return powers[0] + powers[1] == other.powers[0] + other.powers[1] &&
           std::equal(powers.begin() + 2, powers.end(), other.powers.begin() + 2);
  }
};

struct NamedUnit {
  std::string_view name;
  Unit unit;
};

constexpr std::array<double, 5> of_angle{1, 0, 0, 0, 0}, of_duration{0, 0, 1, 0, 0}, of_length{0, 0, 0, 1, 0},
    of_mass{0, 0, 0, 0, 1}, of_force{0, 0, -2, 1, 1};

// A slug is 0.45359237 kg times 9.80665 / 0.3048; exact by definition, as the au is.
constexpr std::array<NamedUnit, 33> named_units{{{"deg", {1, 1, of_angle}},
                                                 {"rad", {1, 1, {0, 1, 0, 0, 0}}},
                                                 {"arcmin", {1, 60, of_angle}},
                                                 {"arcsec", {1, 3600, of_angle}},
                                                 {"mas", {1, 3.6e6, of_angle}},
                                                 {"uas", {1, 3.6e9, of_angle}},
                                                 {"rev", {360, 1, of_angle}},
                                                 {"rpm", {6, 1, {1, 0, -1, 0, 0}}},
                                                 {"s", {1, 1, of_duration}},
                                                 {"ms", {1e-3, 1, of_duration}},
                                                 {"us", {1e-6, 1, of_duration}},
                                                 {"min", {60, 1, of_duration}},
                                                 {"h", {hour_s, 1, of_duration}},
                                                 {"d", {day_s, 1, of_duration}},
                                                 {"day", {day_s, 1, of_duration}},
                                                 {"m", {1, 1, of_length}},
                                                 {"km", {1e3, 1, of_length}},
                                                 {"cm", {1e-2, 1, of_length}},
                                                 {"mm", {1e-3, 1, of_length}},
                                                 {"ft", {0.3048, 1, of_length}},
                                                 {"au", {149597870700.0, 1, of_length}},
                                                 {"AU", {149597870700.0, 1, of_length}},
                                                 {"kg", {1, 1, of_mass}},
                                                 {"g", {1e-3, 1, of_mass}},
                                                 {"t", {1e3, 1, of_mass}},
                                                 {"slug", {0.45359237 * 9.80665, 0.3048, of_mass}},
                                                 {"N", {1, 1, of_force}},
                                                 {"mN", {1e-3, 1, of_force}},
                                                 {"kN", {1e3, 1, of_force}},
                                                 {"Hz", {1, 1, {0, 0, -1, 0, 0}}},
                                                 {"%", {1e-2, 1, {}}},
                                                 {"1", {1, 1, {}}},
                                                 {"n/a", {1, 1, {}}}}};

enum class Letters { as_named, any_case };

const NamedUnit* find_unit(std::string_view name, Letters letters) {
  const auto* const found = std::find_if(named_units.begin(), named_units.end(), [&](const NamedUnit& n) {
    return n.name == name || (letters == Letters::any_case && upper_case(n.name) == upper_case(name));
  });
  return found == named_units.end() ? nullptr : &*found;
}

void multiply(Unit& product, const Unit& by, double exponent) {
  const double size = std::abs(exponent);
  double numerator = 1.0, denominator = 1.0;
  if (size == std::floor(size) && size <= 4.0) {
    for (int i = 0; i < static_cast<int>(size); ++i) {
      numerator *= by.numerator;
      denominator *= by.denominator;
    }
  } else {
    numerator = std::pow(by.numerator, size);
    denominator = std::pow(by.denominator, size);
  }
  product.numerator *= exponent < 0.0 ? denominator : numerator;
  product.denominator *= exponent < 0.0 ? numerator : denominator;
  for (std::size_t k = 0; k < product.powers.size(); ++k) product.powers[k] += exponent * by.powers[k];
}

std::optional<Unit> parse_unit(std::string_view text, Letters letters) {
  text = trimmed(text);
  if (const NamedUnit* whole = find_unit(text, letters)) return whole->unit;
  const auto take_blanks = [&text] { text.remove_prefix(std::min(text.find_first_not_of(' '), text.size())); };
  Unit product;
  double sign = 1.0;
  while (true) {
    // One factor: a name, perhaps with an exponent.
    std::size_t end = 0;
    while (end < text.size() && std::string_view("/^* 0123456789").find(text[end]) == std::string_view::npos) ++end;
    if (end == 0 && text.starts_with('1')) end = 1;  // 1/s
    const NamedUnit* found = find_unit(text.substr(0, end), letters);
    if (found == nullptr) return std::nullopt;
    text.remove_prefix(end);
    double exponent = sign;
    const std::size_t mark = text.starts_with("**") ? 2 : (text.starts_with('^') ? 1 : 0);
    text.remove_prefix(mark);
    const std::size_t stop = std::min(text.find_first_of("*/ "), text.size());
    if (mark == 0 && stop != 0 && found->name == "1") return std::nullopt;  // 100
    if (mark != 0 || stop != 0) {
      const std::optional<double> number = parse_number(text.substr(0, stop));
      if (!number) return std::nullopt;
      exponent *= *number;
      text.remove_prefix(stop);
    }
    multiply(product, found->unit, exponent);
    if (text.empty()) return product;
    take_blanks();
    sign = text.starts_with('/') ? -1.0 : 1.0;
    if (text.starts_with('/') || text.starts_with('*')) text.remove_prefix(1);
    take_blanks();
  }
}

std::optional<double> factor_between(std::string_view from, std::string_view to, Letters letters) {
  if (from == to) return 1.0;
  const std::optional<Unit> a = parse_unit(from, letters);
  const std::optional<Unit> b = parse_unit(to, letters);
  if (!a || !b || !a->measures_as(*b)) return std::nullopt;
  double numerator = a->numerator * b->denominator;
  const double degrees_to_radians = a->powers[0] - b->powers[0];
  if (degrees_to_radians == 1.0) {
    numerator *= degree;
  } else if (degrees_to_radians == -1.0) {
    numerator *= 180.0 / std::numbers::pi;
  } else {
    numerator *= std::pow(degree, degrees_to_radians);
  }
  const double factor = numerator / (a->denominator * b->numerator);
  return std::isfinite(factor) && factor > 0.0 ? std::optional(factor) : std::nullopt;
}

/// The factor to `to`; `allowed` are examples for the message.
double factor(std::string_view unit, std::string_view to, const char* of_what, const char* allowed) {
  if (const auto found = factor_between(unit, to, Letters::as_named)) return *found;
  throw InputError(fmt::format("'{:.40}' is not a unit of {}; allowed: {}", unit, of_what, allowed));
}

}  // namespace

std::optional<double> unit_factor(std::string_view from, std::string_view to) {
  return factor_between(from, to, Letters::any_case);
}

double angle_unit_rad(std::string_view unit) {
  return factor(unit, "rad", "angle", "deg, rad, arcmin, arcsec, mas, uas, rev");
}

double duration_unit_s(std::string_view unit) { return factor(unit, "s", "time", "s, min, h, d, ms, us"); }

double length_unit_m(std::string_view unit) { return factor(unit, "m", "length", "m, km, cm, mm, ft, au"); }

double speed_unit_m_s(std::string_view unit) {
  return factor(unit, "m/s", "speed", "m/s, km/s and the like, of m, km, au and s, h, d");
}

double angular_velocity_unit_rad_s(std::string_view unit) {
  return factor(unit, "rad/s", "angular velocity",
                "rad/s, deg/s, deg/day, rev/h and the like, of rad, deg, arcsec, rev and s, min, h, d; rpm");
}

InertiaUnit inertia_unit(std::string_view unit) {
  if (unit == "ratios") return {1.0, false};
  return {factor(unit, "kg m2", "inertia", "kg m2, g cm2, t m2, slug ft2 and the like, or ratios"), true};
}

InertiaUnit angular_momentum_unit(std::string_view unit) {
  if (unit == "ratios/s") return {1.0, false};
  return {factor(unit, "kg m2/s", "angular momentum", "N m s, kg m2/s, g cm2/s and the like, or ratios/s"), true};
}

}  // namespace polhode
