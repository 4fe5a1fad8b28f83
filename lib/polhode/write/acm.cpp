#include "polhode/write/acm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/write/ccsds_lines.hpp"
#include "polhode/write/date_text.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/number_text.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// The rows of an ephemeris as data lines, each a date and what `numbers` appends.
void write_lines(OutputBytes& bytes, const Ephemeris& ephemeris,
                 const std::function<void(std::string& out, const AttitudeBlock& block, std::size_t row)>& numbers,
                 const Progress& progress) {
  const int decimals = ephemeris.times().decimals();
  const auto new_encoder = [&]() -> Encoder {
    return [&numbers, dates = DateText(ephemeris.times(), decimals)](const AttitudeBlock& block,
                                                                     EncodedBlock& out) mutable {
      out.bytes.clear();
      for (std::size_t row = 0; row < block.rows; ++row) {
        dates.append(out.bytes, block.time[row]);
        numbers(out.bytes, block, row);
        out.bytes.push_back('\n');
      }
    };
  };
  std::size_t rows = 0;
  stream_rows(ephemeris, {TimeResolution::Kind::decimals, decimals}, new_encoder, [&](const EncodedBlock& block) {
    bytes.write(block.bytes);
    rows += block.rows;
    if (progress) progress(rows);
  });
}

}  // namespace

void write_acm(const std::string& path, const Ephemeris& ephemeris, const Progress& progress) {
  const EphemerisDescription& description = ephemeris.description();
  const TimeGrid& times = ephemeris.times();
  if (times.scale() == TimeScale::et) {
    throw TimeScaleError("CCSDS knows no time scale ET; take TDB, or UTC, TAI, TT, GPS");
  }
  const auto date = [&](std::size_t row) {
    std::string text;
    DateText(times, times.decimals()).append(text, times.time(row, {TimeResolution::Kind::decimals, times.decimals()}));
    return text;
  };
  const std::string frame_b = description.body_axes.empty() ? "SC_BODY_1" : description.body_axes;
  OutputBytes bytes(path);
  const auto key = [&](std::string_view name, std::string_view value) { bytes.write(kvn_line(name, value)); };
  const auto comment = [&](std::string_view text) { bytes.write(kvn_comment(text)); };
  key("CCSDS_ACM_VERS", "2.0");
  comment("Written by " + creator());
  key("CREATION_DATE", creation_date());
  key("ORIGINATOR", "POLHODE");
  bytes.write("\nMETA_START\n");
  comment("Frame B is the axes that the body's file names. The quaternion takes components from A to B;");
  comment("a body turned by +90 deg about z of A has Q1 Q2 Q3 QC = 0 0 0.7071 0.7071.");
  for (const std::string& text : comments_on(description)) comment(text);
  key("OBJECT_NAME", description.object);
  key("OBJECT_DESIGNATOR", description.object_id.empty() ? description.object : description.object_id);
  key("TIME_SYSTEM", name(times.scale()));
  key("EPOCH_TZERO", date(0));
  key("START_TIME", date(0));
  key("STOP_TIME", date(times.size() - 1));
  bytes.write("META_STOP\n\nATT_START\n");
  key("REF_FRAME_A", ephemeris.frame_name());
  key("REF_FRAME_B", frame_b);
  key("NUMBER_STATES", "7");
  key("ATT_TYPE", "QUATERNION");
  key("RATE_TYPE", "ANGVEL");
  write_lines(
      bytes, ephemeris,
      [](std::string& out, const AttitudeBlock& block, std::size_t row) {
        const double* q = &block.q_frame_from_named[4 * row];
        for (const int k : {1, 2, 3, 0}) append_number(out, ' ', std::clamp(q[k], -1.0, 1.0));
        for (std::size_t k = 0; k < 3; ++k) append_number(out, ' ', kDegrees * block.omega_named_rad_s[3 * row + k]);
      },
      progress);
  bytes.write("ATT_STOP\n");
  if (ephemeris.inertia() && ephemeris.inertia()->absolute) {
    const Matrix3 tensor = inertia_tensor(*ephemeris.inertia());
    bytes.write("\nPHYS_START\n");
    key("INERTIA_REF_FRAME", frame_b);
    for (int k = 0; k < 3; ++k) key(fmt::format("I{0}{0}", "XYZ"[k]), fmt::format("{} [kg*m**2]", tensor(k, k)));
    // 504.0-B-2, annex F6: products are positive integrals.
    for (const auto& [i, k] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
      key(fmt::format("I{}{}", "XYZ"[i], "XYZ"[k]), fmt::format("{} [kg*m**2]", 0.0 - tensor(i, k)));
    }
    bytes.write("PHYS_STOP\n");
  }
  if (ephemeris.has_covariance()) {
    bytes.write("\nCOV_START\n");
    comment("Variances, deg**2, of small turns of the body about its own axes; the message holds no covariances.");
    key("COV_REF_FRAME", frame_b);
    key("COV_TYPE", "ANGLE");
    write_lines(bytes, ephemeris,
                [](std::string& out, const AttitudeBlock& block, std::size_t row) {
                  for (const std::size_t k : {0, 3, 5}) {
                    append_number(out, ' ', kDegrees * kDegrees * block.covariance_rad2[6 * row + k]);
                  }
                },
                {});
    bytes.write("COV_STOP\n");
  }
  bytes.commit();
}

}  // namespace polhode
