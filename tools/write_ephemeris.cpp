#include "write_ephemeris.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "in_file.hpp"
#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/write/aem.hpp"
#include "signals.hpp"

namespace polhode::tools {
namespace {

/// What the library calls the output.
std::string path_of(const OutputOptions& options) { return options.path == "-" ? "/dev/stdout" : options.path; }

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
    if (!shown_ || done == 0) return;
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
    const std::string text = fmt::format("\r\033[Kpolhode: {:5.1f} %, {:.3g} rows/s, {}:{:02}:{:02} left", part, rate,
                                         left / 3600, left / 60 % 60, left % 60);
    std::fputs(text.c_str(), stderr);
  }

 private:
  std::size_t rows_;
  bool shown_;
  bool printed_ = false;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_ = begin_;
};

}  // namespace

const EphemerisFormat& format_of(const OutputOptions& options) {
  const EphemerisFormat* format = ephemeris_format_of(options.format.empty() ? options.path : "." + options.format);
  const auto is_ending = [&](std::string_view ending) { return lower_case("." + options.format) == ending; };
  if (options.format.empty() && format == nullptr) {
    throw OptionError(fmt::format("the ending of '{}' names no format, and there is no --format; allowed are {}",
                                  options.path, endings_of_formats()));
  }
  if (!options.format.empty() &&
      (format == nullptr || std::none_of(format->endings.begin(), format->endings.end(), is_ending))) {
    throw OptionError(fmt::format("--format '{:.60}' is no format; allowed are, without the dot, {}", options.format,
                                  endings_of_formats()));
  }
  return *format;
}

void refuse_meaningless(const OutputOptions& options, const EphemerisFormat& format) {
  if (options.momentum && !format.has_momentum) {
    throw OptionError(fmt::format("--momentum is for {}: {} holds no angular momentum",
                                  endings_of_formats(&EphemerisFormat::has_momentum), format.name));
  }
  if (format.is_message) {
    if (!options.adm.empty()) in_option("--adm", [&] { return adm_version(options.adm); });
    if (!options.attitude_type.empty()) in_option("--attitude-type", [&] { return aem_type(options.attitude_type); });
    if (!options.euler_sequence.empty()) {
      in_option("--euler-sequence", [&] { return EulerSequence(options.euler_sequence); });
    }
    const bool has_angles = upper_case(options.attitude_type).starts_with("EULER");
    if (!has_angles && !options.euler_sequence.empty()) {
      throw OptionError(
          "--euler-sequence is for Euler angles; the rows are quaternions unless --attitude-type says so");
    }
    if (has_angles && options.promises_interpolation) {
      throw OptionError("--tolerance is promised for quaternions; take another --attitude-type or --step");
    }
    return;
  }
  for (const auto& [option, value] :
       {std::pair("--adm", &options.adm), std::pair("--attitude-type", &options.attitude_type),
        std::pair("--euler-sequence", &options.euler_sequence)}) {
    if (!value->empty()) {
      throw OptionError(fmt::format("{} is for {}; {} is {}", option, endings_of_formats(&EphemerisFormat::is_message),
                                    options.path, format.name));
    }
  }
}

void refuse_overwriting(const OutputOptions& options, std::span<const std::string> inputs) {
  namespace fs = std::filesystem;
  std::error_code absent;
  if (options.path == "-" || !fs::is_regular_file(options.path, absent)) return;
  for (const std::string& input : inputs) {
    if (fs::equivalent(options.path, input, absent) && !absent) {
      throw OptionError(
          fmt::format("--output {} is the file {} that is read; another name is wanted", options.path, input));
    }
  }
}

void write_watched(const OutputOptions& options, const EphemerisFormat& format, std::span<const Ephemeris> segments) {
  if (segments.size() > 1 && !format.has_segments) {
    throw InputError(
        fmt::format("there are {} segments, which only these hold: {}; give one --start and one --stop, of an "
                    "attitude history within one of its segments",
                    segments.size(), endings_of_formats(&EphemerisFormat::has_segments)));
  }
  std::size_t rows = 0;
  for (const Ephemeris& segment : segments) rows += segment.times().size();
  write_watched(options.path, rows, [&](const Progress& progress) {
    try {
      write_ephemeris(path_of(options), format, segments, options, progress);
    } catch (const TimeScaleError& error) {
      throw InputError({"--scale", 0}, error.what());
    }
  });
}

void write_watched(const std::string& path, std::size_t rows, const std::function<void(const Progress&)>& write,
                   const char* rows_are) {
  {
    const bool terminal = ::isatty(STDERR_FILENO) != 0;
    const StoppedNote note(fmt::format("{}polhode: stopped; {} is not written\n", terminal ? "\r\033[K" : "", path));
    ProgressLine line(rows);
    write([&line](std::size_t done) { line(done); });
  }
  say(fmt::format("{}: {} {}", path == "-" ? "standard output" : path, rows, rows_are));
}

}  // namespace polhode::tools
