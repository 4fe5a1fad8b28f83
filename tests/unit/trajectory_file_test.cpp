#include "polhode/read/trajectory_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "polhode/base/error.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {
namespace {

constexpr double kEarth = 3.986004418e14;
const KeplerElements kOrbit{kEarth, 7e6, 0.05, 300.0, {1, 2, -0.5}, {0.5, 0, 1}};

class TrajectoryFile : public ::testing::Test {
 protected:
  ~TrajectoryFile() override { std::filesystem::remove(path_); }

  TabulatedOrbit read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_trajectory(path_, request);
  }
  std::string complaint(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no InputError";
  }

  /// Largest distance from the orbit, m and m/s.
  static std::pair<double, double> off(const TabulatedOrbit& table, double first_s, double last_s) {
    const KeplerOrbit orbit(kOrbit);
    double position = 0.0, velocity = 0.0;
    for (double t = first_s; t <= last_s; t += 37.0) {
      position = std::max(position, (table.state(t).position_m - orbit.state(t).position_m).norm());
      velocity = std::max(velocity, (table.state(t).velocity_m_s - orbit.state(t).velocity_m_s).norm());
    }
    return {position, velocity};
  }

  const std::string path_ =  // a file of its own: tests run side by side
      ::testing::TempDir() + "polhode_trajectory_" + ::testing::UnitTest::GetInstance()->current_test_info()->name() +
      ".txt";
  TrajectoryRequest request{"earth", Frame::icrf, std::nullopt, parse_date("2025-01-01T00:00:00", TimeScale::tdb)};
};

/// Rows of the orbit `from` to `to` seconds after the request's zero, dates in TDB.
std::string rows(int from, int to, int step, const Matrix3& frame_from_icrf = Matrix3::Identity()) {
  std::string text;
  const KeplerOrbit orbit(kOrbit);
  for (int t = from; t <= to; t += step) {
    const OrbitState<double> s = orbit.state(static_cast<double>(t));
    const Vector3 r = frame_from_icrf * s.position_m / 1e3, v = frame_from_icrf * s.velocity_m_s / 1e3;
    char line[300];
    std::snprintf(line, sizeof line, "2025-01-01T%02d:%02d:%02d.000 %.9f %.9f %.9f %.12f %.12f %.12f\n", t / 3600,
                  t / 60 % 60, t % 60, r[0], r[1], r[2], v[0], v[1], v[2]);
    text += line;
  }
  return text;
}

std::string oem(const std::string& metadata, const std::string& data) {
  return "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2025-01-01T00:00:00\nORIGINATOR = TEST\nMETA_START\nOBJECT_NAME = X\n"
         "OBJECT_ID = 2025-001A\nCENTER_NAME = EARTH\nTIME_SYSTEM = TDB\nSTART_TIME = 2025-01-01T00:00:00\n"
         "STOP_TIME = 2025-01-01T01:30:00\n" +
         metadata + "META_STOP\n" + data;
}

TEST_F(TrajectoryFile, ReadsAnOemAndInterpolatesAsItSays) {
  const auto [hermite, speed] = off(
      read(oem("REF_FRAME = ICRF\nINTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 7\n", rows(0, 5400, 60))), 0, 5400);
  EXPECT_LT(hermite, 0.02);  // seconds of TDB are not those of TT: 1.2 us in the hour
  EXPECT_LT(speed, 1e-4);
  const auto [linear, linear_speed] =
      off(read(oem("REF_FRAME = ICRF\nINTERPOLATION = LINEAR\n", rows(0, 5400, 60))), 0, 5400);
  EXPECT_NEAR(linear, 7.6 * 3600.0 / 8.0, 700.0);  // acceleration times the square of the step / 8
  EXPECT_GT(linear_speed, 100.0);
  const double lagrange =
      off(read(oem("REF_FRAME = ICRF\nINTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 3\n", rows(0, 5400, 60))), 0,
          5400)
          .first;
  const double silent = off(read(oem("REF_FRAME = ICRF\n", rows(0, 5400, 60))), 0, 5400).first;
  EXPECT_LT(lagrange, 10.0);
  EXPECT_GT(lagrange, 10.0 * silent);  // degree 7 where the message says nothing
  EXPECT_LT(silent, 0.1);
}

