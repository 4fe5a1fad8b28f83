// Time scales: defining relations, leap-second edges, text in and out. astropy checks the same functions over random
// epochs in python_checks/test_time_and_frames.py.
#include <erfa.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <random>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/time/leap_seconds.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {
namespace {

double apart_s(Instant a, Instant b) { return (a - b).high; }

TEST(Time, ScalesAtJ2000) {
  const Instant j2000 = parse_date("2000-01-01T12:00:00", TimeScale::tt);
  EXPECT_EQ(j2000.tt_since_j2000().high, 0.0);
  EXPECT_EQ(format_date(j2000, TimeScale::tai, 9), "2000-01-01T11:59:27.816000000");
  EXPECT_EQ(format_date(j2000, TimeScale::utc, 9), "2000-01-01T11:58:55.816000000");
  EXPECT_EQ(format_date(j2000, TimeScale::gps, 3), "2000-01-01T11:59:08.816");
  // SPICE: unitim_c(0, "TDT", "ET") = -9.927e-05 (J2000 TDT), from the formula in the time required reading.
  EXPECT_NEAR(since_j2000(j2000, TimeScale::et).high, 1.657e-3 * std::sin(6.239996 + 1.671e-2 * std::sin(6.239996)),
              1e-15);
}

TEST(Time, LeapSecondOf2016) {
  const auto utc = [](const char* text) { return parse_date(text, TimeScale::utc); };
  EXPECT_EQ(apart_s(utc("2016-12-31T23:59:60"), utc("2016-12-31T23:59:59")), 1.0);
  EXPECT_EQ(apart_s(utc("2017-01-01T00:00:00"), utc("2016-12-31T23:59:60")), 1.0);
  EXPECT_EQ(format_date(utc("2016-12-31T23:59:60.25"), TimeScale::utc, 2), "2016-12-31T23:59:60.25");
  EXPECT_EQ(format_date(utc("2016-12-31T23:59:60.25"), TimeScale::tai, 2), "2017-01-01T00:00:36.25");
  EXPECT_EQ(format_date(utc("2016-12-31T23:59:60.996"), TimeScale::utc, 2), "2017-01-01T00:00:00.00");
  EXPECT_EQ(format_date(utc("2016-12-31T23:59:59.996"), TimeScale::utc, 2), "2016-12-31T23:59:60.00");
  EXPECT_EQ(format_date(utc("2015-12-31T23:59:59.996"), TimeScale::utc, 2), "2016-01-01T00:00:00.00");
}

TEST(Time, MidnightStaysMidnight) {
  for (const char* text : {"1972-01-01T00:00:00.000000000000", "1968-02-01T00:00:00.000000000000",
                           "2017-01-01T00:00:00.000000000000", "1961-01-01T00:00:00.000000000000"}) {
    EXPECT_EQ(format_date(parse_date(text, TimeScale::utc), TimeScale::utc, 12), text);
  }
}

TEST(Time, TheSameDateInEveryNotation) {
  const Instant want = parse_date("2012-12-13T08:30:09", TimeScale::tdb);
  EXPECT_EQ(parse_date("2012-348T08:30:09", TimeScale::tdb), want);
  EXPECT_EQ(parse_date(" 2012-12-13 08:30:09.000 ", TimeScale::tdb), want);
  EXPECT_LT(std::abs(apart_s(parse_date("JD 2456274.854270833333333", TimeScale::tdb), want)), 1e-10);
  EXPECT_LT(std::abs(apart_s(parse_date("mjd 56274 0.354270833333333333", TimeScale::tdb), want)), 1e-11);
  EXPECT_EQ(parse_date_with_scale("2012-12-13T08:30:09 tdb").instant, want);
  EXPECT_EQ(parse_date_with_scale("2012-12-13T08:30:09Z").scale, TimeScale::utc);
  EXPECT_EQ(parse_date_with_scale("2012-12-13 08:30:09", TimeScale::et).scale, TimeScale::et);
}

TEST(Time, TextGoesRoundInEveryScale) {
  std::mt19937_64 random(20290413);
  std::uniform_real_distribution<double> since(-1.26e9, 3.15e9);  // 1960 to 2100
  for (int i = 0; i < 300; ++i) {
    const Instant instant = Instant::from_tt_j2000({since(random), 1e-9 * static_cast<double>(random() % 1000)});
    for (const TimeScale scale :
         {TimeScale::tt, TimeScale::tai, TimeScale::utc, TimeScale::tdb, TimeScale::gps, TimeScale::et}) {
      const std::string text = format_date(instant, scale, 12);
      const Instant back = parse_date(text, scale);
      ASSERT_LE(std::abs(apart_s(back, instant)), 0.6e-12) << text << " " << name(scale);
      ASSERT_EQ(format_date(back, scale, 12), text) << name(scale);
      ASSERT_LE(std::abs(apart_s(instant_from_j2000(since_j2000(instant, scale), scale), instant)), 1e-15);
    }
  }
}

TEST(Time, TdbAgreesWithErfa) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> since(-3.16e9, 3.16e9);  // 1900 to 2100
  double worst = 0.0;
  const auto compare = [&worst](double tt_s) {
    const Instant instant = Instant::from_tt_j2000({tt_s, 0.0});
    const double ours = (since_j2000(instant, TimeScale::tdb) - Seconds{tt_s, 0.0}).high;
    const double difference = ours - eraDtdb(2451545.0, tt_s / 86400.0, 0.0, 0.0, 0.0, 0.0);
    ASSERT_TRUE(std::isfinite(difference));
    worst = std::max(worst, std::abs(difference));
  };
  for (int i = 0; i < 3000; ++i) compare(since(random));
  constexpr double piece_s = 8.0 * 86400.0;  // at both sides of their borders
  for (int i = -20; i < 20; ++i) {
    compare(i * piece_s);
    compare(std::nextafter(i * piece_s, -1e10));
  }
  EXPECT_LT(worst, 1e-15) << "s";
}

