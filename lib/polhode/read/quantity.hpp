#pragma once

#include <string_view>

#include "polhode/time/instant.hpp"

namespace polhode {

/// A span of time as the command line gives it: "60" (seconds), "60 s", "1.5 min", "6h", "0.1 d". The decimal number is
/// kept to more digits than one double has. Throws InputError.
Seconds parse_duration(std::string_view text);

/// An angle in radians: "1e-6" (radians), "1e-6 rad", "0.1 deg", "5 arcmin", "10 mas" … Throws InputError.
double parse_angle_rad(std::string_view text);

/// The smallest error that may be asked for: rounding the four components of a quaternion turns a body by as much.
inline constexpr double smallest_tolerance_rad = 1e-15;

/// An angle as parse_angle_rad has it, that an error may be kept below: smallest_tolerance_rad or more, else
/// InputError.
double parse_tolerance_rad(std::string_view text);

}  // namespace polhode
