#pragma once

#include <string_view>

#include "polhode/base/geometry.hpp"
#include "polhode/time/instant.hpp"

namespace polhode {

/// Frames that an attitude may refer to. All but the last two are inertial.
enum class Frame {
  icrf,              ///< axes of the ICRS; what SPICE calls J2000
  gcrf,              ///< GCRS axes: kinematically those of the ICRS, the same here
  eme2000,           ///< mean equator and equinox of J2000: ICRF turned by the frame bias of the IERS Conventions
  ecliptic_j2000,    ///< ICRF turned about x by 84381.448 arcsec; SPICE's ECLIPJ2000
  ecliptic_iau2006,  ///< mean ecliptic and equinox of J2000, IAU 2006 (84381.406 arcsec, with the frame bias)
  teme,              ///< true equator, mean equinox of date, as SGP4 uses it; turns slowly with precession and nutation
  itrf,              ///< fixed to the Earth
};

/// "ICRF", "GCRF", "EME2000", "ECLIPJ2000", "ECLIPIAU2006", "TEME", "ITRF".
std::string_view name(Frame frame);

/// The frame of that name or of a common alias, any case. Throws InputError naming the allowed ones.
Frame frame(std::string_view name);

/// The same for a frame that must be inertial, and for one in which a state may be given at its epoch (all but ITRF).
Frame inertial_frame(std::string_view name);
Frame frame_of_state(std::string_view name);

/// True for the frames that q_icrf_from takes without an instant.
bool is_inertial(Frame frame);

/// v_icrf = q v_frame q*. Throws InputError for a frame that depends on time.
Quaternion q_icrf_from(Frame frame);

/// What the Earth's rotation needs beyond the models; zero unless given.
struct EarthOrientation {
  double ut1_minus_utc_s = 0.0;  ///< at most 1 s in size, a day where utc_doubt() says that UTC is not sure: 15 arcsec
                                 ///< of rotation for each second (ITRF)
  double pole_x_arcsec = 0.0;    ///< polar motion, some 0.3 arcsec; at most 1 arcsec in size
  double pole_y_arcsec = 0.0;
};

/// As q_icrf_from(frame) for any frame, at an instant. ITRF is IAU 2006/2000A with the given UT1 and pole (celestial
/// pole offsets neglected, below 0.001 arcsec); TEME is reached through ITRF by GMST 1982, as Vallado et al. (2006)
/// and astropy do. Throws InputError for an Earth orientation beyond its limits.
Quaternion q_icrf_from(Frame frame, Instant instant, const EarthOrientation& earth = {});

}  // namespace polhode
