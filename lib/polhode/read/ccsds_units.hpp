#pragma once

#include <optional>
#include <string_view>

namespace polhode {

/// The factor that takes numbers in unit `from` to unit `to`, as CCSDS messages write units: names joined by * and /,
/// exponents after ** or ^ ("kg*m**2", "deg/s**0.5", "1/s"). Known names, in any case of letters: deg, rad, arcmin,
/// arcsec, rev, rpm, s, ms, us, min, h, d, m, km, cm, mm, kg, g, t, N, mN, kN, Hz, %. Nothing if a name is not known or
/// the two measure different things.
std::optional<double> unit_factor(std::string_view from, std::string_view to);

}  // namespace polhode