TEST_F(TrajectoryFile, TurnsTheFrameAndTheClock) {
  const std::string hermite = "INTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 7\n";
  for (const Frame frame : {Frame::eme2000, Frame::ecliptic_j2000}) {
    const Matrix3 from_icrf = q_icrf_from(frame).toRotationMatrix().transpose();
    const TabulatedOrbit table =
        read(oem("REF_FRAME = " + std::string(name(frame)) + "\n" + hermite, rows(0, 5400, 60, from_icrf)));
    EXPECT_LT(off(table, 0, 5400).first, 0.02) << name(frame);
  }
  // A frame that turns: a place at rest in ITRF moves with the Earth, 465 m/s at the equator.
  std::string rest;
  for (int minute = 0; minute < 60; ++minute) {
    char line[100];
    std::snprintf(line, sizeof line, "2025-01-01T00:%02d:00 6378.137 0 0 0 0 0\n", minute);
    rest += line;
  }
  const TabulatedOrbit fixed = read(oem("REF_FRAME = ITRF2020\n" + hermite, rest));
  const OrbitState<double> there = fixed.state(1830.0);
  const Instant when = request.zero + Seconds{1830.0, 0.0};
  EXPECT_LT((there.position_m - q_icrf_from(Frame::itrf, when) * Vector3(6378137.0, 0, 0)).norm(), 1e-2);
  EXPECT_NEAR(there.velocity_m_s.norm(), 6378137.0 * 7.2921159e-5, 0.01);
  // UTC is 69.184 s from TDB.
  std::string utc = oem("REF_FRAME = ICRF\n" + hermite, rows(0, 5400, 60));
  utc.replace(utc.find("TDB"), 3, "UTC");
  const TabulatedOrbit later = read(utc);
  EXPECT_NEAR(later.first_s(), 69.184, 0.01);
}

TEST_F(TrajectoryFile, ObeysUseableTimesAndSegments) {
  const std::string hermite = "REF_FRAME = ICRF\nINTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 7\n";
  const TabulatedOrbit inside = read(oem(hermite + "USEABLE_START_TIME = 2025-01-01T00:10:00\n"
                                                   "USEABLE_STOP_TIME = 2025-01-01T01:00:00\n",
                                         rows(0, 5400, 60)));
  EXPECT_NEAR(inside.first_s(), 600.0, 1e-6);
  EXPECT_NEAR(inside.last_s(), 3600.0, 1e-5);
  EXPECT_THROW(inside.state(599.0), InputError);
  EXPECT_LT(off(inside, 601.0, 3599.0).first, 0.02);
  const std::string first = oem(hermite, rows(0, 1800, 60));
  const std::string second = oem(hermite, rows(1800, 5400, 60));
  const std::string covariance = "COVARIANCE_START\nEPOCH = 2025-01-01T00:10:00\n1.0\n0.1 1.0\nCOVARIANCE_STOP\n";
  const TabulatedOrbit both = read(first + covariance + second.substr(second.find("META_START")));
  EXPECT_EQ(both.seams_s().size(), 1U);
  EXPECT_LT(off(both, 0, 5400).first, 0.02);
}

TEST_F(TrajectoryFile, ReadsXml) {
  std::string states;
  const KeplerOrbit orbit(kOrbit);
  for (int minute = 0; minute < 60; ++minute) {
    const OrbitState<double> s = orbit.state(60.0 * minute);
    char text[600];
    std::snprintf(text, sizeof text,
                  "<stateVector><EPOCH>2025-01-01T00:%02d:00</EPOCH><X units=\"km\">%.9f</X><Y units=\"km\">%.9f</Y>"
                  "<Z units=\"km\">%.9f</Z><X_DOT units=\"km/s\">%.12f</X_DOT><Y_DOT units=\"km/s\">%.12f</Y_DOT>"
                  "<Z_DOT units=\"km/s\">%.12f</Z_DOT></stateVector>\n",
                  minute, s.position_m[0] / 1e3, s.position_m[1] / 1e3, s.position_m[2] / 1e3, s.velocity_m_s[0] / 1e3,
                  s.velocity_m_s[1] / 1e3, s.velocity_m_s[2] / 1e3);
    states += text;
  }
  const std::string xml =
      "<?xml version=\"1.0\"?>\n<oem id=\"CCSDS_OEM_VERS\" version=\"3.0\"><header><CREATION_DATE>2025-01-01T00:00:00"
      "</CREATION_DATE><ORIGINATOR>T</ORIGINATOR></header><body><segment><metadata><OBJECT_NAME>X</OBJECT_NAME>"
      "<OBJECT_ID>X</OBJECT_ID><CENTER_NAME>Earth</CENTER_NAME><REF_FRAME>ICRF</REF_FRAME><TIME_SYSTEM>TDB</"
      "TIME_SYSTEM>"
      "<START_TIME>2025-01-01T00:00:00</START_TIME><STOP_TIME>2025-01-01T00:59:00</STOP_TIME>"
      "<INTERPOLATION>HERMITE</INTERPOLATION><INTERPOLATION_DEGREE>7</INTERPOLATION_DEGREE></metadata><data>" +
      states + "</data></segment></body></oem>\n";
  EXPECT_LT(off(read(xml), 0, 3540).first, 0.02);
  EXPECT_NE(complaint("<aem id=\"CCSDS_AEM_VERS\" version=\"2.0\"></aem>").find("holds no trajectory"),
            std::string::npos);
}

