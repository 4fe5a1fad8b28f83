#pragma once

#include <string_view>

#include "polhode/time/instant.hpp"

namespace polhode {

/// A span of time as the command line gives it: "60" (seconds), "60 s", "1.5 min", "6h", "0.1 d". The decimal number is
/// kept to more digits than one double has. Throws InputError.
Seconds parse_duration(std::string_view text);

/// An angle in radians: "1e-6" (radians), "1e-6 rad", "0.1 deg", "5 arcmin", "10 mas" … Throws InputError.
double parse_angle_rad(std::string_view text);

}  // namespace polhode
