#pragma once

#include <string>
#include <string_view>

#include "polhode/read/trajectory_file.hpp"

namespace polhode {

/// Whether the content is TOML with an `eccentricity` before its first table: osculating elements of an orbit.
bool is_elements(std::string_view text);

/// Elements as catalogues of asteroids and comets have them, in the frame ECLIPJ2000 unless `frame` names another and
/// about the Sun unless `centre` names another body, whose `mu_m3_s2` is then wanted:
///
///     epoch                                       a date with its scale
///     eccentricity
///     semi_major_axis_au or periapsis_au          (negative semi-axis: hyperbola)
///     inclination_deg, node_deg, periapsis_deg    (argument of the periapsis)
///     mean_anomaly_deg at the epoch, or periapsis_date
///
/// Throws InputError with file and line.
CentredTrajectory parse_elements(std::string_view text, const std::string& path, const TrajectoryRequest& request);

}  // namespace polhode
