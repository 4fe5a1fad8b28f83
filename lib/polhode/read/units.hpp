#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "polhode/base/units.hpp"

namespace polhode {

/// Units, wherever a file or an option names one: names joined by blanks, * and /, each perhaps with an exponent behind
/// it, as m2, m^2 or m**2 ("kg m2", "kg*m**2", "deg/day", "1/s"). The names: deg, rad, arcmin, arcsec, mas, uas, rev,
/// rpm; s, ms, us, min, h, d, day; m, km, cm, mm, ft, au or AU; kg, g, t, slug; N, mN, kN; Hz, %, 1.

/// The factor that takes numbers in unit `from` to unit `to`, names in any case of letters, as CCSDS messages have
/// them. Nothing if a name is not known or the two measure different things.
std::optional<double> unit_factor(std::string_view from, std::string_view to);

/// The factor to our unit. Each throws InputError with the units that are allowed.
double angle_unit_rad(std::string_view unit);               ///< "deg", "rad", "mas" …
double duration_unit_s(std::string_view unit);              ///< "s", "min", "h", "d" …
double length_unit_m(std::string_view unit);                ///< "m", "km", "au" …
double speed_unit_m_s(std::string_view unit);               ///< "m/s", "km/s" …
double angular_velocity_unit_rad_s(std::string_view unit);  ///< "rad/s", "deg/s", "deg/day", "rpm" …

/// Inertia: the factor to kg m^2, or 1 with `absolute` false for "ratios".
struct InertiaUnit {
  double factor = 1.0;
  bool absolute = false;
};
InertiaUnit inertia_unit(std::string_view unit);           ///< "kg m2", "g cm2" … or "ratios"
InertiaUnit angular_momentum_unit(std::string_view unit);  ///< "N m s", "kg m2/s" … or "ratios/s"

}  // namespace polhode
