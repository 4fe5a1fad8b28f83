#include "polhode/frames/frame.hpp"

#include <erfa.h>
#include <erfam.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {
namespace {

struct NamedFrame {
  std::string_view name;
  Frame frame;
};
// The first name of each frame is the one we write.
constexpr std::array<NamedFrame, 16> frame_names{{{"ICRF", Frame::icrf},
                                                  {"ICRS", Frame::icrf},
                                                  {"J2000", Frame::icrf},
                                                  {"GCRF", Frame::gcrf},
                                                  {"GCRS", Frame::gcrf},
                                                  {"EME2000", Frame::eme2000},
                                                  {"ECLIPJ2000", Frame::ecliptic_j2000},
                                                  {"ECLIPTICJ2000", Frame::ecliptic_j2000},
                                                  {"ECLIPTIC_J2000", Frame::ecliptic_j2000},
                                                  {"ECLIPTIC", Frame::ecliptic_j2000},
                                                  {"ECLIPIAU2006", Frame::ecliptic_iau2006},
                                                  {"ECLIPTIC_IAU2006", Frame::ecliptic_iau2006},
                                                  {"BARYCENTRICMEANECLIPTIC", Frame::ecliptic_iau2006},
                                                  {"TEME", Frame::teme},
                                                  {"ITRF", Frame::itrf},
                                                  {"ITRS", Frame::itrf}}};

// The frame of that name, if it is inertial or among `others`.
Frame named_frame(std::string_view text, const char* what, std::initializer_list<Frame> others) {
  const std::string upper = upper_case(text);
  for (const NamedFrame& entry : frame_names) {
    const bool allowed =
        is_inertial(entry.frame) || std::find(others.begin(), others.end(), entry.frame) != others.end();
    if (entry.name == upper && allowed) return entry.frame;
  }
  std::string more;
  for (const Frame other : others) more += fmt::format(", {}", name(other));
  throw InputError(
      fmt::format("'{:.60}' is not {}; allowed: ICRF (or J2000, ICRS), GCRF, EME2000, ECLIPJ2000, ECLIPIAU2006{}", text,
                  what, more));
}

// An ERFA matrix takes components in ICRF to components in the frame: q is of its transpose.
Quaternion q_icrf_from_matrix(const double (&frame_from_icrf)[3][3]) {
  Matrix3 icrf_from_frame;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) icrf_from_frame(column, row) = frame_from_icrf[row][column];
  }
  return Quaternion(icrf_from_frame).normalized();
}

struct JulianPair {
  double day = 0.0, fraction = 0.0;
};

JulianPair julian_tt(Instant instant) {
  const ModifiedJulianDate date = modified_julian_date(instant, TimeScale::tt);
  return {ERFA_DJM0 + date.day, date.fraction};
}

// The Earth's orientation within what it can be: a number in another unit, or UT1 - TT, is far beyond.
void check(const EarthOrientation& earth, Instant instant) {
  constexpr double most_pole_arcsec = 1.0;
  if (!(std::abs(earth.pole_x_arcsec) <= most_pole_arcsec && std::abs(earth.pole_y_arcsec) <= most_pole_arcsec)) {
    throw InputError(fmt::format("polar motion is ({:g}, {:g}) arcsec; at most {:g} arcsec in size is allowed",
                                 earth.pole_x_arcsec, earth.pole_y_arcsec, most_pole_arcsec));
  }
  constexpr double most_where_utc_is_kept_s = 1.0;
  constexpr double most_s = 86400.0;
  const double size_s = std::abs(earth.ut1_minus_utc_s);
  if (size_s <= most_where_utc_is_kept_s || (size_s <= most_s && utc_doubt(instant))) return;
  throw InputError(fmt::format(
      "UT1 - UTC is {:g} s; at most {:g} s in size is allowed (a day before 1960 and where no leap seconds are known)",
      earth.ut1_minus_utc_s, most_where_utc_is_kept_s));
}

