// CCSDS attitude messages: every sample, expectations written by hand, and what the standard forbids.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/read/ccsds_attitude.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

const std::string samples = POLHODE_DATA_DIR "/samples/ccsds/";

CcsdsAttitudeMessage read(const std::string& file) {
  return parse_ccsds_attitude(read_text_file(samples + file), file).at(0);
}

std::string fault_of(const std::string& text) {
  try {
    parse_ccsds_attitude(text, "m");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// The quaternion of a turn about an axis, in degrees.
Quaternion turn(double angle_deg, const Vector3& axis) {
  return Quaternion(Eigen::AngleAxisd(angle_deg * degree, axis));
}
const Vector3 x = Vector3::UnitX();
const Vector3 y = Vector3::UnitY();
const Vector3 z = Vector3::UnitZ();

void expect_attitude(const Quaternion& found, const Quaternion& wanted, double tolerance = 1e-12) {
  EXPECT_LE(rotation_angle_rad(found, wanted.normalized()), tolerance) << scalar_first(found).transpose();
}

void expect_rate(const std::optional<Vector3>& found_rad_s, const Vector3& wanted_rad_s, double tolerance = 1e-15) {
  ASSERT_TRUE(found_rad_s.has_value());
  EXPECT_LE((*found_rad_s - wanted_rad_s).norm(), tolerance) << found_rad_s->transpose();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(CcsdsSamples, EveryValidOneIsRead) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(samples + "valid")) {
    EXPECT_EQ(fault_of(read_text_file(entry.path())), "accepted") << entry.path();
    ++count;
  }
  EXPECT_EQ(count, 14U);
}

TEST(CcsdsSamples, EveryInvalidOneIsRefusedWithItsLine) {
  const std::vector<std::pair<std::string, std::string>> wanted{
      {"ACM-sensor-index-already-used.txt", "m:30: SENSOR_NUMBER 2 is already used on line 26"},
      {"AEM-ephemeris-number-format-error.txt", "m:28: 'this-is-not-a-number' is not a number"},
      {"AEM-inconsistent-quaternion-type.txt",
       "m:20: the keyword QUATERNION_TYPE is not allowed in the metadata of an AEM 2.0"},
      {"AEM-keyword-within-ephemeris.txt", "m:29: the keyword USER_DEFINED_TEST_KEY between the data lines"},
      {"APM-inconsistent-time-systems.txt", "m:11: TIME_SYSTEM BCE is unknown"},
      {"APM-no-attitude.txt", "m:18: an angular velocity, but no attitude"},
      {"APM-repeated-Euler-rate.txt", "m:40: Z_RATE once too often"},
      {"APM-wrong-Euler-sequence.txt", "m:33: EULER_ROT_SEQ = 331"}};
  for (const auto& [file, message] : wanted) {
    EXPECT_EQ(fault_of(read_text_file(samples + "invalid/" + file)).substr(0, message.size()), message);
  }
}

TEST(CcsdsApm, Version2QuaternionAndAngularVelocity) {
  const CcsdsAttitudeMessage m = read("valid/APMExample08.txt");
  ASSERT_TRUE(m.body.state && m.body.state->q_frame_from_named);
  expect_attitude(*m.body.state->q_frame_from_named, Quaternion(0.925417, 0.171010, -0.030154, 0.336824));
  expect_rate(m.body.state->omega_named_rad_s, degree * Vector3(0.0001, 0.05, 0.00003));
  EXPECT_EQ(m.body.state->frame, Frame::eme2000);
  EXPECT_EQ(format_date(m.body.state->epoch, TimeScale::tai, 3), "2023-01-01T00:00:00.000");
  EXPECT_EQ(m.body.missing, std::vector<std::string>{"an inertia"});

  const CcsdsAttitudeMessage xml = read("valid/APM-quaternion-angvel.xml");
  expect_attitude(*xml.body.state->q_frame_from_named,
                  Quaternion(0.6184633325084984, -0.6447327809733585, -0.3463409538535587, -0.28613054916357517));
  expect_rate(xml.body.state->omega_named_rad_s,
              degree * Vector3(0.0031504176144069016, -0.0596101304816182, 2.9095159008651856E-4));
}

TEST(CcsdsApm, Version2EulerAndNutationAreOneState) {
  const CcsdsAttitudeMessage m = read("valid/APMExample12.txt");
  EXPECT_TRUE(m.body.missing.empty());
  ASSERT_EQ(m.body.attitudes.size(), 2U);
  const Quaternion wanted = turn(10, z) * turn(20, x);  // ZXZ by 10, 20, 0 deg
  expect_attitude(m.body.attitudes[0].q_frame_from_body, wanted);
  expect_attitude(m.body.attitudes[1].q_frame_from_body, wanted);  // alpha -80, delta 70, angle 0
  expect_attitude(*m.body.state->q_frame_from_named, wanted);
  // 1 deg/s about the spin axis, 360 deg in 720 s about the momentum (annex F5.3).
  const double n = 0.1 * degree;
  const double p = -85.0 * degree;
  const Vector3 momentum(std::sin(n) * std::cos(p), -std::sin(n) * std::sin(p), std::cos(n));
  expect_rate(m.body.state->omega_named_rad_s, degree * z + 0.5 * degree * momentum);
  // The tensor's plane part: (1443.1 + 1445.2)/2 +- sqrt(1.05^2 + 86.4^2), IYZ being negligible.
  const double split = std::hypot(1.05, 86.4);
  EXPECT_NEAR(m.body.inertia->principal_moments[0], 1444.15 - split, 1e-4);
  EXPECT_NEAR(m.body.inertia->principal_moments[1], 1444.15 + split, 1e-4);
  // IXY = -86.4 is the integral of xy dm, so the tensor holds +86.4: the smallest moment is along (1, -1, 0).
  EXPECT_LT(m.body.inertia->named_from_principal(0, 0) * m.body.inertia->named_from_principal(1, 0), 0.0);
}

TEST(CcsdsApm, Version1BothFormatsAndDirections) {
  for (const char* file : {"valid/APMExample02.txt", "valid/APMExample02.xml"}) {
    const CcsdsAttitudeMessage m = read(file);
    ASSERT_EQ(m.body.attitudes.size(), 2U);
    // From INSTRUMENT_A to ITRF-97: the instrument in ITRF-97 is the inverse.
    EXPECT_EQ(m.body.attitudes[0].frame, "ITRF-97");
    EXPECT_EQ(m.body.attitudes[0].body, "INSTRUMENT_A");
    expect_attitude(m.body.attitudes[0].q_frame_from_body, Quaternion(0.47832, -0.03123, -0.78543, -0.39158));
    // From ITRF-97 to INSTRUMENT_A: 312 by -53.3688, 139.7527, 25.0658 deg.
    expect_attitude(m.body.attitudes[1].q_frame_from_body, turn(-53.3688, z) * turn(139.7527, x) * turn(25.0658, y));
    EXPECT_FALSE(m.body.state.has_value());
    EXPECT_EQ(m.body.missing,
              std::vector<std::string>{"an attitude in an inertial frame (INSTRUMENT_A in ITRF-97 is given)"});
    EXPECT_TRUE(m.body.inertia.has_value());
  }
  const std::string text = read_text_file(samples + "valid/APMExample02.txt");
  const CcsdsAttitudeMessage turned = parse_ccsds_attitude(replaced(text, "A2B", "B2A"), "m").at(0);
  expect_attitude(turned.body.attitudes[0].q_frame_from_body, Quaternion(0.47832, 0.03123, 0.78543, 0.39158));
}

TEST(CcsdsApm, SpinExampleOfAnnexF5) {
  const std::string text =
      "CCSDS_APM_VERS = 2.0\nCREATION_DATE = 2024-01-01T00:00:00\nORIGINATOR = X\nOBJECT_NAME = Y\nOBJECT_ID = Z\n"
      "TIME_SYSTEM = TT\nEPOCH = 2024-001T00:00:00\nSPIN_START\nREF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1\n"
      "SPIN_ALPHA = 0\nSPIN_DELTA = 80 [deg]\nSPIN_ANGLE = 0.7853981633974483 [rad]\nSPIN_ANGLE_VEL = 60 [deg/min]\n"
      "MOMENTUM_ALPHA = 0\nMOMENTUM_DELTA = 70\nNUTATION_VEL = 0.01\nSPIN_STOP\n";
  const CcsdsAttitudeMessage m = parse_ccsds_attitude(text, "m").at(0);
  expect_attitude(*m.body.state->q_frame_from_named, Quaternion(0.3812, 0.0805, 0.0334, 0.9204),
                  2e-4);  // as printed there
  expect_attitude(*m.body.state->q_frame_from_named, turn(90, z) * turn(10, x) * turn(45, z));
  // 0.01 deg/s about (sin 20, 0, cos 20) of frame A, 1 deg/s about the body's z.
  const Vector3 momentum(std::sin(20 * degree), 0.0, std::cos(20 * degree));
  const Quaternion q = turn(90, z) * turn(10, x) * turn(45, z);
  expect_rate(m.body.state->omega_named_rad_s, degree * z + 0.01 * degree * (q.conjugate() * momentum));
  // Plain spin: no nutation.
  std::string plain = text;
  plain.erase(plain.find("MOMENTUM_ALPHA"), plain.find("SPIN_STOP") - plain.find("MOMENTUM_ALPHA"));
  expect_rate(parse_ccsds_attitude(plain, "m").at(0).body.state->omega_named_rad_s, degree * z);
  EXPECT_EQ(fault_of(replaced(text, "[deg/min]", "[deg]")),
            "m:14: SPIN_ANGLE_VEL: the unit [deg] is unknown or no kind of deg/s");
  EXPECT_EQ(fault_of(replaced(text, "[rad]", "[grad]")),
            "m:13: SPIN_ANGLE: the unit [grad] is unknown or no kind of deg");
  EXPECT_EQ(fault_of(replaced(text, "MOMENTUM_DELTA = 70\n", "")),
            "m:15: MOMENTUM_ALPHA is given without MOMENTUM_DELTA in the SPIN block of an APM 2.0");
  EXPECT_EQ(fault_of(replaced(text, "SPIN_DELTA = 80", "SPIN_DELTA = 361")),
            "m:12: SPIN_DELTA = 361: an angle from -360 to 360 deg is wanted");
}

TEST(CcsdsApm, QuaternionDerivativeIsTheRate) {
  const std::string text =
      "CCSDS_APM_VERS = 2.0\nCREATION_DATE = 2024-01-01T00:00:00\nORIGINATOR = X\nOBJECT_NAME = Y\nOBJECT_ID = Z\n"
      "TIME_SYSTEM = UTC\nEPOCH = 2016-12-31T23:59:60.5\nQUAT_START\nREF_FRAME_A = SC_BODY_1\nREF_FRAME_B = ICRF\n"
      "Q1 = 0\nQ2 = 0\nQ3 = -0.7071067811865476\nQC = 0.7071067811865476\n"
      "Q1_DOT = 0.01\nQ2_DOT = 0.02\nQ3_DOT = 0 [1/s]\nQC_DOT = 0\nQUAT_STOP\n";
  // Along the quaternion only what rounding has: of a hundredth of it, and of the last decimal of the derivative.
  const auto warnings = [&](const std::string& derivative) {
    return parse_ccsds_attitude(replaced(text, "QC_DOT = 0\n", "QC_DOT = " + derivative + "\n"), "m")
        .at(0)
        .body.warnings;
  };
  EXPECT_TRUE(warnings("0.0002").empty());
  EXPECT_TRUE(warnings("0.01").empty());  // 0.005 to 0.015
  EXPECT_EQ(
      warnings("0.0202"),
      std::vector<std::string>{"line 11: the derivative of the quaternion has a part of 0.0143 1/s along the "
                               "quaternion, which is no rotation (rounding explains 0.0004 1/s); the rest is taken "
                               "as the rate"});
  const CcsdsAttitudeMessage m = parse_ccsds_attitude(text, "m").at(0);
  // ICRF from the body's axes is -90 deg about z: the body is turned by +90 deg.
  expect_attitude(*m.body.state->q_frame_from_named, turn(90, z));
  // q' = q w / 2 of ICRF relative to the body, w in ICRF axes; the body's own rate is -(q w).
  const Quaternion q = turn(-90, z);
  const Vector3 w = 2.0 * (q.conjugate() * Quaternion(0.0, 0.01, 0.02, 0.0)).vec();
  expect_rate(m.body.state->omega_named_rad_s, -(q * w));
  EXPECT_EQ(format_date(m.body.state->epoch, TimeScale::utc, 1), "2016-12-31T23:59:60.5");
  EXPECT_EQ(fault_of(replaced(text, "QC = 0.7", "QC = 0.9")),
            "m:11: the quaternion has length 1.15015; it must be 1 within 0.01");
  EXPECT_EQ(fault_of(replaced(text, "QC_DOT = 0\n", "")),
            "m:15: Q1_DOT is given without QC_DOT in the QUAT block of an APM 2.0");
  EXPECT_EQ(fault_of(replaced(text, "Q2 = 0\n", "Q2 = 0\nQ1 = 0\n")),
            "m:13: Q1 is repeated in the QUAT block of an APM 2.0 (first on line 11)");
  EXPECT_EQ(fault_of(replaced(text, "Q2 = 0\n", "")), "m:8: Q2 is missing in the QUAT block of an APM 2.0");
  EXPECT_EQ(fault_of(replaced(text, "QUAT_STOP\n", "")), "m:8: QUAT_START without QUAT_STOP");
  EXPECT_EQ(fault_of(replaced(text, "ORIGINATOR = X\n", "")), "m:1: ORIGINATOR is missing in the header of an APM 2.0");
  EXPECT_EQ(fault_of(replaced(text, "23:59:60.5", "23:59")),
            "m:7: EPOCH = 2016-12-31T23:59: a date YYYY-MM-DDThh:mm:ss[.d] or YYYY-DDDThh:mm:ss[.d] is wanted");
  EXPECT_EQ(fault_of(replaced(text, "REF_FRAME_B = ICRF", "REF_FRAME_B = SC_BODY_1")),
            "m:10: REF_FRAME_A and REF_FRAME_B are the same frame SC_BODY_1");
  EXPECT_EQ(fault_of(replaced(text, "APM_VERS = 2.0", "APM_VERS = 3.0")),
            "m:1: version '3.0' of the APM is unknown; 1.0 and 2.0 can be read");
  EXPECT_EQ(
      fault_of(replaced(text, "QUAT_START",
                        "INERTIA_START\nINERTIA_REF_FRAME = A\nIXX = 1\nIYY = 1\nIZZ = 1\nIXY = 0\nIXZ = 0\nIYZ = "
                        "0\nINERTIA_STOP\nQUAT_START")),
      "m:17: the QUAT block comes after the INERTIA block; their order is QUAT, EULER, ANGVEL, SPIN, INERTIA, MAN");
}

TEST(CcsdsApm, RatesThatContradictEachOtherAreToldOf) {
  const std::string text = read_text_file(samples + "valid/APMExample08.txt");
  const auto with_rates = [&](const std::string& rates) {
    return parse_ccsds_attitude(replaced(text, "QUAT_STOP", rates + "QUAT_STOP"), "m").at(0).body;
  };
  // A second ANGVEL block contradicts the first.
  const std::size_t begin = text.find("ANGVEL_START"), end = text.find("ANGVEL_STOP") + 12;
  const std::string block = replaced(text.substr(begin, end - begin), "ANGVEL_Y", "ANGVEL_Y = 1\nCOMMENT ");
  const Body twice = parse_ccsds_attitude(text.substr(0, end) + block + text.substr(end), "m").at(0).body;
  ASSERT_EQ(twice.warnings.size(), 1U);
  EXPECT_EQ(twice.warnings[0],
            "line 37: the ANGVEL block and that of line 28 differ by 0.95 deg/s; the ANGVEL block is used");
  const Body other = with_rates("Q1_DOT = 0.001 [1/s]\nQ2_DOT = 0\nQ3_DOT = 0\nQC_DOT = -0.000184791 [1/s]\n");
  ASSERT_EQ(other.warnings.size(), 1U);
  EXPECT_NE(other.warnings[0].find("the ANGVEL block and the rates of the QUAT block (line 18) differ by 0.141 deg/s"),
            std::string::npos)
      << other.warnings[0];
  expect_rate(other.state->omega_named_rad_s, degree * Vector3(0.0001, 0.05, 0.00003));  // of the ANGVEL block
  EXPECT_TRUE(with_rates("").warnings.empty());
}

TEST(CcsdsUnits, AreKnownInAnyCaseOfLetters) {
  EXPECT_EQ(unit_factor("KG*M**2", "kg*m**2"), 1.0);
  EXPECT_EQ(unit_factor("DEG/S", "deg/s"), 1.0);
  EXPECT_EQ(unit_factor("rpm", "deg/s"), 6.0);
  EXPECT_EQ(unit_factor("REV/MIN", "deg/s"), 6.0);
  EXPECT_EQ(unit_factor("mN*M", "N*m"), 1e-3);
  EXPECT_EQ(unit_factor("furlong", "m"), std::nullopt);
}

TEST(CcsdsAem, QuaternionsScalarLastFirstAndReversed) {
  const AttitudeHistory last = *read("valid/AEMExample01.txt").history;
  ASSERT_EQ(last.segments.size(), 2U);
  expect_attitude(last.segments[0].samples[0].q_frame_from_body, Quaternion(0.68427, 0.56748, 0.03146, 0.45689));
  EXPECT_EQ(format_date(last.segments[1].samples[3].time, TimeScale::utc, 4), "1996-12-28T21:28:00.5555");

  const AttitudeHistory first = *read("valid/AEMExample04.txt").history;
  const Quaternion q(0.488615, -0.402157, 0.581628, 0.511111);
  expect_attitude(first.segments[0].samples[0].q_frame_from_body, q);
  const Quaternion dot(0.000300776, 0.000259458, -0.000283621, 0.000239362);
  expect_rate(first.segments[0].samples[0].omega_body_rad_s, 2.0 * (q.normalized().conjugate() * dot).vec());

  const AttitudeHistory reversed = *read("valid/AEMExample08.txt").history;
  EXPECT_EQ(reversed.segments[0].frame, "GTOD");
  EXPECT_EQ(reversed.segments[0].body, "STARTRACKER_2");
  // B2A: the rotation leads from GTOD to the tracker.
  expect_attitude(reversed.segments[0].samples[0].q_frame_from_body, Quaternion(0.68427, 0.56748, 0.03146, 0.45689));
}

TEST(CcsdsAem, EulerAngles) {
  const AttitudeHistory kvn = *read("valid/AEMExample05.txt").history;
  expect_attitude(kvn.segments[0].samples[0].q_frame_from_body, turn(-26.78, z) * turn(46.26, x) * turn(144.10, y));
  const AttitudeHistory xml = *read("valid/AEMExample11.xml").history;
  ASSERT_EQ(xml.segments[0].samples.size(), 2U);
  expect_attitude(xml.segments[0].samples[0].q_frame_from_body, turn(45, x) * turn(0.9, y) * turn(15, z));
  // Rates 4.5, 0.123, 15 deg/s of the angles: each about its axis as the body sees it.
  const Vector3 rate = degree * (4.5 * (turn(-15, z) * turn(-0.9, y) * x) + 0.123 * (turn(-15, z) * y) + 15.0 * z);
  expect_rate(xml.segments[0].samples[0].omega_body_rad_s, rate);
}

TEST(CcsdsAem, TurnsOfMoreThanHalfPerRowAreFollowedByTheirRates) {
  const AttitudeHistory h = *read("valid/AEMExample14.txt").history;
  ASSERT_EQ(h.segments.size(), 5U);
  expect_attitude(h.segments[0].samples[1].q_frame_from_body, turn(40, z) * turn(50, x) * turn(-40, z));
  // SPIN/NUTATION_MOM: alpha 10, delta 30, angle 0.
  expect_attitude(h.segments[1].samples[0].q_frame_from_body, turn(100, z) * turn(60, x));
  expect_attitude(h.segments[2].samples[0].q_frame_from_body, Quaternion(0.925417, 0.171010, -0.030154, 0.336824));
  // Segments 4 and 5 are the same motion in quaternions and in Euler angles, at 18.29 deg/s, 10 s apart.
  const AttitudeSegment& quaternions = h.segments[3];
  const AttitudeSegment& angles = h.segments[4];
  expect_attitude(quaternions.samples[0].q_frame_from_body, Quaternion(0.347679, 0.056482, 0.209807, -0.912091));
  expect_rate(quaternions.samples[0].omega_body_rad_s, degree * Vector3(-0.021029, 0.023643, 18.288407));
  for (std::size_t i = 0; i + 1 < quaternions.samples.size(); ++i) {
    for (const double part : {0.25, 0.5, 0.75}) {
      const Instant t = quaternions.samples[i].time + Seconds{10.0 * part, 0.0};
      const AttitudeSample a = interpolate(quaternions, t);
      expect_attitude(a.q_frame_from_body, interpolate(angles, t).q_frame_from_body, 3e-6);
      EXPECT_NEAR(a.omega_body_rad_s->z(), 18.29 * degree, 0.05 * degree);
      // From the row before, by a steady turn at the rates given: far from what the shortest way would say.
      const Quaternion steady = quaternions.samples[i].q_frame_from_body * turn(18.29 * 10.0 * part, z);
      expect_attitude(a.q_frame_from_body, steady, 0.02);
    }
  }
}

TEST(CcsdsAem, WhatTheStandardForbids) {
  const std::string text = read_text_file(samples + "valid/AEMExample04.txt");
  EXPECT_EQ(fault_of(replaced(text, "00:00:00.500    0.488765", "00:00:00.000    0.488765")),
            "m:26: time 2021-12-31T00:00:00.000 is not after the one above; times increase");
  EXPECT_EQ(fault_of(replaced(text, "ATTITUDE_DIR         = A2B\n", "")),
            "m:5: ATTITUDE_DIR is missing in the metadata of an AEM 1.0");
  EXPECT_EQ(fault_of(replaced(text, "= FIRST", "= MIDDLE")),
            "m:18: QUATERNION_TYPE = MIDDLE is not one of: FIRST LAST");
  EXPECT_EQ(fault_of(replaced(text, "INTERPOLATION_DEGREE = 3", "INTERPOLATION_DEGREE = x")),
            "m:20: INTERPOLATION_DEGREE = x: a whole number above 0 is wanted");
  EXPECT_EQ(fault_of(replaced(text, "0.000239362", "")),
            "m:25: 8 words; a line of type QUATERNION/DERIVATIVE has an epoch and 8 numbers");
  EXPECT_EQ(fault_of(replaced(text, "T00:00:00.000\nUSEABLE", "T00:00:02.000\nUSEABLE")),
            "m:14: USEABLE_START_TIME is outside of START_TIME to STOP_TIME");
  EXPECT_EQ(fault_of(replaced(text, "STOP_TIME            = 2021-12-31T00:00:06.000",
                              "STOP_TIME            = 2021-12-30T00:00:06.000")),
            "m:16: STOP_TIME is before START_TIME");
  EXPECT_EQ(fault_of(replaced(text, "DATA_STOP", "")), "m:23: DATA_START without DATA_STOP");
  EXPECT_EQ(fault_of(replaced(text, "CCSDS_AEM_VERS       = 1.0", "CCSDS_OEM_VERS = 2.0")),
            "m:1: the message is of kind OEM, which holds no attitude; attitude messages are APM, AEM and ACM");
  // Version 2 types under version 1 are read, with a warning.
  const std::string mixed =
      replaced(read_text_file(samples + "valid/AEMExample05.txt"), "EULER_ANGLE/RATE", "EULER_ANGLE/DERIVATIVE");
  const CcsdsAttitudeMessage m = parse_ccsds_attitude(mixed, "m").at(0);
  EXPECT_NE(m.body.warnings.at(0).find("of version 2 under a header of version 1"), std::string::npos);
}

TEST(CcsdsAcm, Histories) {
  const CcsdsAttitudeMessage one = read("valid/ACMExample01.txt");
  expect_attitude(one.history->segments[0].samples[1].q_frame_from_body,
                  Quaternion(0.181158, 0.73529, -0.50531, 0.41375));
  EXPECT_EQ(format_date(one.history->segments[0].samples[1].time, TimeScale::utc, 4), "1998-12-18T14:28:15.3672");
  EXPECT_EQ(one.body.missing, (std::vector<std::string>{"an angular velocity", "an inertia"}));

  const CcsdsAttitudeMessage five = read("valid/ACMExample05.txt");
  ASSERT_EQ(five.history->segments.size(), 5U);
  const auto row = [&](std::size_t segment, std::size_t i) { return five.history->segments[segment].samples[i]; };
  expect_attitude(row(1, 0).q_frame_from_body, turn(1.0, x) * turn(1.2, y) * turn(1.3, z));
  expect_rate(row(1, 0).omega_body_rad_s, degree * Vector3(-0.4, -0.5, -0.6));
  // The columns of the matrix of B from A are (0,1,0), (0,0,1), (1,0,0): x of A is y of B, y is z, z is x.
  EXPECT_LT((row(3, 1).q_frame_from_body * y - x).norm() + (row(3, 1).q_frame_from_body * z - y).norm(), 1e-15);
  EXPECT_FALSE(row(4, 0).omega_body_rad_s.has_value());
  EXPECT_TRUE(five.body.inertia.has_value());
  EXPECT_EQ(five.body.missing.size(), 1U);  // inertia in SC_BODY_2, attitudes of other axes
}

TEST(CcsdsAcm, WhatTheStandardForbids) {
  const std::string text = read_text_file(samples + "valid/ACMExample05.txt");
  EXPECT_EQ(fault_of(replaced(text, "NUMBER_STATES            = 13", "NUMBER_STATES            = 12")),
            "m:87: NUMBER_STATES = 12, but DCM with rate Q_DOT has 13");
  EXPECT_EQ(fault_of(replaced(text, " 1.096694 6.74E-11 8.10E-11", " 1.096694 6.74E-11 -8.10E-11")),
            "m:135: variance -8.10E-11 is negative");
  EXPECT_EQ(fault_of(replaced(text, "MAN_DURATION             = 450.0",
                              "MAN_DURATION             = 450.0\nMAN_END_TIME = 5")),
            "m:204: either MAN_END_TIME or MAN_DURATION is given, not both");
  EXPECT_EQ(fault_of(replaced(text, "TARGET_MOMENTUM          = 1.30 -16.400 -11.350\n", "")),
            "m:206: TARGET_MOM_FRAME is given without TARGET_MOMENTUM");
  EXPECT_EQ(
      fault_of(replaced(text, "NUMBER_SENSOR_NOISE_COVARIANCE    =  2", "NUMBER_SENSOR_NOISE_COVARIANCE    =  3")),
      "m:251: NUMBER_SENSOR_NOISE_COVARIANCE = 3, but SENSOR_NOISE_STDDEV has 2");
  EXPECT_EQ(fault_of(replaced(text, "ATT, ATT, PHYS", "ATT, PHYS")).substr(0, 30), "m:25: ACM_DATA_ELEMENTS = ATT,");
  EXPECT_EQ(fault_of(replaced(text, "0.25    0.73529", "2016-03-15T00:00:01    0.73529")),
            "m:45: time 2016-03-15T00:00:01: relative and absolute times are mixed in the ATT block of an ACM 2.0");
  EXPECT_EQ(fault_of(replaced(text, "IXX                         = 752  ", "IXX                         = -752  ")),
            "m:118: IXX = -752: a positive number is wanted");
  EXPECT_EQ(
      fault_of(replaced(text, "IXX                         = 752  ", "IXX                         = 1  ")).substr(0, 6),
      "m:118:");
  EXPECT_EQ(fault_of(replaced(text, "CP                          = 0.04 -0.78 -0.023 [m]\n", "")),
            "m:115: CP_REF_FRAME is given without CP");
  EXPECT_EQ(fault_of(replaced(text, "0.0 0.0 -0.707106781187 0.707106781187", "0.0 0.0 -0.7 0.9")),
            "m:218: the quaternion has length 1.14018; it must be 1 within 0.01");
  EXPECT_EQ(fault_of(text + "PHYS_START\nPHYS_STOP\n").substr(0, 37), "m:25: ACM_DATA_ELEMENTS = ATT, ATT, A");
}

TEST(CcsdsNdm, CombinedMessage) {
  const auto body_of = [](const std::string& file) {
    std::string text = read_text_file(samples + file);
    return text.substr(text.find('\n') + 1);
  };
  const std::string ndm =
      "<?xml version=\"1.0\"?>\n<ndm>\n<COMMENT>two</COMMENT>\n<opm id=\"CCSDS_OPM_VERS\" version=\"2.0\"/>\n" +
      body_of("valid/APM-quaternion-angvel.xml") + body_of("valid/AEMExample11.xml") + "</ndm>\n";
  const std::vector<CcsdsAttitudeMessage> messages = parse_ccsds_attitude(ndm, "m");
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0].kind, "APM");
  EXPECT_EQ(messages[1].kind, "AEM");
  EXPECT_EQ(messages[0].body.notes.back(), "the file also holds an OPM, not read");
  EXPECT_EQ(fault_of("<ndm>\n<opm/></ndm>"), "m:1: the NDM holds no APM, AEM or ACM");
  EXPECT_EQ(fault_of("<apm id=\"CCSDS_APM_VERS\" version=\"2.0\">\n<header>\n</apm>").substr(0, 15), "m:3: broken XML");
}

