#include "polhode/read/ccsds_units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "polhode/read/text.hpp"

namespace polhode {
namespace {

/// A size, and the powers of angle, time, length and mass. Angles count as a kind of their own: deg/s is no frequency.
struct CcsdsUnit {
  double size = 1.0;
  std::array<double, 4> powers{};
};

struct NamedUnit {
  std::string_view name;
  CcsdsUnit unit;
};

// Angles are held in degrees, so that the usual files convert by exactly 1.
constexpr std::array<NamedUnit, 26> ccsds_units{{{"deg", {1.0, {1, 0, 0, 0}}},
                                                 {"rad", {180.0 / std::numbers::pi, {1, 0, 0, 0}}},
                                                 {"arcmin", {1.0 / 60.0, {1, 0, 0, 0}}},
                                                 {"arcsec", {1.0 / 3600.0, {1, 0, 0, 0}}},
                                                 {"rev", {360.0, {1, 0, 0, 0}}},
                                                 {"rpm", {6.0, {1, -1, 0, 0}}},
                                                 {"s", {1.0, {0, 1, 0, 0}}},
                                                 {"ms", {1e-3, {0, 1, 0, 0}}},
                                                 {"us", {1e-6, {0, 1, 0, 0}}},
                                                 {"min", {60.0, {0, 1, 0, 0}}},
                                                 {"h", {3600.0, {0, 1, 0, 0}}},
                                                 {"d", {86400.0, {0, 1, 0, 0}}},
                                                 {"m", {1.0, {0, 0, 1, 0}}},
                                                 {"km", {1e3, {0, 0, 1, 0}}},
                                                 {"cm", {1e-2, {0, 0, 1, 0}}},
                                                 {"mm", {1e-3, {0, 0, 1, 0}}},
                                                 {"kg", {1.0, {0, 0, 0, 1}}},
                                                 {"g", {1e-3, {0, 0, 0, 1}}},
                                                 {"t", {1e3, {0, 0, 0, 1}}},
                                                 {"N", {1.0, {0, -2, 1, 1}}},
                                                 {"mN", {1e-3, {0, -2, 1, 1}}},
                                                 {"kN", {1e3, {0, -2, 1, 1}}},
                                                 {"Hz", {1.0, {0, -1, 0, 0}}},
                                                 {"%", {1e-2, {}}},
                                                 {"1", {1.0, {}}},
                                                 {"n/a", {1.0, {}}}}};

/// In any case of letters: real files write DEG and KG*M**2.
const NamedUnit* find_unit(std::string_view name) {
  const auto* const found =
      std::find_if(ccsds_units.begin(), ccsds_units.end(),
                   [upper = upper_case(name)](const NamedUnit& n) { return upper_case(n.name) == upper; });
  return found == ccsds_units.end() ? nullptr : &*found;
}

std::optional<CcsdsUnit> parse_unit(std::string_view text) {
  if (const NamedUnit* whole = find_unit(text)) return whole->unit;
  CcsdsUnit product;
  double sign = 1.0;
  while (true) {
    // One factor: a name, perhaps with an exponent after ** or ^.
    std::size_t end = 0;
    while (end < text.size() && text[end] != '/' && text[end] != '^' && text[end] != '*') ++end;
    const std::string_view name = trimmed(text.substr(0, end));
    text.remove_prefix(end);
    double exponent = sign;
    const std::size_t mark = text.starts_with("**") ? 2 : (text.starts_with('^') ? 1 : 0);
    if (mark != 0) {
      text.remove_prefix(mark);
      const std::size_t stop = std::min(text.find_first_of("*/"), text.size());
      const std::optional<double> number = parse_number(trimmed(text.substr(0, stop)));
      if (!number) return std::nullopt;
      exponent *= *number;
      text.remove_prefix(stop);
    }
    const NamedUnit* found = find_unit(name);
    if (found == nullptr) return std::nullopt;
    product.size *= std::pow(found->unit.size, exponent);
    for (std::size_t k = 0; k < 4; ++k) product.powers[k] += exponent * found->unit.powers[k];
    if (text.empty()) return product;
    sign = text[0] == '/' ? -1.0 : 1.0;
    text.remove_prefix(1);
  }
}

}  // namespace

std::optional<double> unit_factor(std::string_view from, std::string_view to) {
  if (from == to) return 1.0;
  const std::optional<CcsdsUnit> a = parse_unit(trimmed(from));
  const std::optional<CcsdsUnit> b = parse_unit(trimmed(to));
  if (!a || !b || a->powers != b->powers || !std::isfinite(a->size) || a->size == 0.0) return std::nullopt;
  return a->size / b->size;
}

}  // namespace polhode
