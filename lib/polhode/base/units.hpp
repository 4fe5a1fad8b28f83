#pragma once

#include <numbers>

namespace polhode {

inline constexpr double degree = std::numbers::pi / 180.0;  ///< in rad
inline constexpr double hour_s = 3600.0;
inline constexpr double day_s = 86400.0;

}  // namespace polhode
