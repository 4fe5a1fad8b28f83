#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace polhode {

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
