#include "write_ephemeris.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/write/aem.hpp"
#include "polhode/write/fits.hpp"
#include "polhode/write/text_table.hpp"

namespace polhode::tools {
namespace {

void write_one_fits(const OutputOptions& options, std::span<const Ephemeris> segments, const Progress& progress) {
  write_fits(options.path, segments.front(), {options.momentum, false}, progress);
}

template <bool ecsv>
void write_table(const OutputOptions& options, std::span<const Ephemeris> segments, const Progress& progress) {
  write_text_table(options.path, segments.front(), {ecsv, options.momentum}, progress);
}

template <bool xml>
void write_message(const OutputOptions& options, std::span<const Ephemeris> segments, const Progress& progress) {
  AemOptions aem;
  aem.xml = xml;
  if (!options.adm.empty()) aem.version = adm_version(options.adm);
  aem.type = aem.version == AdmVersion::v1 ? AemType::quaternion : AemType::quaternion_angular_velocity;
  if (!options.attitude_type.empty()) aem.type = aem_type(options.attitude_type);
  aem.euler_sequence = EulerSequence(options.euler_sequence.empty() ? "ZXZ" : options.euler_sequence);
  const bool has_angles = aem.type == AemType::euler_angle || aem.type == AemType::euler_angle_derivative ||
                          aem.type == AemType::euler_angle_angular_velocity;
  if (!has_angles && !options.euler_sequence.empty()) {
    throw InputError("--euler-sequence is for Euler angles; the rows are quaternions unless --attitude-type says so");
  }
  if (options.promises_interpolation && has_angles) {
    throw InputError("--tolerance is promised for quaternions; take another --attitude-type or --step");
  }
  write_aem(options.path, segments, aem, progress);
}

constexpr std::string_view great_circle = "great circle from row to row";
constexpr std::string_view lagrange = "LAGRANGE of degree 7 of the quaternion, made unit";

const std::vector<EphemerisFormat>& formats() {
  static const std::vector<EphemerisFormat> all{
      {"FITS",
       {".fits", ".fits.gz", ".fit", ".fit.gz"},
       RowInterpolation::great_circle,
       great_circle,
       false,
       true,
       false,
       write_one_fits},
      {"CCSDS AEM",
       {".aem", ".txt"},
       RowInterpolation::lagrange_degree_7,
       lagrange,
       true,
       false,
       true,
       write_message<false>},
      {"CCSDS AEM in XML",
       {".xml"},
       RowInterpolation::lagrange_degree_7,
       lagrange,
       true,
       false,
       true,
       write_message<true>},
      {"CSV", {".csv"}, RowInterpolation::great_circle, great_circle, false, true, false, write_table<false>},
      {"ECSV", {".ecsv"}, RowInterpolation::great_circle, great_circle, false, true, false, write_table<true>},
  };
  return all;
}

// What Ctrl-C and a kill leave behind for the next look: the writers then remove what they have begun.
volatile std::sig_atomic_t caught_signal = 0;

struct Stopped {};

/// Until it goes: SIGINT, SIGTERM and SIGHUP are noted instead of obeyed, once; a file beyond the size limit is an
/// error like any other.
class SignalWatch {
 public:
  SignalWatch() {
    struct sigaction note {};
    note.sa_handler = [](int signal) { caught_signal = signal; };
    note.sa_flags = static_cast<int>(SA_RESETHAND);  // a second one ends the program at once
    for (const int signal : signals_) sigaction(signal, &note, nullptr);
    std::signal(SIGXFSZ, SIG_IGN);
  }
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;
  ~SignalWatch() {
    for (const int signal : signals_) std::signal(signal, SIG_DFL);
  }

 private:
  static constexpr int signals_[] = {SIGINT, SIGTERM, SIGHUP};
};

/// Rate and time left, on a terminal, from one second on.
class ProgressLine {
 public:
  explicit ProgressLine(std::size_t rows) : rows_(rows), shown_(::isatty(STDERR_FILENO) != 0) {}
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() {
    if (printed_) std::fputs("\r\033[K", stderr);
  }

  void operator()(std::size_t done) {
    if (caught_signal != 0) throw Stopped{};
    if (!shown_) return;
    using namespace std::chrono;
    const auto now = steady_clock::now();
    constexpr auto first_after = seconds(1);
    constexpr auto then_every = milliseconds(200);
    if (now - begin_ < first_after || now - last_ < then_every) return;
    last_ = now;
    printed_ = true;
    const double rate = static_cast<double>(done) / std::chrono::duration<double>(now - begin_).count();
    const auto left = static_cast<long long>(static_cast<double>(rows_ - done) / rate);
    const double part = 100.0 * static_cast<double>(done) / static_cast<double>(rows_);
    fmt::print(stderr, "\r\033[Kpolhode: {:5.1f} %, {:.3g} rows/s, {}:{:02}:{:02} left", part, rate, left / 3600,
               left / 60 % 60, left % 60);
    std::fflush(stderr);
  }

 private:
  std::size_t rows_;
  bool shown_;
  bool printed_ = false;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_ = begin_;
};

}  // namespace

const EphemerisFormat& format_of(const std::string& path) {
  for (const EphemerisFormat& format : formats()) {
    for (const std::string_view ending : format.endings) {
      if (path.ends_with(ending)) return format;
    }
  }
  throw InputError(fmt::format("the ending of '{}' names no format; allowed are {}", path, all_endings()));
}

void refuse_meaningless(const OutputOptions& options, const EphemerisFormat& format) {
  if (options.momentum && !format.has_momentum) {
    throw InputError(fmt::format("--momentum is for FITS, CSV and ECSV: a {} holds no angular momentum", format.name));
  }
  if (format.is_message) return;
  for (const auto& [option, value] :
       {std::pair("--adm", &options.adm), std::pair("--attitude-type", &options.attitude_type),
        std::pair("--euler-sequence", &options.euler_sequence)}) {
    if (!value->empty()) {
      throw InputError(
          fmt::format("{} is for CCSDS messages (.aem, .txt, .xml); {} is {}", option, options.path, format.name));
    }
  }
}

std::string all_endings() {
  std::string text;
  for (const EphemerisFormat& format : formats()) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", fmt::join(format.endings, " "), format.name);
  }
  return text;
}

void write_watched(const OutputOptions& options, const EphemerisFormat& format, std::span<const Ephemeris> segments) {
  if (segments.size() > 1 && !format.has_segments) {
    throw InputError(
        fmt::format("there are {} segments, which only an AEM (.aem, .xml) holds; give one --start and one "
                    "--stop, of an attitude history within one of its segments",
                    segments.size()));
  }
  std::size_t rows = 0;
  for (const Ephemeris& segment : segments) rows += segment.times().size();
  {
    const SignalWatch watch;
    try {
      ProgressLine line(rows);
      format.write(options, segments, [&line](std::size_t done) { line(done); });
    } catch (const Stopped&) {
      fmt::print(stderr, "polhode: stopped; {} is not written\n", options.path);
    }
  }
  if (caught_signal != 0) {
    std::raise(caught_signal);  // ends the program as whoever sent it expects
  }
  fmt::print(stderr, "polhode: {}: {} rows\n", options.path, rows);
}

}  // namespace polhode::tools
