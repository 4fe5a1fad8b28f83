// Time grids, blocks of rows and the writers, on motions whose answer is known without the library's own solutions.
#include <fitsio.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/ephemeris/row_spacing.hpp"
#include "polhode/read/attitude_history_file.hpp"
#include "polhode/read/body.hpp"
#include "polhode/write/aem.hpp"
#include "polhode/write/date_text.hpp"
#include "polhode/write/fits.hpp"
#include "polhode/write/output_file.hpp"
#include "polhode/write/text_table.hpp"

namespace polhode {
namespace {

namespace fs = std::filesystem;

Instant tdb(const char* date) { return parse_date(date, TimeScale::tdb); }
Instant utc(const char* date) { return parse_date(date, TimeScale::utc); }

/// A folder of its own that goes with the test.
class Folder {
 public:
  Folder() {
    std::string pattern = (fs::temp_directory_path() / "polhode-test-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { fs::remove_all(path_); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::ptrdiff_t files() const { return std::distance(fs::directory_iterator(path_), fs::directory_iterator()); }

 private:
  fs::path path_;
};

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

constexpr double spin_rad_s = 0.01;
const Vector3 kSpinnerMoments(1.0, 2.0, 3.0);

/// A body that turns about its third principal axis, which stays along z of the state's frame; the angle is 0 at epoch.
Body spinner(Instant epoch) {
  Body body;
  body.name = "spinner";
  body.source = "a test";
  body.inertia = Inertia{kSpinnerMoments, Matrix3::Identity(), true};
  body.state = SpinState{epoch, TimeScale::tdb, Frame::icrf, Quaternion::Identity(), Vector3(0.0, 0.0, spin_rad_s)};
  return body;
}

void spin(std::span<const double> high, std::span<const double> low, double* q, double* m) {
  for (std::size_t i = 0; i < high.size(); ++i) {
    const double half = 0.5 * spin_rad_s * (high[i] + low[i]);
    const std::array attitude{std::cos(half), 0.0, 0.0, std::sin(half)};
    const std::array momentum{0.0, 0.0, 3.0 * spin_rad_s};
    std::copy(attitude.begin(), attitude.end(), q + 4 * i);
    std::copy(momentum.begin(), momentum.end(), m + 3 * i);
  }
}

Ephemeris spinning(TimeGrid times) {
  const Body body = spinner(tdb("2000-01-01T12:00:00"));
  EphemerisDescription description;
  description.object = body.name;
  description.source = body.source;
  description.method = "test";
  description.promised_error_rad = 1e-15;
  return {std::move(description), body, Frame::icrf, std::move(times), spin};
}

TEST(TimeGrid, ADayHasAsManyStepsInEveryScale) {
  for (const char* date : {"2000-04-01", "2000-07-01", "2000-10-01"}) {
    const Instant start = parse_date(date, TimeScale::tt);
    for (const TimeScale scale : {TimeScale::tt, TimeScale::utc, TimeScale::tdb, TimeScale::et}) {
      const auto rows = [&](double span_s, double step_s) {
        return TimeGrid::with_step(start, start + Seconds{span_s, 0.0}, {step_s, 0.0}, scale).size();
      };
      EXPECT_EQ(rows(86400.0, 10.0), 8641U) << date;
      EXPECT_EQ(rows(86400.0 * 60, 1.0), 86400U * 60 + 1) << date;
      EXPECT_EQ(rows(86399.9, 10.0), 8640U) << date;
    }
  }
}

TEST(TimeGrid, StepIncludesStopWhereItIsHit) {
  const TimeGrid grid =
      TimeGrid::with_step(tdb("2000-01-01T06:00:00"), tdb("2000-01-01T07:00:00"), {0.1, 0.0}, TimeScale::tdb);
  EXPECT_EQ(grid.size(), 36001U);
  EXPECT_EQ(grid.reference_mjd(), 51544.0);
  EXPECT_EQ(grid.decimals(), 3);
  // 0.1 is not a double; moved to three decimals the last time is whole all the same.
  const Seconds last = grid.time(36000, {TimeResolution::Kind::decimals, 3});
  EXPECT_EQ(last.high, 25200.0);
  EXPECT_EQ(last.low, 0.0);
  const Seconds second = grid.time(1, {TimeResolution::Kind::decimals, 3});
  EXPECT_EQ(second.high, 21600.1);
  EXPECT_EQ(second.low, -std::fma(21600.1, 10.0, -216001.0) / 10.0);  // the rest of the decimal number
}

TEST(TimeGrid, RefusesWhatMakesNoTable) {
  const Instant a = tdb("2000-01-01");
  const Instant b = tdb("2000-01-02");
  EXPECT_THROW(TimeGrid::with_step(a, b, {0.0, 0.0}, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::with_step(a, b, {-60.0, 0.0}, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::with_step(a, b, {std::nan(""), 0.0}, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::with_step(b, a, {60.0, 0.0}, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::with_count(a, b, 0, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::with_count(a, a, 2, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::of_list({}, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::of_list(std::array{b, a}, TimeScale::tdb), InputError);
  EXPECT_THROW(TimeGrid::of_list(std::array{a, a}, TimeScale::tdb), InputError);
}

TEST(TimeGrid, CountHitsBothEnds) {
  const TimeGrid grid = TimeGrid::with_count(utc("2016-12-31"), utc("2017-01-02"), 8, TimeScale::utc);
  EXPECT_EQ(grid.size(), 8U);
  EXPECT_EQ(grid.time(0, {}).high, 0.0);
  EXPECT_EQ(grid.time(7, {}).high, 172801.0);  // a leap second stands between
}

TEST(TimeGrid, ElapsedAgreesWithTheConversionOfEachTime) {
  for (const TimeScale scale : {TimeScale::tdb, TimeScale::tt, TimeScale::utc, TimeScale::tai}) {
    for (const double step_s : {0.37, 977.0, 40000.0, 1e6}) {
      const Instant start = parse_date("2016-12-30T23:00:00", scale);
      const Instant epoch = tdb("1992-11-09T17:49:47");
      const TimeGrid grid = TimeGrid::with_step(start, start + Seconds{2500.0 * step_s, 0.0}, {step_s, 0.0}, scale);
      std::vector<Seconds> times;
      for (std::size_t i = 0; i < 2500; ++i) times.push_back(grid.time(i, {}));
      std::vector<double> high(times.size());
      std::vector<double> low(times.size());
      TimeGrid::ScaleNodes nodes;
      const std::size_t half = times.size() / 2;  // in two calls, as blocks come
      const std::span all(times);
      grid.elapsed_tt(all.first(half), epoch, std::span(high).first(half), std::span(low).first(half), nodes);
      grid.elapsed_tt(all.subspan(half), epoch, std::span(high).subspan(half), std::span(low).subspan(half), nodes);
      double worst = 0.0;
      for (std::size_t i = 0; i < times.size(); ++i) {
        const Seconds expected = grid.instant(times[i]) - epoch;
        const double error = std::abs((high[i] - expected.high) + (low[i] - expected.low));
        worst = error <= worst ? worst : error;  // keeps a NaN
      }
      EXPECT_LE(worst, 1e-13) << name(scale) << ", step " << step_s << " s";
    }
  }
}

TEST(DateText, AgreesWithTheCalendar) {
  std::mt19937_64 random(20250101);
  struct Span {
    TimeScale scale;
    const char* start;
    double step_s;
  };
  for (const Span& span :
       {Span{TimeScale::utc, "2016-12-31T23:59:50", 0.25}, Span{TimeScale::utc, "1971-12-31T23:59:50", 0.5},
        Span{TimeScale::utc, "1968-01-31T23:59:55", 0.5}, Span{TimeScale::tdb, "1999-12-31T23:59:00", 1.5},
        Span{TimeScale::tai, "1900-02-27T00:00:00", 7777.7}}) {
    const Instant start = parse_date(span.start, span.scale);
    const TimeGrid grid =
        TimeGrid::with_step(start, start + Seconds{100.0 * span.step_s, 0.0}, {span.step_s, 0.0}, span.scale);
    constexpr int decimals = 6;
    const TimeResolution resolution{TimeResolution::Kind::decimals, decimals};
    DateText dates(grid, decimals);
    for (int i = 0; i < 200; ++i) {
      const Seconds time = grid.time(random() % grid.size(), resolution);
      std::string text;
      dates.append(text, time);
      EXPECT_EQ(text, format_date(grid.instant(time), span.scale, decimals));
    }
  }
}

TEST(Ephemeris, GivesTheNamedAxes) {
  Body body = spinner(tdb("2000-01-01T12:00:00"));
  // The file's axes are not the principal ones: named x is principal y, named y is principal z.
  body.inertia->named_from_principal << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  const Quaternion q_principal_from_named(body.inertia->named_from_principal.transpose().eval());
  const TimeGrid grid = TimeGrid::with_count(tdb("2000-01-01"), tdb("2000-01-03"), 50, TimeScale::tdb);
  const Ephemeris ephemeris({}, body, Frame::icrf, grid, spin);
  AttitudeBlock block;
  ephemeris.fill(0, grid.size(), {}, block);
  for (std::size_t i = 0; i < block.rows; ++i) {
    const Eigen::Map<const Eigen::Vector4d> row(&block.q_frame_from_named[4 * i]);
    const double angle = spin_rad_s * (block.elapsed_high[i] + block.elapsed_low[i]);
    const Quaternion q_icrf_from_principal(Eigen::AngleAxisd(angle, Vector3::UnitZ()));
    const Quaternion expected = q_icrf_from_principal * q_principal_from_named;
    EXPECT_LE(rotation_angle_rad(from_scalar_first(row), expected), 4e-16 + 1e-15 * std::abs(angle));
    EXPECT_NEAR(block.omega_named_rad_s[3 * i + 1], spin_rad_s, 1e-17);
    EXPECT_NEAR(block.momentum_named[3 * i + 1], 3.0 * spin_rad_s, 1e-16);
  }
}

TEST(Ephemeris, RefusesANumberThatIsNotFinite) {
  const Folder folder;
  const TimeGrid grid = TimeGrid::with_count(tdb("2000-01-01"), tdb("2000-01-03"), 50000, TimeScale::tdb);
  const auto broken = [](std::span<const double> high, std::span<const double> low, double* q, double* m) {
    spin(high, low, q, m);
    if (high.front() > 0.0) q[2] = std::nan("");
  };
  const Ephemeris ephemeris({}, spinner(tdb("2000-01-02")), Frame::icrf, grid, broken);
  EXPECT_THROW(write_fits(folder.file("a.fits"), ephemeris), ComputationError);
  EXPECT_THROW(write_text_table(folder.file("a.csv"), ephemeris), ComputationError);
  EXPECT_THROW(write_aem(folder.file("a.aem"), {&ephemeris, 1}), ComputationError);
  EXPECT_EQ(folder.files(), 0);
}

TEST(Fits, RowsAndChecksumsAreReadBack) {
  const Folder folder;
  const TimeGrid grid = TimeGrid::with_count(tdb("2000-01-01"), tdb("2000-01-03"), 20001, TimeScale::tdb);
  const Ephemeris ephemeris = spinning(grid);
  FitsOptions options;
  options.momentum = true;
  options.time_low = true;
  const std::string path = folder.file("a b [1].fits");
  write_fits(path, ephemeris, options);
  EXPECT_EQ(folder.files(), 1);

  fitsfile* file = nullptr;
  int status = 0;
  fits_open_diskfile(&file, path.c_str(), READONLY, &status);
  for (int hdu = 1; hdu <= 2; ++hdu) {
    int data_good = 0;
    int header_good = 0;
    fits_movabs_hdu(file, hdu, nullptr, &status);
    fits_verify_chksum(file, &data_good, &header_good, &status);
    EXPECT_EQ(data_good, 1);
    EXPECT_EQ(header_good, 1);
  }
  AttitudeBlock block;
  ephemeris.fill(0, grid.size(), {TimeResolution::Kind::two_doubles}, block);
  const auto column = [&](const char* name, long long width) {
    int number = 0;
    std::vector<double> values(grid.size() * static_cast<std::size_t>(width));
    fits_get_colnum(file, CASESEN, const_cast<char*>(name), &number, &status);
    fits_read_col(file, TDOUBLE, number, 1, 1, static_cast<LONGLONG>(values.size()), nullptr, values.data(), nullptr,
                  &status);
    return values;
  };
  const std::vector<double> time = column("TIME", 1);
  const std::vector<double> time_low = column("TIME_LO", 1);
  const std::vector<double> qparam = column("QPARAM", 4);
  const std::vector<double> omega = column("OMEGA", 3);
  const std::vector<double> momentum = column("L", 3);
  ASSERT_EQ(status, 0);
  EXPECT_EQ(omega, std::vector(block.omega_named_rad_s.begin(), block.omega_named_rad_s.begin() + 3 * 20001));
  EXPECT_EQ(momentum, std::vector(block.momentum_named.begin(), block.momentum_named.begin() + 3 * 20001));
  for (std::size_t i = 0; i < grid.size(); ++i) {
    ASSERT_EQ(time[i], block.time[i].high);
    ASSERT_EQ(time_low[i], block.time[i].low);
    for (std::size_t k = 0; k < 4; ++k) ASSERT_EQ(qparam[4 * i + k], block.q_frame_from_named[4 * i + (k + 1) % 4]);
  }
  fits_close_file(file, &status);
}

// After 90 degrees about inertial z the body's x axis lies along inertial y, and every format has (0, 0, 0.7071,
// 0.7071).
TEST(Text, QuarterTurnInEveryFormat) {
  const Folder folder;
  const Instant quarter = tdb("2000-01-01T12:00:00") + Seconds{0.5 * std::numbers::pi / spin_rad_s, 0.0};
  const Ephemeris ephemeris = spinning(TimeGrid::of_list(std::array{quarter}, TimeScale::tt));
  const auto row_has = [](const std::string& text, const std::string& numbers) {
    EXPECT_NE(text.find(numbers), std::string::npos) << text;
  };
  write_text_table(folder.file("a.csv"), ephemeris);
  row_has(content(folder.file("a.csv")), "2000-01-01T12:02:37.079731987,0,0,0.70710678118");
  AemOptions options;
  for (const auto version : {AdmVersion::v1, AdmVersion::v2}) {
    options.version = version;
    options.type = AemType::quaternion;
    write_aem(folder.file("a.aem"), {&ephemeris, 1}, options);
    row_has(content(folder.file("a.aem")), "\n2000-01-01T12:02:37.079731987 0 0 0.70710678118");
  }
  options.type = AemType::euler_angle_angular_velocity;
  write_aem(folder.file("a.aem"), {&ephemeris, 1}, options);
  row_has(content(folder.file("a.aem")), "\nEULER_ROT_SEQ = ZXZ\nANGVEL_FRAME = SC_BODY_1\n");
}

TEST(Text, RatesWithoutAValueAreRefused) {
  const Folder folder;
  const Ephemeris ephemeris = spinning(TimeGrid::with_count(tdb("2000-01-01"), tdb("2000-01-02"), 5, TimeScale::tdb));
  AemOptions options;
  options.type = AemType::euler_angle_derivative;  // the middle angle is 0 all the time
  EXPECT_THROW(write_aem(folder.file("a.aem"), {&ephemeris, 1}, options), ComputationError);
  options.version = AdmVersion::v1;
  EXPECT_THROW(write_aem(folder.file("a.aem"), {&ephemeris, 1}, options), InputError);
  EXPECT_EQ(folder.files(), 0);
}

TEST(Aem, SegmentsShareAnInstantAtMost) {
  const Folder folder;
  const auto span = [](const char* first, const char* last) {
    return spinning(TimeGrid::with_count(tdb(first), tdb(last), 11, TimeScale::tdb));
  };
  const std::string file = folder.file("a.aem");
  const std::vector<Ephemeris> apart{span("2001-01-01T00:00:00", "2001-01-02T00:00:00"),
                                     span("2000-12-31T00:00:00", "2001-01-01T00:00:00")};
  EXPECT_NO_THROW(write_aem(file, apart));
  fs::remove(file);
  const std::vector<Ephemeris> together{apart[0], apart[1], span("2001-01-01T12:00:00", "2001-01-01T13:00:00")};
  try {
    write_aem(file, together);
    ADD_FAILURE() << "written";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "segments 1 and 3 both hold from 2001-01-01T12:00:00.000 to 2001-01-01T13:00:00.000 TDB; segments of an "
              "AEM may share an instant at most: let each span begin where another ends, or later");
  }
  EXPECT_EQ(folder.files(), 0);
}

TEST(Text, TheDesignationOfTheBodyIsWritten) {
  const Folder folder;
  Ephemeris ephemeris = spinning(TimeGrid::with_count(tdb("2000-01-01"), tdb("2000-01-03"), 3, TimeScale::tdb));
  for (const std::string id : {"", "1998-067A"}) {
    ephemeris.description().object_id = id;
    TextTableOptions options;
    options.kind = TextTableKind::ecsv;
    write_text_table(folder.file("a.ecsv"), ephemeris, options);
    write_fits(folder.file("a.fits"), ephemeris, {});
    for (const char* name : {"a.ecsv", "a.fits"}) {
      const std::string bytes = content(folder.file(name));
      EXPECT_EQ(parse_attitude_history(bytes, name).value().object_id, id) << name;
      EXPECT_EQ(bytes.find(id.empty() ? "object_id" : "1998-067A") != std::string::npos, !id.empty()) << name;
    }
    fs::remove(folder.file("a.ecsv"));
    fs::remove(folder.file("a.fits"));
  }
}

// A constant rate is a great circle: a row each radian will do. One that a polynomial has to follow needs more.
TEST(RowSpacing, TakesNoMoreRowsThanNeeded) {
  constexpr double span_s = 1000.0;
  const double turn_rad = spin_rad_s * span_s;
  EXPECT_EQ(rows_for_tolerance(spin, kSpinnerMoments, 0.0, span_s, 1e-9, 0.0, RowInterpolation::great_circle),
            std::ceil(1.1 * turn_rad * (1 + 1e-9)) + 1);
  const std::size_t coarse =
      rows_for_tolerance(spin, kSpinnerMoments, 0.0, span_s, 1e-4, 0.0, RowInterpolation::lagrange_degree_7);
  const std::size_t fine =
      rows_for_tolerance(spin, kSpinnerMoments, 0.0, span_s, 1e-8, 0.0, RowInterpolation::lagrange_degree_7);
  EXPECT_GT(fine, 2 * coarse);
  EXPECT_LT(fine, 6 * coarse);  // order 8: 1e4 in accuracy is a factor 3.2
  EXPECT_EQ(rows_for_tolerance(spin, kSpinnerMoments, 5.0, 5.0, 1e-9, 0.0, RowInterpolation::great_circle), 1U);
  EXPECT_THROW(rows_for_tolerance(spin, kSpinnerMoments, 0.0, span_s, 0.0, 0.0, RowInterpolation::great_circle),
               InputError);
  EXPECT_THROW(rows_for_tolerance(spin, kSpinnerMoments, span_s, 0.0, 1e-9, 0.0, RowInterpolation::great_circle),
               InputError);
}

/// However fast the body, and however coarse the tolerance: at half a turn and more a reader takes the wrong way.
TEST(RowSpacing, IsByTheBodysOwnRate) {
  for (const double rate_rad_s : {0.1, 3.1e3, 2e3 * std::numbers::pi, 1e9}) {
    const PrincipalMotion fast = [rate_rad_s](std::span<const double> high, std::span<const double> low, double* q,
                                              double* m) {
      for (std::size_t i = 0; i < high.size(); ++i) {
        const double half = 0.5 * rate_rad_s * (high[i] + low[i]);
        Eigen::Map<Eigen::Vector4d>(q + 4 * i) << std::cos(half), 0.0, 0.0, std::sin(half);
        Eigen::Map<Vector3>(m + 3 * i) = 3.0 * rate_rad_s * Vector3::UnitZ();
      }
    };
    const double turned_rad = 777.7, span_s = turned_rad / rate_rad_s;
    for (const RowInterpolation interpolation : {RowInterpolation::great_circle, RowInterpolation::lagrange_degree_7}) {
      for (const double tolerance_rad : {0.5, 1.0, 3.0}) {
        EXPECT_GE(rows_for_tolerance(fast, kSpinnerMoments, 0.0, span_s, tolerance_rad, 0.0, interpolation), turned_rad)
            << rate_rad_s << " " << tolerance_rad;
      }
    }
    EXPECT_THROW(rows_for_tolerance(fast, kSpinnerMoments, 0.0, 1e40, 1.0, 0.0, RowInterpolation::great_circle),
                 InputError);
  }
}

TEST(OutputFile, AppearsWholeOrNotAtAll) {
  const Folder folder;
  const std::string path = folder.file("out.csv");
  const Ephemeris ephemeris =
      spinning(TimeGrid::with_count(tdb("2000-01-01"), tdb("2000-01-02"), 100000, TimeScale::tdb));
  const auto stop_early = [&](std::size_t rows) {
    EXPECT_FALSE(fs::exists(path));
    if (rows > 20000) throw std::runtime_error("stop");
  };
  EXPECT_THROW(write_text_table(path, ephemeris, {}, stop_early), std::runtime_error);
  EXPECT_THROW(write_fits(path, ephemeris, {}, stop_early), std::runtime_error);
  EXPECT_EQ(folder.files(), 0);
  write_text_table(path, ephemeris);
  EXPECT_EQ(folder.files(), 1);
  const std::string before = content(path);
  EXPECT_THROW(write_text_table(path, ephemeris, {}, [](std::size_t) { throw std::runtime_error("stop"); }),
               std::runtime_error);
  EXPECT_EQ(content(path), before);  // the file of before stays
}

TEST(OutputFile, RefusesFoldersDevicesAndMissingFolders) {
  const Folder folder;
  EXPECT_THROW(OutputFile(folder.file("")), FileError);
  EXPECT_THROW(OutputFile("/dev/null"), FileError);
  EXPECT_THROW(OutputFile(folder.file("none/out.csv")), FileError);
}

}  // namespace
}  // namespace polhode
