#include "polhode/read/units.hpp"

#include <fmt/format.h>

#include <array>
#include <numbers>
#include <span>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};

constexpr double turn = 2.0 * std::numbers::pi;

constexpr std::array<Unit, 3> angles{{{"deg", degree}, {"rad", 1.0}, {"arcsec", degree / 3600.0}}};
constexpr std::array<Unit, 9> angular_velocities{{{"rad/s", 1.0},
                                                  {"deg/s", degree},
                                                  {"deg/h", degree / hour_s},
                                                  {"deg/day", degree / day_s},
                                                  {"rad/day", 1.0 / day_s},
                                                  {"rpm", turn / 60.0},
                                                  {"rev/s", turn},
                                                  {"rev/h", turn / hour_s},
                                                  {"rev/day", turn / day_s}}};
// slug ft2: 0.45359237 kg times 9.80665 / 0.3048 per slug, times (0.3048 m)^2; all exact by definition.
constexpr std::array<Unit, 7> inertias{{{"kg m2", 1.0},
                                        {"g cm2", 1e-7},
                                        {"kg cm2", 1e-4},
                                        {"kg mm2", 1e-6},
                                        {"t m2", 1e3},
                                        {"kg km2", 1e6},
                                        {"slug ft2", 0.45359237 * 9.80665 * 0.3048}}};

const Unit* find(std::span<const Unit> units, std::string_view name) {
  for (const Unit& unit : units) {
    if (unit.name == name) return &unit;
  }
  return nullptr;
}

std::string names(std::span<const Unit> units, std::string_view suffix = "") {
  std::string text;
  for (const Unit& unit : units) text += fmt::format("{}{}{}", text.empty() ? "" : ", ", unit.name, suffix);
  return text;
}

double factor(std::span<const Unit> units, std::string_view name, const char* of_what) {
  if (const Unit* unit = find(units, name)) return unit->factor;
  throw InputError(fmt::format("'{}' is not a unit of {}; allowed: {}", name, of_what, names(units)));
}

}  // namespace

double angle_unit_rad(std::string_view unit) { return factor(angles, unit, "angle"); }

double angular_velocity_unit_rad_s(std::string_view unit) {
  return factor(angular_velocities, unit, "angular velocity");
}

InertiaUnit inertia_unit(std::string_view unit) {
  if (unit == "ratios") return {1.0, false};
  if (const Unit* found = find(inertias, unit)) return {found->factor, true};
  throw InputError(fmt::format("'{}' is not a unit of inertia; allowed: {}, or ratios", unit, names(inertias)));
}

InertiaUnit angular_momentum_unit(std::string_view unit) {
  if (unit == "N m s") return {1.0, true};
  if (unit.ends_with("/s")) {
    const std::string_view inertia = unit.substr(0, unit.size() - 2);
    if (inertia == "ratios") return {1.0, false};
    if (const Unit* found = find(inertias, inertia)) return {found->factor, true};
  }
  throw InputError(fmt::format("'{}' is not a unit of angular momentum; allowed: N m s, {}, or ratios/s", unit,
                               names(inertias, "/s")));
}

}  // namespace polhode