// UT1 = UTC + dUT1 as a Julian pair; the reading of UTC on a leap second's day is stretched by ERFA's convention.
JulianPair julian_ut1(Instant instant, const EarthOrientation& earth) {
  const ModifiedJulianDate utc = modified_julian_date(instant, TimeScale::utc);
  JulianPair ut1;
  if (eraUtcut1(ERFA_DJM0 + utc.day, utc.fraction, earth.ut1_minus_utc_s, &ut1.day, &ut1.fraction) < 0) {
    throw InputError("UT1 cannot be computed for this date");
  }
  return ut1;
}

}  // namespace

std::string_view name(Frame frame) {
  return std::find_if(frame_names.begin(), frame_names.end(), [&](const auto& e) { return e.frame == frame; })->name;
}

Frame frame(std::string_view name) { return named_frame(name, "a frame", {Frame::teme, Frame::itrf}); }

Frame inertial_frame(std::string_view name) { return named_frame(name, "an inertial frame", {}); }

Frame frame_of_state(std::string_view name) { return named_frame(name, "a frame for a state", {Frame::teme}); }

bool is_inertial(Frame frame) { return frame != Frame::teme && frame != Frame::itrf; }

Quaternion q_icrf_from(Frame frame) {
  if (!is_inertial(frame)) {
    throw InputError(
        fmt::format("frame {} turns with time; an inertial frame is needed here: ICRF, GCRF, EME2000, "
                    "ECLIPJ2000 or ECLIPIAU2006",
                    name(frame)));
  }
  return q_icrf_from(frame, Instant{});
}

Quaternion q_icrf_from(Frame frame, Instant instant, const EarthOrientation& earth) {
  check(earth, instant);
  switch (frame) {
    case Frame::icrf:
    case Frame::gcrf:
      return Quaternion::Identity();
    case Frame::ecliptic_j2000: {
      const double half = 0.5 * 84381.448 * ERFA_DAS2R;
      return {std::cos(half), std::sin(half), 0.0, 0.0};
    }
    case Frame::eme2000: {
      double bias[3][3], precession[3][3], both[3][3];
      eraBp00(ERFA_DJ00, 0.0, bias, precession, both);
      return q_icrf_from_matrix(bias);
    }
    case Frame::ecliptic_iau2006: {
      double matrix[3][3];
      eraEcm06(ERFA_DJ00, 0.0, matrix);
      return q_icrf_from_matrix(matrix);
    }
    case Frame::teme:
    case Frame::itrf:
      break;
  }
  const JulianPair tt = julian_tt(instant);
  const JulianPair ut1 = julian_ut1(instant, earth);
  const double pole_x_rad = earth.pole_x_arcsec * ERFA_DAS2R;
  const double pole_y_rad = earth.pole_y_arcsec * ERFA_DAS2R;
  double itrf_from_gcrf[3][3];
  eraC2t06a(tt.day, tt.fraction, ut1.day, ut1.fraction, pole_x_rad, pole_y_rad, itrf_from_gcrf);
  const Quaternion q_icrf_from_itrf = q_icrf_from_matrix(itrf_from_gcrf);
  if (frame == Frame::itrf) return q_icrf_from_itrf;

  double itrf_from_pef[3][3];  // pseudo-Earth-fixed: without polar motion
  eraPom00(pole_x_rad, pole_y_rad, 0.0, itrf_from_pef);
  const double half_gmst = 0.5 * eraGmst82(ut1.day, ut1.fraction);
  const Quaternion q_teme_from_pef(std::cos(half_gmst), 0.0, 0.0, std::sin(half_gmst));
  const Quaternion q_pef_from_itrf = q_icrf_from_matrix(itrf_from_pef);  // the transpose here too
  return (q_icrf_from_itrf * q_pef_from_itrf.conjugate() * q_teme_from_pef.conjugate()).normalized();
}

}  // namespace polhode
