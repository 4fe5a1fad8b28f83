#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include "dates.hpp"
#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/time/scale.hpp"
#include "subcommands.hpp"
#include "utc.hpp"
#include "whole_number.hpp"

namespace polhode::tools {
namespace {

/// All of standard input. Throws FileError if it cannot be read: is closed, a directory, broken.
std::string standard_input() {
  constexpr std::size_t at_once = 1U << 16U;
  std::string text;
  while (true) {
    const std::size_t end = text.size();
    text.resize(end + at_once);
    const ssize_t count = ::read(STDIN_FILENO, text.data() + end, at_once);
    text.resize(end + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count == 0) return text;
    if (count < 0 && errno != EINTR) {
      throw FileError(fmt::format("cannot read standard input: {}", std::strerror(errno)));
    }
  }
}

// Each line of standard input through `convert`; its result is a line of output.
template <class Convert>
void filter_lines(const Convert& convert) {
  std::istringstream lines(standard_input());
  std::string line;
  fmt::memory_buffer out;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    try {
      fmt::format_to(std::back_inserter(out), "{}\n", convert(line));
    } catch (const InputError& error) {
      throw InputError({"standard input", number}, error.what());
    }
  }
  write_standard_output({out.data(), out.size()});
}

}  // namespace

void add_convert_time(CLI::App& app) {
  struct Options {
    std::string from, to;
    std::size_t decimals = 9;
    bool as_mjd = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("convert-time", "Dates of standard input, one a line, in another time scale");
  command->footer(
      "Examples:\n  echo 2016-12-31T23:59:60.5 UTC | polhode convert-time --to TDB\n"
      "  echo now | polhode convert-time --to TT\n"
      "  polhode convert-time --from UTC --to TDB --mjd < dates.txt");
  command->add_option("--from", options->from, "scale of dates that name none: TT, TAI, UTC, TDB, GPS, ET");
  command->add_option("--to", options->to, "scale to write")->required();
  add_whole_number(*command, "--decimals", options->decimals, 0, 15, "of the second, 0 to 15")->default_str("9");
  command->add_flag("--mjd", options->as_mjd, "write the whole day of the MJD and the fraction of that day");
  add_leap_seconds(*command);
  command->callback([options] {
    const TimeScale to = in_option("--to", [&] { return time_scale(options->to); });
    std::optional<TimeScale> from;
    if (!options->from.empty()) from = in_option("--from", [&] { return time_scale(options->from); });
    UtcDoubts doubts;
    filter_lines([&](const std::string& line) {
      const auto [instant, written_in] = date_or_now(line, from);
      if (written_in == TimeScale::utc || to == TimeScale::utc) doubts.look_at(instant);
      if (!options->as_mjd) return format_date(instant, to, static_cast<int>(options->decimals));
      const ModifiedJulianDate date = modified_julian_date(instant, to);
      return fmt::format("{:.0f} {:.17g}", date.day, date.fraction);
    });
  });
}

void add_convert_frame(CLI::App& app) {
  struct Options {
    std::string from, to, scale;
    EarthOrientation earth;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "convert-frame",
      "For dates of standard input, one a line, the quaternion (scalar first) from one frame to another");
  command->footer(
      "Examples:\n  echo 2029-04-13T21:46:00 UTC | polhode convert-frame --from ECLIPJ2000 --to ICRF\n"
      "  polhode convert-frame --from ITRF --to GCRF --ut1-utc -0.17 --scale UTC < dates.txt");
  command->add_option("--from", options->from, "ICRF, GCRF, EME2000, ECLIPJ2000, ECLIPIAU2006, TEME, ITRF")->required();
  command->add_option("--to", options->to, "the same; v_to = q v_from q*")->required();
  command->add_option("--scale", options->scale, "scale of dates that name none: TT, TAI, UTC, TDB, GPS, ET");
  command->add_option("--ut1-utc", options->earth.ut1_minus_utc_s, "UT1 - UTC, s")->capture_default_str();
  command->add_option("--pole-x", options->earth.pole_x_arcsec, "polar motion, arcsec")->capture_default_str();
  command->add_option("--pole-y", options->earth.pole_y_arcsec, "polar motion, arcsec")->capture_default_str();
  add_leap_seconds(*command);
  command->callback([options] {
    const Frame from = in_option("--from", [&] { return frame(options->from); });
    const Frame to = in_option("--to", [&] { return frame(options->to); });
    std::optional<TimeScale> scale;
    if (!options->scale.empty()) scale = in_option("--scale", [&] { return time_scale(options->scale); });
    const EarthOrientation& earth = options->earth;
    const bool earth_given = earth.ut1_minus_utc_s != 0.0 || earth.pole_x_arcsec != 0.0 || earth.pole_y_arcsec != 0.0;
    if ((from == Frame::itrf) != (to == Frame::itrf) && !earth_given) {
      say("note: UT1 - UTC and polar motion are taken as zero: ITRF is good to 15 arcsec");
    }
    UtcDoubts doubts;
    filter_lines([&](const std::string& line) {
      const auto [instant, written_in] = date_or_now(line, scale);
      if (written_in == TimeScale::utc) doubts.look_at(instant);
      const Quaternion q = q_icrf_from(to, instant, earth).conjugate() * q_icrf_from(from, instant, earth);
      return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}", q.w(), q.x(), q.y(), q.z());
    });
  });
}

}  // namespace polhode::tools
