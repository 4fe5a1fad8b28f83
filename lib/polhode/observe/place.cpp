#include "polhode/observe/place.hpp"

#include <erfa.h>
#include <erfam.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

bool in_range_of_erfa(Instant instant) {
  constexpr int first_mjd = 15020, last_mjd = 88069;  // 1900-01-01, 2100-01-01
  const int day = static_cast<int>(modified_julian_date(instant, TimeScale::tdb).day);
  return first_mjd <= day && day < last_mjd;
}

EarthAndSun earth_and_sun(Instant instant) {
  constexpr double au_m = ERFA_DAU;
  const ModifiedJulianDate tdb = modified_julian_date(instant, TimeScale::tdb);
  double from_sun[2][3], from_barycentre[2][3];
  eraEpv00(ERFA_DJM0 + tdb.day, tdb.fraction, from_sun, from_barycentre);  // warns outside of 1900 to 2100
  const Vector3 earth(from_barycentre[0]), heliocentric(from_sun[0]);
  const Vector3 velocity = Vector3(from_barycentre[1]) - Vector3(from_sun[1]);
  return {au_m * earth, au_m * (earth - heliocentric), au_m / ERFA_DAYSEC * velocity};
}

Centre centre_of_name(std::string_view name) {
  const std::string upper = upper_case(name);
  if (upper == "SUN") return Centre::sun;
  if (upper == "EARTH") return Centre::earth;
  for (const std::string_view barycentre :
       {"SSB", "SOLAR SYSTEM BARYCENTER", "SOLAR SYSTEM BARYCENTRE", "SOLAR_SYSTEM_BARYCENTER"}) {
    if (upper == barycentre) return Centre::barycentre;
  }
  return Centre::other;
}

Vector3 site_from_geocentre_m(const Site& site, Instant instant) {
  constexpr double highest_m = 1e8;
  if (!(std::abs(site.longitude_rad) <= 2.0 * std::numbers::pi) ||
      !(std::abs(site.latitude_rad) <= 0.5 * std::numbers::pi) || !(std::abs(site.height_m) <= highest_m)) {
    throw InputError(
        fmt::format("the site is at longitude {:g} deg, latitude {:g} deg, height {:g} m; allowed are -360 to 360 deg, "
                    "-90 to 90 deg and -1e8 to 1e8 m",
                    site.longitude_rad * ERFA_DR2D, site.latitude_rad * ERFA_DR2D, site.height_m));
  }
  Vector3 terrestrial;
  if (eraGd2gc(ERFA_WGS84, site.longitude_rad, site.latitude_rad, site.height_m, terrestrial.data()) != 0) {
    throw InputError("the site's coordinates are no place on the Earth");
  }
  return q_icrf_from(Frame::itrf, instant, site.earth) * terrestrial;
}

}  // namespace polhode
