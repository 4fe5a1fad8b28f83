#pragma once

#include <string>
#include <string_view>

#include "polhode/read/trajectory_file.hpp"

namespace polhode {

/// Whether the content is a table of JPL's Horizons: it has a line $$SOE.
bool is_horizons(std::string_view text);

/// A vector table of JPL's Horizons as it is downloaded, CSV or not, in any of its units: geometric positions and
/// velocities (types 1 to 4) in ICRF or the ecliptic of J2000, about the centre of a body, at times in TDB, TT or UT.
/// Interpolated as tables of text are. Throws InputError with file and line for other tables.
CentredTrajectory parse_horizons(std::string_view text, const std::string& path, const TrajectoryRequest& request);

}  // namespace polhode
