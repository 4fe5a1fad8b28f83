// Attitude histories: interpolated and resampled, on motions in closed form.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/ephemeris/resample.hpp"

namespace polhode {
namespace {

// --- A coning motion: a spin about the body's z while z circles about the frame's z. ---------------------------------

constexpr double precession_rad_s = 0.3;
constexpr double spin_rad_s = 0.2;
constexpr double wide_cone_rad = 0.5;

Quaternion about(const Vector3& axis, double angle_rad) { return Quaternion(Eigen::AngleAxisd(angle_rad, axis)); }

Quaternion coning_attitude(double t_s, double cone_rad = wide_cone_rad) {
  return about(Vector3::UnitZ(), precession_rad_s * t_s) * about(Vector3::UnitX(), cone_rad) *
         about(Vector3::UnitZ(), spin_rad_s * t_s);
}

Vector3 coning_rate(double t_s, double cone_rad = wide_cone_rad) {
  const Quaternion tilt = about(Vector3::UnitX(), cone_rad) * about(Vector3::UnitZ(), spin_rad_s * t_s);
  return tilt.conjugate() * Vector3(0.0, 0.0, precession_rad_s) + Vector3(0.0, 0.0, spin_rad_s);
}

Instant at(double t_s) { return parse_date("2020-01-01T00:00:00", TimeScale::utc) + Seconds{t_s, 0.0}; }

/// Rows of the coning motion, signs of the quaternions at random.
AttitudeHistory coning(AttitudeInterpolation method, int degree, bool rates, double step_s, int rows,
                       double cone_rad = wide_cone_rad) {
  AttitudeSegment segment;
  segment.frame = "EME2000";
  segment.body = "SC_BODY_1";
  segment.known_frame = Frame::eme2000;
  segment.method = method;
  segment.degree = degree;
  segment.method_stated = true;
  for (int i = 0; i < rows; ++i) {
    Quaternion q = coning_attitude(i * step_s, cone_rad);
    if (i % 3 == 1) q.coeffs() *= -1.0;
    segment.samples.push_back(
        {at(i * step_s), q, rates ? std::optional(coning_rate(i * step_s, cone_rad)) : std::nullopt});
  }
  AttitudeHistory history;
  history.object = "CONE";
  history.object_id = "2020-001A";
  history.segments = {segment};
  return history;
}

AttitudeBlock rows_of(const Ephemeris& ephemeris) {
  AttitudeBlock block;
  ephemeris.fill(0, ephemeris.times().size(), {TimeResolution::Kind::two_doubles}, block);
  return block;
}

Quaternion attitude(const AttitudeBlock& block, std::size_t row) {
  return from_scalar_first(Eigen::Map<const Eigen::Vector4d>(&block.q_frame_from_named[4 * row]));
}

Vector3 rate(const AttitudeBlock& block, std::size_t row) {
  return Eigen::Map<const Vector3>(&block.omega_named_rad_s[3 * row]);
}

bool sign_is_continuous(const AttitudeBlock& block) {
  for (std::size_t i = 1; i < block.rows; ++i) {
    if (attitude(block, i).dot(attitude(block, i - 1)) <= 0.0) return false;
  }
  return true;
}

double elapsed(const Ephemeris& ephemeris, const AttitudeBlock& block, std::size_t row) {
  return (ephemeris.times().instant(block.time[row]) - at(0.0)).high;
}

TEST(Resample, OwnRowsAreTakenOver) {
  const AttitudeHistory history = coning(AttitudeInterpolation::hermite, 7, true, 1.5, 40);
  const std::vector<Ephemeris> out = resample(history, {}, TimeScale::utc, std::nullopt);
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].frame_name(), "EME2000");
  EXPECT_EQ(out[0].description().object_id, "2020-001A");
  EXPECT_EQ(out[0].description().ccsds_interpolation, "HERMITE");
  EXPECT_EQ(out[0].description().ccsds_interpolation_degree, 7);
  EXPECT_FALSE(out[0].inertia());
  const AttitudeBlock block = rows_of(out[0]);
  ASSERT_EQ(block.rows, 40U);
  EXPECT_TRUE(sign_is_continuous(block));
  for (std::size_t i = 0; i < block.rows; ++i) {
    const AttitudeSample& row = history.segments[0].samples[i];
    EXPECT_EQ(out[0].times().instant(block.time[i]), row.time);
    EXPECT_EQ(std::abs(attitude(block, i).dot(row.q_frame_from_body)), row.q_frame_from_body.squaredNorm());
    EXPECT_EQ(rate(block, i), *row.omega_body_rad_s);
  }
}

