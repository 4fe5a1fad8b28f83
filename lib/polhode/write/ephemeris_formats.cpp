#include "polhode/write/ephemeris_formats.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/write/acm.hpp"
#include "polhode/write/aem.hpp"
#include "polhode/write/fits.hpp"
#include "polhode/write/text_table.hpp"

namespace polhode {
namespace {

template <bool packed>
void write_binary_table(const std::string& path, std::span<const Ephemeris> segments, const WriteOptions& options,
                        const Progress& progress) {
  write_fits(path, segments.front(), {options.momentum, false, packed}, progress);
}

template <TextTableKind kind>
void write_text(const std::string& path, std::span<const Ephemeris> segments, const WriteOptions& options,
                const Progress& progress) {
  write_text_table(path, segments.front(), {kind, options.momentum}, progress);
}

template <bool xml>
void write_message(const std::string& path, std::span<const Ephemeris> segments, const WriteOptions& options,
                   const Progress& progress) {
  AemOptions aem;
  aem.xml = xml;
  if (!options.adm.empty()) aem.version = adm_version(options.adm);
  aem.type = aem.version == AdmVersion::v1 ? AemType::quaternion : AemType::quaternion_angular_velocity;
  if (!options.attitude_type.empty()) aem.type = aem_type(options.attitude_type);
  aem.euler_sequence = EulerSequence(options.euler_sequence.empty() ? "ZXZ" : options.euler_sequence);
  const bool has_angles = aem.type == AemType::euler_angle || aem.type == AemType::euler_angle_derivative ||
                          aem.type == AemType::euler_angle_angular_velocity;
  if (!has_angles && !options.euler_sequence.empty()) {
    throw InputError(
        "an Euler sequence is for Euler angles; the rows are quaternions unless the attitude type says so");
  }
  if (options.promises_interpolation && has_angles) {
    throw InputError("a tolerance is promised for quaternions; take another attitude type, or say where rows are");
  }
  write_aem(path, segments, aem, progress);
}

void write_comprehensive_message(const std::string& path, std::span<const Ephemeris> segments, const WriteOptions&,
                                 const Progress& progress) {
  write_acm(path, segments.front(), progress);
}

constexpr std::string_view great_circle = "great circle from row to row";
constexpr std::string_view lagrange = "LAGRANGE of degree 7 of the quaternion, made unit";

}  // namespace

const std::vector<EphemerisFormat>& ephemeris_formats() {
  constexpr RowInterpolation circle = RowInterpolation::great_circle, degree_7 = RowInterpolation::lagrange_degree_7;
  using Kind = TextTableKind;
  static const std::vector<EphemerisFormat> all{
      {"FITS", {".fits", ".fit"}, circle, great_circle, false, true, true, false, write_binary_table<false>},
      {"FITS packed by gzip",
       {".fits.gz", ".fit.gz"},
       circle,
       great_circle,
       false,
       true,
       true,
       false,
       write_binary_table<true>},
      {"CCSDS AEM", {".aem", ".txt"}, degree_7, lagrange, true, false, false, true, write_message<false>},
      {"CCSDS AEM in XML", {".xml"}, degree_7, lagrange, true, false, false, true, write_message<true>},
      {"CCSDS ACM", {".acm"}, degree_7, lagrange, false, false, true, false, write_comprehensive_message},
      {"CSV", {".csv"}, circle, great_circle, false, true, true, false, write_text<Kind::csv>},
      {"ECSV", {".ecsv"}, circle, great_circle, false, true, true, false, write_text<Kind::ecsv>},
      {"JSON lines", {".jsonl"}, circle, great_circle, false, true, true, false, write_text<Kind::json_lines>},
  };
  return all;
}

const EphemerisFormat* ephemeris_format_of(std::string_view path) {
  const std::string lower = lower_case(path);
  for (const EphemerisFormat& format : ephemeris_formats()) {
    for (const std::string_view ending : format.endings) {
      if (lower.ends_with(ending)) return &format;
    }
  }
  return nullptr;
}

std::string endings_of_formats(bool EphemerisFormat::*property) {
  std::string text;
  for (const EphemerisFormat& format : ephemeris_formats()) {
    if (property != nullptr && !(format.*property)) continue;
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", fmt::join(format.endings, " "), format.name);
  }
  return text;
}

void write_ephemeris(const std::string& path, const EphemerisFormat& format, std::span<const Ephemeris> segments,
                     const WriteOptions& options, const Progress& progress) {
  if (options.momentum && !format.has_momentum) {
    throw InputError(fmt::format("the momentum is for {}: {} holds none",
                                 endings_of_formats(&EphemerisFormat::has_momentum), format.name));
  }
  if (!format.is_message && !(options.adm + options.attitude_type + options.euler_sequence).empty()) {
    throw InputError(fmt::format("version, attitude type and Euler sequence are for {}; {} is {}",
                                 endings_of_formats(&EphemerisFormat::is_message), path, format.name));
  }
  if (segments.size() > 1 && !format.has_segments) {
    throw InputError(fmt::format("there are {} segments, which only these hold: {}", segments.size(),
                                 endings_of_formats(&EphemerisFormat::has_segments)));
  }
  const auto uncertain = [](const Ephemeris& ephemeris) { return ephemeris.has_covariance(); };
  if (!format.has_covariance && std::any_of(segments.begin(), segments.end(), uncertain)) {
    throw InputError(fmt::format("the covariance is for {}: {} holds none",
                                 endings_of_formats(&EphemerisFormat::has_covariance), format.name));
  }
  if (segments.empty()) throw InputError("there is no ephemeris to write");
  if (options.momentum && !segments.front().inertia()) throw InputError("the momentum needs an inertia");
  format.write(path, segments, options, progress);
}

}  // namespace polhode