TEST_F(TrajectoryFile, ReadsTablesOfText) {
  const KeplerOrbit orbit(kOrbit);
  std::string seconds = "t_s,x_m,y_m,z_m\n", dates = "date_tdb,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n";
  std::string astropy =
      "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: time, datatype: string}\n# - {name: x, unit: km, datatype: "
      "float64}\n"
      "# - {name: y, unit: km, datatype: float64}\n# - {name: z, unit: km, datatype: float64}\n# meta: !!omap\n"
      "# - __serialized_columns__:\n#     time:\n#       __class__: astropy.time.core.Time\n#       format: isot\n"
      "#       scale: tdb\ntime x y z\n";
  for (int t = 0; t < 3600; t += 60) {
    const OrbitState<double> s = orbit.state(static_cast<double>(t));
    const Vector3 r = s.position_m, v = s.velocity_m_s / 1e3;
    char line[400];
    std::snprintf(line, sizeof line, "%d,%.6f,%.6f,%.6f\n", t, r[0], r[1], r[2]);
    seconds += line;
    std::snprintf(line, sizeof line, "2025-01-01T00:%02d:00,%.9f,%.9f,%.9f,%.12f,%.12f,%.12f\n", t / 60, r[0] / 1e3,
                  r[1] / 1e3, r[2] / 1e3, v[0], v[1], v[2]);
    dates += line;
    std::snprintf(line, sizeof line, "2025-01-01T00:%02d:00.000 %.9f %.9f %.9f\n", t / 60, r[0] / 1e3, r[1] / 1e3,
                  r[2] / 1e3);
    astropy += line;
  }
  EXPECT_LT(off(read(seconds), 0, 3500).first, 0.1);
  EXPECT_LT(off(read(dates), 0, 3500).first, 0.02);
  EXPECT_LT(off(read(astropy), 0, 3500).first, 0.1);
  // Another unit by the header goes before the name, which astropy leaves as it was.
  EXPECT_LT(
      off(read("# - {name: x_km, unit: m}\n# - {name: y_km, unit: m}\n# - {name: z_km, unit: m}\nt_s,x_km,y_km,z_km\n" +
               seconds.substr(seconds.find('\n') + 1)),
          0, 3500)
          .first,
      0.1);
  request.frame = Frame::ecliptic_j2000;
  request.table_frame = Frame::icrf;
  const Vector3 turned = q_icrf_from(Frame::ecliptic_j2000) * read(seconds).state(1000.0).position_m;
  EXPECT_LT((turned - orbit.state(1000.0).position_m).norm(), 0.1);
}

TEST_F(TrajectoryFile, SaysWhatIsWrongAndWhere) {
  const std::string good = "REF_FRAME = ICRF\n";
  const auto says = [&](const std::string& text, const std::string& wanted) {
    const std::string found = complaint(text);
    EXPECT_NE(found.find(wanted), std::string::npos) << found;
  };
  says(oem("REF_FRAME = MOON_ME\n", rows(0, 600, 60)), "not a frame");
  std::string mars = oem(good, rows(0, 600, 60));
  mars.replace(mars.find("EARTH"), 5, "MARS");
  says(mars, "about MARS, one about earth is wanted");
  says(oem(good + "INTERPOLATION = HERMITE\n", rows(0, 600, 60)), "INTERPOLATION_DEGREE is missing");
  says(oem(good + "INTERPOLATION = SPLINE\n", rows(0, 600, 60)), "HERMITE LINEAR LAGRANGE");
  says(oem(good + "INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 20\n", rows(0, 5400, 60)), "1 to 15 is allowed");
  says(oem(good + "INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 9\n", rows(0, 120, 60)), "10 at least");
  says(oem(good, rows(0, 600, 60) + rows(0, 60, 60)), "not after the one above");
  says(oem(good, "2025-01-01T00:00:00 1 2 3\n"), ":13: 4 values");
  says(oem(good + "USEABLE_STOP_TIME = 2026-01-01T00:00:00\n", rows(0, 600, 60)), "useable");
  says("CCSDS_AEM_VERS = 2.0\n", "holds no trajectory");
  says("t_s,x_m,y_m\n0,1,2\n", "no column z_m");
  says("x_m,y_m,z_m\n0,1,2\n", "the first column");
  says("t_s,x_m,y_m,z_miles\n0,1,2,3\n", "'miles'");
  says("t_s,x_m,y_m,z_m\n0,1,2,3\n1,2\n", ":3: 2 cells");
  says("t_s x y z\n0 1 2 3\n", "has no unit");
  says("t_s,x_m,y_m,z_m,x_km\n0,1,2,3,4\n", "there are two columns for x: x_m and x_km");
  says("# - {name: mjd_tdb, unit: h}\nmjd_tdb,x_m,y_m,z_m\n0,1,2,3\n", ":2: column mjd_tdb has the unit h");
  says("# - {name: t_s, unit: h}\nt_s,x_m,y_m,z_m\n0,1,2,3\n", ":2: column t_s has the unit h by the header; s is");
  request.table_frame = Frame::icrf;
  says(oem(good, rows(0, 600, 60)), "names its own frame");
}

}  // namespace
}  // namespace polhode