TEST(Units, KnownOnesConvert) {
  EXPECT_EQ(unit_factor("deg", "deg"), 1.0);
  EXPECT_DOUBLE_EQ(unit_factor("rad/s", "deg/s").value(), 180.0 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(unit_factor("rev/min", "deg/s").value(), 6.0);
  EXPECT_DOUBLE_EQ(unit_factor("g*cm**2", "kg*m**2").value(), 1e-7);
  EXPECT_DOUBLE_EQ(unit_factor("kg*m^2/s^2", "N*m").value(), 1.0);
  EXPECT_DOUBLE_EQ(unit_factor("deg/min**0.5", "deg/s**0.5").value(), 1.0 / std::sqrt(60.0));
  EXPECT_EQ(unit_factor("Hz", "1/s"), 1.0);
  for (const char* bad : {"deg", "furlong", "", "deg//s", "deg/s/", "deg**", "**2", "deg**x"}) {
    EXPECT_FALSE(unit_factor(bad, "deg/s").has_value()) << bad;
  }
}

TEST(Units, AreTheSameInFilesAndOptions) {
  EXPECT_EQ(angular_velocity_unit_rad_s("deg/day"), degree / day_s);
  EXPECT_EQ(angular_velocity_unit_rad_s("deg/d"), degree / day_s);
  EXPECT_EQ(angular_velocity_unit_rad_s("deg/min"), degree / 60.0);
  EXPECT_EQ(angular_velocity_unit_rad_s("rad s^-1"), 1.0);
  EXPECT_DOUBLE_EQ(angular_velocity_unit_rad_s("rpm"), std::numbers::pi / 30.0);
  EXPECT_EQ(angle_unit_rad("mas"), degree / 3.6e6);
  EXPECT_EQ(duration_unit_s("min"), 60.0);
  EXPECT_EQ(length_unit_m("km"), 1e3);
  EXPECT_EQ(speed_unit_m_s("km/s"), 1e3);
  for (const char* unit : {"kg m2", "kg m^2", "kg*m**2", "kg m**2", "N m s^2"}) {
    EXPECT_EQ(inertia_unit(unit).factor, 1.0) << unit;
    EXPECT_TRUE(inertia_unit(unit).absolute) << unit;
  }
  EXPECT_DOUBLE_EQ(inertia_unit("slug ft2").factor, 0.45359237 * 9.80665 * 0.3048);
  EXPECT_EQ(angular_momentum_unit("N m s").factor, 1.0);
  EXPECT_EQ(angular_momentum_unit("kg m2/s").factor, 1.0);
  EXPECT_FALSE(angular_momentum_unit("ratios/s").absolute);
  for (const char* bad : {"Kg m2", "kg", "kg m2/", "kg  / m2", "m2 kg s", "", "2 kg m2", "kg m2 2", "100 kg m2"}) {
    EXPECT_THROW(inertia_unit(bad), InputError) << bad;
  }
}

}  // namespace
}  // namespace polhode