TEST(Time, AMillionDatesInTdbTakeASecond) {
  const auto begin = std::clock();
  double sum = 0.0;
  for (int i = 0; i < 100'000; ++i) {
    const std::string text = fmt::format("20{:02}-{:02}-{:02}T12:00:00", i % 100, 1 + i % 12, 1 + i % 28);
    sum += parse_date(text, TimeScale::tdb).tt_since_j2000().high;
  }
  EXPECT_TRUE(std::isfinite(sum));
  const double took_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  EXPECT_LT(took_s, 1.0) << "for a tenth of them; by eraDtdb alone it is 2 s and more";
}

TEST(Time, DoubtfulUtcIsComputedAndSaid) {
  EXPECT_FALSE(utc_doubt(parse_date("2016-12-31T23:59:60", TimeScale::utc)));
  const Instant early = parse_date("1950-01-01T00:00:00", TimeScale::utc);
  ASSERT_TRUE(utc_doubt(early));
  EXPECT_NE(utc_doubt(early)->find("1960"), std::string::npos);
  ASSERT_TRUE(utc_doubt(parse_date("2090-01-01", TimeScale::utc)));
}

TEST(Time, ATableOfLeapSecondsCanBeGiven) {
  const std::vector<LeapSecond> known = leap_seconds();
  ASSERT_EQ(known.front().tai_minus_utc_s, 10.0);
  std::vector<LeapSecond> longer = known;
  longer.push_back({2035, 7, known.back().tai_minus_utc_s + 1.0});
  set_leap_seconds(longer);
  EXPECT_EQ(apart_s(parse_date("2035-07-01", TimeScale::utc), parse_date("2035-06-30T23:59:60", TimeScale::utc)), 1.0);
  set_leap_seconds(known);
  EXPECT_THROW(parse_date("2035-06-30T23:59:60", TimeScale::utc), InputError);
  longer.back().year = 2016;
  EXPECT_THROW(set_leap_seconds(longer), InputError);
  EXPECT_THROW(set_leap_seconds({}), InputError);
  longer.back() = {2035, 7, -12.0};
  EXPECT_THROW(set_leap_seconds(longer), InputError);
  longer.back().tai_minus_utc_s = known.back().tai_minus_utc_s + 0.5;
  EXPECT_THROW(set_leap_seconds(longer), InputError);
}

TEST(Time, BadDatesAreRefused) {
  for (const char* text : {"",
                           "2000",
                           "2000-13-01",
                           "2000-02-30",
                           "1999-366",
                           "2000-000",
                           "2000-1-1",
                           "2000-01-01T",
                           "2000-01-01T24:00:00",
                           "2000-01-01T00:60:00",
                           "2000-01-01T00:00:60",
                           "2000-01-01T00:00:1",
                           "2000-01-01T00:00:00 TDB",
                           "JD",
                           "JD x",
                           "JD 1e6",
                           "JD 2451545 0.5 1",
                           "nan",
                           "JD nan",
                           "12000-01-01",
                           "2000-01-01T12:00:00.5x",
                           "JD 99999999999",
                           "JD 981758",
                           "MJD -678941.5",
                           "MJD 2973484"}) {
    EXPECT_THROW(parse_date(text, TimeScale::tdb), InputError) << text;
  }
  EXPECT_EQ(format_date(parse_date("MJD -678941", TimeScale::tdb), TimeScale::tdb, 0), "0000-01-01T00:00:00");
  EXPECT_EQ(format_date(parse_date("MJD 2973483.5", TimeScale::tdb), TimeScale::tdb, 0), "9999-12-31T12:00:00");
  EXPECT_THROW(parse_date("2016-12-30T23:59:60", TimeScale::utc), InputError);
  EXPECT_THROW(parse_date_with_scale("2000-01-01T12:00:00"), InputError);
  EXPECT_THROW(parse_date_with_scale("2000-01-01T12:00:00 XYZ"), InputError);
  EXPECT_THROW(time_scale("UT1"), InputError);
  EXPECT_THROW(format_date(Instant::from_tt_j2000({1e12, 0.0}), TimeScale::tt, 3), InputError);
  EXPECT_THROW(format_date(Instant::from_tt_j2000({NAN, 0.0}), TimeScale::tt, 3), InputError);
}

}  // namespace
}  // namespace polhode
