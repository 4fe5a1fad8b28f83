#pragma once

#include <optional>
#include <string>

#include "polhode/frames/frame.hpp"
#include "polhode/time/instant.hpp"
#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// What the caller knows of a trajectory and wants of it.
struct TrajectoryRequest {
  std::string centre;                ///< name of the central body; an OEM must name the same (any case); empty: any
  Frame frame = Frame::icrf;         ///< wanted, inertial
  std::optional<Frame> table_frame;  ///< of a table of text, which names none; `frame` if not given
  Instant zero;                      ///< where the body's clock is 0
};

/// The way of a body from a file:
/// - a CCSDS Orbit Ephemeris Message (502.0-B-1 to -3), KVN or XML, interpolated as it says (LINEAR, LAGRANGE, HERMITE
///   and their degree; Lagrange of degree 7 where it says nothing); segments are kept apart, the useable times obeyed;
///   a frame that turns (TEME, ITRF without polar motion and UT1 - UTC) is turned row by row;
/// - a table of text, CSV or ECSV: a first column `date_SCALE` (or `time`, its scale in an ECSV header) of dates, or
///   `t_s` of seconds on the body's clock; columns x, y, z and perhaps vx, vy, vz whose units stand in the ECSV header
///   or behind the name: x_m, x_km, x_au, vx_m_s, vx_km_s. Hermite of degree 7 with velocities, else Lagrange of
///   degree 7.
/// Throws InputError with file and line, FileError if the file cannot be read.
TabulatedOrbit read_trajectory(const std::string& path, const TrajectoryRequest& request);
/// The same from the file's content; `path` is for messages.
TabulatedOrbit parse_trajectory(const std::string& text, const std::string& path, const TrajectoryRequest& request);

/// A trajectory and the name of its central body; empty where the file names none.
struct CentredTrajectory {
  Trajectory trajectory;
  std::string centre;
};

/// The way of a body from a file as read_trajectory() takes it, from Horizons' vector table (horizons_file.hpp) or from
/// orbital elements (elements_file.hpp), by content. `request.centre` is left out of account.
CentredTrajectory read_centred_trajectory(const std::string& path, const TrajectoryRequest& request);
CentredTrajectory parse_centred_trajectory(const std::string& text, const std::string& path,
                                           const TrajectoryRequest& request);

}  // namespace polhode
