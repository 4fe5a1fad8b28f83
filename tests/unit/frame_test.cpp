// Frames: each against its definition. astropy checks all of them in python_checks/test_time_and_frames.py.
#include "polhode/frames/frame.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {
namespace {

constexpr double arcsec = 4.848136811095359936e-6;

TEST(Frames, EclipticPoleInIcrf) {
  const Vector3 pole = q_icrf_from(Frame::ecliptic_j2000) * Vector3(0.0, 0.0, 1.0);
  const double obliquity = 84381.448 * arcsec;
  EXPECT_EQ(pole.x(), 0.0);
  EXPECT_NEAR(pole.y(), -std::sin(obliquity), 2e-16);
  EXPECT_NEAR(pole.z(), std::cos(obliquity), 2e-16);
}

TEST(Frames, KnownAngles) {
  const Quaternion icrf = q_icrf_from(Frame::icrf);
  // Frame bias: 16.617 and 6.819 mas of the pole, 14.60 mas of the equinox (IERS Conventions 2010, 5.4.4).
  EXPECT_NEAR(rotation_angle_rad(icrf, q_icrf_from(Frame::eme2000)) / arcsec, std::hypot(0.016617, 0.0068192, 0.01460),
              1e-6);
  // ECLIPJ2000 and the mean ecliptic of IAU 2006 are 0.042 arcsec of obliquity and the bias apart.
  const double apart = rotation_angle_rad(q_icrf_from(Frame::ecliptic_j2000), q_icrf_from(Frame::ecliptic_iau2006));
  EXPECT_GT(apart / arcsec, 0.03);
  EXPECT_LT(apart / arcsec, 0.07);
  EXPECT_EQ(rotation_angle_rad(icrf, q_icrf_from(Frame::gcrf)), 0.0);
}

TEST(Frames, EarthTurnsOnceASiderealDay) {
  const Instant start = parse_date("2020-06-01T00:00:00", TimeScale::utc);
  const Quaternion before = q_icrf_from(Frame::itrf, start);
  const Quaternion after = q_icrf_from(Frame::itrf, start + Seconds{86164.0989, 0.0});
  EXPECT_LT(rotation_angle_rad(before, after) / arcsec, 0.5);  // precession and nutation of one day
  const Quaternion turned = before.conjugate() * q_icrf_from(Frame::itrf, start + Seconds{60.0, 0.0});
  EXPECT_GT(turned.z() / turned.w(), 0.0) << "the Earth turns eastwards";
  // One second of UT1 is 15.041 arcsec.
  EXPECT_NEAR(rotation_angle_rad(before, q_icrf_from(Frame::itrf, start, {.ut1_minus_utc_s = 1.0})) / arcsec, 15.041,
              0.001);
}

TEST(Frames, TemeIsNearTheMeanEquatorOfItsDate) {
  // At J2000 there is no precession: TEME is off ICRF by nutation only, and not at all by UT1.
  const Instant j2000;
  const Quaternion teme = q_icrf_from(Frame::teme, j2000);
  EXPECT_LT(rotation_angle_rad(teme, q_icrf_from(Frame::icrf)) / arcsec, 20.0);
  EXPECT_LT(rotation_angle_rad(teme, q_icrf_from(Frame::teme, j2000, {.ut1_minus_utc_s = 0.3})) / arcsec, 0.01);
}

TEST(Frames, NamesGoRoundAndAliasesAreKnown) {
  for (const Frame f : {Frame::icrf, Frame::gcrf, Frame::eme2000, Frame::ecliptic_j2000, Frame::ecliptic_iau2006,
                        Frame::teme, Frame::itrf}) {
    EXPECT_EQ(frame(name(f)), f) << name(f);
  }
  EXPECT_EQ(frame("j2000"), Frame::icrf);
  EXPECT_EQ(frame("EclipJ2000"), Frame::ecliptic_j2000);
  EXPECT_THROW(frame("FK5"), InputError);
  EXPECT_THROW(q_icrf_from(Frame::teme), InputError);
}

TEST(Frames, AnEarthOrientationThatCannotBeIsRefused) {
  const Instant now = parse_date("2020-06-01T00:00:00", TimeScale::utc);
  const Instant early = parse_date("1900-01-01T00:00:00", TimeScale::utc);
  const double nan = std::nan("");
  for (const EarthOrientation& earth :
       {EarthOrientation{nan, 0.0, 0.0}, EarthOrientation{1e300, 0.0, 0.0}, EarthOrientation{-69.2, 0.0, 0.0},
        EarthOrientation{0.0, nan, 0.0}, EarthOrientation{0.0, 0.0, 150.0}}) {
    EXPECT_THROW(q_icrf_from(Frame::itrf, now, earth), InputError);
  }
  EXPECT_THROW(q_icrf_from(Frame::itrf, early, {1e300, 0.0, 0.0}), InputError);
  EXPECT_NO_THROW(q_icrf_from(Frame::itrf, now, {-0.9, 0.3, 0.3}));
  EXPECT_NO_THROW(q_icrf_from(Frame::itrf, early, {30.0, 0.0, 0.0}));
}

}  // namespace
}  // namespace polhode
