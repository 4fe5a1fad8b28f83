#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <string_view>

namespace polhode {

inline constexpr double degree = std::numbers::pi / 180.0;  ///< in rad
inline constexpr double hour_s = 3600.0;
inline constexpr double day_s = 86400.0;

/// Units that files name, as the factor to ours. Each throws InputError naming the allowed ones.
double angle_unit_rad(std::string_view unit);               ///< "deg", "rad", "arcsec"
double angular_velocity_unit_rad_s(std::string_view unit);  ///< "rad/s", "deg/s", "deg/day", "rpm" …

/// Inertia: the factor to kg m^2, or 1 with `absolute` false for "ratios".
struct InertiaUnit {
  double factor = 1.0;
  bool absolute = false;
};
InertiaUnit inertia_unit(std::string_view unit);           ///< "kg m2", "g cm2" … or "ratios"
InertiaUnit angular_momentum_unit(std::string_view unit);  ///< the same with "/s" behind, or "N m s"

}  // namespace polhode