TEST(Interpolation, RowsMoreThanHalfATurnApartAreDoubted) {
  using enum AttitudeInterpolation;
  const auto doubt = [](AttitudeInterpolation method, bool rates, std::initializer_list<double> turns_deg) {
    AttitudeSegment segment;
    segment.method = method;
    segment.degree = 7;
    double angle_deg = 0.0, t_s = 0.0;
    for (const double turn_deg : turns_deg) {
      segment.samples.push_back({at(t_s), about(Vector3::UnitX(), angle_deg * std::numbers::pi / 180.0), std::nullopt});
      if (rates) segment.samples.back().omega_body_rad_s = Vector3(turn_deg * std::numbers::pi / 180.0, 0.0, 0.0);
      angle_deg += turn_deg;
      t_s += 1.0;
    }
    return doubt_about_interpolation(segment).value_or("none");
  };
  for (const bool rates : {false, true}) {
    for (const AttitudeInterpolation method : {linear, lagrange, hermite}) {
      EXPECT_EQ(doubt(method, rates, {150.0, 160.0, 170.0, 178.0, 170.0}), "none");
    }
  }
  const std::string by_rates = "rows 3 and 4 are more than half a turn apart, by their rates; LAGRANGE takes the ";
  EXPECT_EQ(doubt(lagrange, true, {150.0, 170.0, 185.0, 180.0}).substr(0, by_rates.size()), by_rates);
  EXPECT_EQ(doubt(linear, true, {150.0, 170.0, 185.0, 180.0}), "none");  // rates count turns
  EXPECT_EQ(doubt(hermite, true, {150.0, 170.0, 185.0, 180.0}), "none");
  for (const AttitudeInterpolation method : {linear, lagrange, hermite}) {
    const std::string by_rows = "rows 3 and 4 are more than half a turn apart, by the turn before them";
    EXPECT_EQ(doubt(method, false, {150.0, 170.0, 185.0, 180.0}).substr(0, by_rows.size()), by_rows);
  }
}

TEST(Resample, EachMethodMeetsTheMotionAndItsRate) {
  struct Case {
    AttitudeInterpolation method;
    int degree;
    bool rates;
    double attitude_rad, rate_rad_s;  // allowed
  };
  // At rows 0.5 s apart; LINEAR is 2nd order in the attitude and 1st in the rate, the others as their degree says.
  for (const Case& c : {Case{AttitudeInterpolation::linear, 1, false, 5e-3, 2e-2},
                        Case{AttitudeInterpolation::lagrange, 5, false, 3e-6, 3e-5},
                        Case{AttitudeInterpolation::lagrange, 7, true, 6e-8, 6e-7},
                        Case{AttitudeInterpolation::hermite, 3, true, 3e-6, 3e-5},
                        Case{AttitudeInterpolation::hermite, 7, true, 1e-10, 3e-9}}) {
    WantedTimes wanted;
    wanted.step = Seconds{0.07, 0.0};
    const AttitudeHistory history = coning(c.method, c.degree, c.rates, 0.5, 61);
    const std::vector<Ephemeris> out = resample(history, wanted, TimeScale::tdb, Frame::ecliptic_j2000);
    ASSERT_EQ(out.size(), 1U);
    EXPECT_EQ(out[0].frame_name(), "ECLIPJ2000");
    const AttitudeBlock block = rows_of(out[0]);
    EXPECT_EQ(block.rows, 429U);
    EXPECT_TRUE(sign_is_continuous(block));
    const Quaternion turned = q_icrf_from(Frame::ecliptic_j2000).conjugate() * q_icrf_from(Frame::eme2000);
    for (std::size_t i = 0; i < block.rows; ++i) {
      const double t = elapsed(out[0], block, i);
      EXPECT_LE(rotation_angle_rad(attitude(block, i), turned * coning_attitude(t)), c.attitude_rad) << t;
      EXPECT_LE((rate(block, i) - coning_rate(t)).norm(), c.rate_rad_s) << name(c.method) << c.degree << " at " << t;
    }
  }
}

