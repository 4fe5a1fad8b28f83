#pragma once

#include <string_view>

#include "polhode/base/geometry.hpp"

namespace polhode {

/// Inertial frames.
enum class Frame {
  icrf,            ///< axes of the ICRS; what SPICE calls J2000
  ecliptic_j2000,  ///< ICRF turned about x by 84381.448 arcsec; SPICE's ECLIPJ2000
};

/// "ICRF", "ECLIPJ2000".
std::string_view name(Frame frame);

/// The frame of that name or of a common alias, any case. Throws InputError naming the allowed ones.
Frame frame(std::string_view name);

/// v_icrf = q v_frame q*.
Quaternion q_icrf_from(Frame frame);

}  // namespace polhode
