#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "polhode/base/geometry.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/time/instant.hpp"
#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// The Earth's centre and the Sun from the barycentre of the solar system, in ICRF axes: ERFA's epv00, whose errors
/// against DE405 are below 4.6 km (heliocentric) and 13.4 km (barycentric) from 1900 to 2100.
struct EarthAndSun {
  Vector3 earth_m, sun_m, sun_velocity_m_s;
};
EarthAndSun earth_and_sun(Instant instant);
/// Whether an instant lies within these years.
bool in_range_of_erfa(Instant instant);

/// The origin of a trajectory, by its name in any case of letters: what it is relative to the barycentre is known for
/// the barycentre ("SSB", "SOLAR SYSTEM BARYCENTER"), "SUN" and "EARTH"; of every other name it is not.
enum class Centre { barycentre, sun, earth, other };
Centre centre_of_name(std::string_view name);

/// A way from a file or of elements: positions in the axes of `frame` from `centre`, at seconds from `zero` (as TT
/// counts them).
struct KnownWay {
  Trajectory trajectory;
  Frame frame = Frame::icrf;  ///< inertial
  Instant zero;
  std::string centre = "SUN";
  std::string source;  ///< the file, for messages; empty: there is none
};

/// A place on the Earth: geodetic coordinates on the ellipsoid WGS84, longitude east.
struct Site {
  double longitude_rad = 0.0, latitude_rad = 0.0, height_m = 0.0;
  EarthOrientation earth;  ///< UT1 - UTC and the pole, 0 unless given
};

/// From the geocentre, in ICRF axes. Throws InputError for coordinates that are none.
Vector3 site_from_geocentre_m(const Site& site, Instant instant);

struct TheGeocentre {};
struct TheSun {};

/// Where something is.
using Place = std::variant<TheGeocentre, TheSun, Site, KnownWay>;

}  // namespace polhode