TEST(Resample, TurnsBeyond180DegreesFollowTheRates) {
  constexpr double narrow_cone_rad = 0.05;
  const AttitudeHistory history =
      coning(AttitudeInterpolation::hermite, 7, true, 13.0, 12, narrow_cone_rad);  // 6.5 rad
  WantedTimes wanted;
  wanted.step = Seconds{0.25, 0.0};
  const Ephemeris out = resample(history, wanted, TimeScale::utc, std::nullopt).at(0);
  const AttitudeBlock block = rows_of(out);
  EXPECT_TRUE(sign_is_continuous(block));
  double worst = 0.0;
  for (std::size_t i = 0; i < block.rows; ++i) {
    const Quaternion expected = coning_attitude(elapsed(out, block, i), narrow_cone_rad);
    worst = std::max(worst, rotation_angle_rad(attitude(block, i), expected));
  }
  EXPECT_LT(worst, 0.25);  // the cone is not resolved; the shortest way would be off by up to 180 deg
}

TEST(Resample, NothingLiesOutsideOfASegment) {
  AttitudeHistory history = coning(AttitudeInterpolation::lagrange, 3, false, 1.0, 11);
  history.segments[0].usable_start = at(1.5);
  history.segments[0].usable_stop = at(8.5);
  history.segments.push_back(history.segments[0]);
  AttitudeSegment& second = history.segments[1];
  second.usable_start.reset();
  second.usable_stop.reset();
  for (AttitudeSample& row : second.samples) row.time = row.time + Seconds{20.0, 0.0};

  std::vector<Ephemeris> out = resample(history, {}, TimeScale::utc, std::nullopt);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].times().size(), 7U);  // rows 2 to 8 s
  EXPECT_EQ(out[1].times().size(), 11U);

  WantedTimes wanted;
  wanted.start = at(3.0);
  wanted.stop = at(24.0);
  wanted.step = Seconds{0.5, 0.0};
  out = resample(history, wanted, TimeScale::utc, std::nullopt);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].times().size(), 12U);  // 3.0 to 8.5
  EXPECT_EQ(out[1].times().size(), 9U);   // 20.0 to 24.0

  wanted = {};
  wanted.list = {at(1.5), at(8.5), at(20.0)};
  out = resample(history, wanted, TimeScale::utc, std::nullopt);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].times().size(), 2U);

  const auto fault = [&](const WantedTimes& times) -> std::string {
    try {
      resample(history, times, TimeScale::utc, std::nullopt);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string outside =
      " UTC is outside of the attitude history, which can be used from 2020-01-01T00:00:01.500 to "
      "2020-01-01T00:00:08.500, 2020-01-01T00:00:20.000 to 2020-01-01T00:00:30.000 UTC";
  wanted = {};
  wanted.list = {at(1.4)};
  EXPECT_EQ(fault(wanted), "2020-01-01T00:00:01.400" + outside);
  wanted.list = {at(3.0), at(9.0)};
  EXPECT_EQ(fault(wanted), "2020-01-01T00:00:09.000" + outside);
  wanted = {};
  wanted.stop = at(31.0);
  EXPECT_EQ(fault(wanted), "2020-01-01T00:00:31.000" + outside);
  wanted = {};
  wanted.start = at(15.0);
  EXPECT_EQ(fault(wanted), "2020-01-01T00:00:15.000" + outside);
  wanted.start = at(5.0);
  wanted.stop = at(4.0);
  EXPECT_EQ(fault(wanted), "stop is before start");
  wanted = {};
  wanted.start = at(5.2);
  wanted.stop = at(5.8);
  EXPECT_EQ(fault(wanted).substr(0, 12), "no row of th");
}

/// The polynomials of the components, by their definition: what a promise for LAGRANGE in a file is about.
TEST(Resample, LagrangeIsOfTheQuaternionsComponents) {
  for (const bool rates : {false, true}) {
    const AttitudeHistory history = coning(AttitudeInterpolation::lagrange, 7, rates, 1.1, 30);
    WantedTimes wanted;
    wanted.step = Seconds{0.17, 0.0};
    const Ephemeris out = resample(history, wanted, TimeScale::utc, std::nullopt).at(0);
    const AttitudeBlock block = rows_of(out);
    for (std::size_t i = 0; i < block.rows; ++i) {
      const double position = elapsed(out, block, i) / 1.1;
      const double first = std::clamp(std::floor(position) - 3.0, 0.0, 22.0);
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      for (int k = 0; k < 8; ++k) {
        double weight = 1.0;
        for (int l = 0; l < 8; ++l) {
          if (l != k) weight *= (position - first - l) / (k - l);
        }
        sum += weight * coning_attitude((first + k) * 1.1).coeffs();
      }
      EXPECT_LE(rotation_angle_rad(attitude(block, i), Quaternion(sum).normalized()), 1e-12) << position;
    }
  }
}

std::string overlap_of(const AttitudeHistory& history) {
  for (const bool compared : {true, false}) {
    try {
      if (compared) {
        compare(history, history);
      } else {
        resample(history, {}, TimeScale::utc, std::nullopt);
      }
      return "accepted";
    } catch (const InputError& error) {
      if (!compared) return error.what();
    }
  }
  return "";
}

TEST(Segments, MayShareAnInstantAtMost) {
  AttitudeHistory history = coning(AttitudeInterpolation::linear, 1, true, 1.0, 11);
  history.segments.push_back(history.segments[0]);
  EXPECT_EQ(overlap_of(history),
            "segments 1 and 2 of the attitude history both hold from 2020-01-01T00:00:00.000 to "
            "2020-01-01T00:00:10.000 UTC; segments may share an instant at most: USEABLE_START_TIME and "
            "USEABLE_STOP_TIME say where each is to be used");
  // The second 2 s later, and turned: the rows of each beyond its usable span do not count.
  for (AttitudeSample& row : history.segments[1].samples) {
    row.time = row.time + Seconds{2.0, 0.0};
    row.q_frame_from_body = row.q_frame_from_body * about(Vector3::UnitY(), 1.0);
  }
  EXPECT_EQ(overlap_of(history).substr(0, 14), "segments 1 and");
  history.segments[0].usable_stop = at(6.0);
  history.segments[1].usable_start = at(5.5);
  EXPECT_EQ(overlap_of(history).substr(0, 14), "segments 1 and");
  history.segments[1].usable_start = at(6.0);
  EXPECT_EQ(overlap_of(history), "accepted");
  const AttitudeDifference same = compare(history, history);
  EXPECT_EQ(same.compared, 14U);  // 0 to 6 s and 6 to 12 s
  EXPECT_LE(same.largest_rad, 1e-14);
  // A third, not beside the first by its begin.
  history.segments.push_back(history.segments[0]);
  history.segments[1].usable_start = history.segments[1].usable_stop = at(3.0);
  history.segments[2].usable_start = at(4.0);
  EXPECT_EQ(overlap_of(history).substr(0, 18), "segments 1 and 3 o");
}

TEST(Resample, WhatCannotBeDone) {
  AttitudeHistory history = coning(AttitudeInterpolation::linear, 1, false, 1.0, 3);
  history.segments[0].frame = "LVLH";
  history.segments[0].known_frame.reset();
  EXPECT_EQ(resample(history, {}, TimeScale::utc, std::nullopt).at(0).frame_name(), "LVLH");
  EXPECT_THROW(resample(history, {}, TimeScale::utc, Frame::icrf), InputError);
  history.segments[0].samples.resize(1);
  EXPECT_THROW(resample(history, {}, TimeScale::utc, std::nullopt), InputError);  // no rate to be had
  history = coning(AttitudeInterpolation::linear, 1, false, 1.0, 3);
  history.absolute_time = false;
  EXPECT_THROW(resample(history, {}, TimeScale::utc, std::nullopt), InputError);
}

}  // namespace
}  // namespace polhode
