#include "polhode/write/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/write/date_text.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/number_text.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {
namespace {

struct Column {
  std::string name;
  std::string unit;
};

/// A text as a cell of CSV: in quotes, and quotes doubled, where it holds what ends a cell.
std::string csv_cell(std::string_view text) {
  const std::string plain = plain_text(text);
  if (plain.find_first_of(",\"#") == std::string::npos) return plain;
  std::string out = "\"";
  for (const char c : plain) out.append(c == '"' ? 2 : 1, c);
  return out + "\"";
}

/// The YAML header of ECSV 1.0, with the date column as an astropy Time.
std::string ecsv_header(const Ephemeris& ephemeris, const std::vector<Column>& columns, const std::string& scale,
                        int decimals) {
  const EphemerisDescription& description = ephemeris.description();
  std::string out = "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n";
  for (const Column& column : columns) {
    out +=
        fmt::format("# - {{name: {}, datatype: {}{}}}\n", column.name, &column == columns.data() ? "string" : "float64",
                    column.unit.empty() ? "" : ", unit: " + column.unit);
  }
  out += "# meta: !!omap\n";
  const auto meta = [&](std::string_view key, const std::string& value) {
    if (!value.empty()) out += fmt::format("# - {{{}: {}}}\n", key, value);
  };
  meta("object", double_quoted(description.object));
  if (!description.object_id.empty()) meta("object_id", double_quoted(description.object_id));
  meta("creator", double_quoted(creator()));
  meta("created_utc", double_quoted(creation_date()));
  meta("frame_a", double_quoted(ephemeris.frame_name()));
  meta("frame_b",
       double_quoted(description.body_axes.empty() ? "the axes that the body's file names" : description.body_axes));
  meta("quaternion", double_quoted("scalar last, takes components from frame a to frame b, passive"));
  if (ephemeris.has_covariance()) {
    meta("covariance",
         double_quoted("cov: of a small turn of the body about the axes of frame b; sigma: the root of its "
                       "largest eigenvalue"));
  }
  meta("method", double_quoted(description.method));
  if (description.promised_error_rad) meta("promised_error_rad", fmt::format("{}", *description.promised_error_rad));
  if (!description.error_meaning.empty()) meta("error_meaning", double_quoted(description.error_meaning));
  if (description.torque_evaluations) meta("torque_evaluations", fmt::format("{}", *description.torque_evaluations));
  for (std::size_t i = 0; i < description.cautions.size(); ++i) {
    meta(fmt::format("caution_{}", i + 1), double_quoted(description.cautions[i]));
  }
  if (description.tolerance_rad) {
    meta("interpolation", double_quoted(description.interpolation));
    meta("interpolation_error_rad", fmt::format("{}", *description.tolerance_rad));
  }
  meta("source", double_quoted(description.source));
  const std::string& time = columns.front().name;
  out += fmt::format(
      "# - __serialized_columns__:\n#     {0}:\n#       __class__: astropy.time.core.Time\n#       format: isot\n"
      "#       precision: {1}\n#       scale: {2}\n#       value: !astropy.table.SerializedColumn {{name: {0}}}\n"
      "# schema: astropy-2.0\n",
      time, std::min(decimals, 9), scale);
  return out;
}

}  // namespace

void write_text_table(const std::string& path, const Ephemeris& ephemeris, const TextTableOptions& options,
                      const Progress& progress) {
  const TimeGrid& times = ephemeris.times();
  const std::string scale = lower_case(name(times.scale()));
  if (options.kind == TextTableKind::ecsv && (times.scale() == TimeScale::et || times.scale() == TimeScale::gps)) {
    throw TimeScaleError(fmt::format("astropy knows no time scale {}; take TDB, UTC, TAI or TT", name(times.scale())));
  }
  std::vector<Column> columns{{"date_" + scale, ""}};
  for (const char* component : {"x", "y", "z", "scalar"}) columns.push_back({fmt::format("q_{}", component), ""});
  for (const char* axis : {"x", "y", "z"}) columns.push_back({fmt::format("omega_body_{}_rad_s", axis), "rad / s"});
  if (options.momentum) {
    if (!ephemeris.inertia()) throw InputError("the angular momentum needs an inertia");
    const bool absolute = ephemeris.inertia()->absolute;
    for (const char* axis : {"x", "y", "z"}) {
      columns.push_back({fmt::format("momentum_body_{}{}", axis, absolute ? "_N_m_s" : ""), absolute ? "N m s" : ""});
    }
  }
  if (ephemeris.has_covariance()) {
    columns.push_back({"sigma_rad", "rad"});
    for (const char* element : {"xx", "xy", "xz", "yy", "yz", "zz"}) {
      columns.push_back({fmt::format("cov_{}_rad2", element), "rad2"});
    }
  }
  const int decimals = times.decimals();
  const bool json = options.kind == TextTableKind::json_lines;
  OutputBytes bytes(path);
  if (!json) {
    std::string header =
        options.kind == TextTableKind::ecsv ? ecsv_header(ephemeris, columns, scale, decimals) : std::string();
    for (const Column& column : columns) header += (&column == columns.data() ? "" : ",") + column.name;
    if (options.kind == TextTableKind::csv) header += ",frame";
    bytes.write(header + "\n");
  }
  // What stands before each number of a row.
  std::vector<std::string> before;
  before.reserve(columns.size());
  for (const Column& column : columns) before.push_back(json ? fmt::format(",\"{}\":", column.name) : ",");

  // What ends each row: an ECSV names its frame in the header.
  std::string end = "\n";
  if (json) end = fmt::format(",\"frame\":{}}}\n", double_quoted(ephemeris.frame_name()));
  if (options.kind == TextTableKind::csv) end = fmt::format(",{}\n", csv_cell(ephemeris.frame_name()));

  const auto encode = [&](DateText& dates, const AttitudeBlock& block, EncodedBlock& out) {
    out.bytes.clear();
    std::size_t column = 0;
    const auto put = [&](double value) { append_number(out.bytes, before[++column], value); };
    for (std::size_t row = 0; row < block.rows; ++row) {
      column = 0;
      if (json) out.bytes.append("{\"").append(columns[0].name).append("\":\"");
      dates.append(out.bytes, block.time[row]);
      if (json) out.bytes.push_back('"');
      for (const std::size_t k : {1, 2, 3, 0}) put(block.q_frame_from_named[4 * row + k]);
      for (std::size_t k = 0; k < 3; ++k) put(block.omega_named_rad_s[3 * row + k]);
      if (options.momentum) {
        for (std::size_t k = 0; k < 3; ++k) put(block.momentum_named[3 * row + k]);
      }
      if (ephemeris.has_covariance()) {
        put(block.sigma_rad[row]);
        for (std::size_t k = 0; k < 6; ++k) put(block.covariance_rad2[6 * row + k]);
      }
      out.bytes.append(end);
    }
  };
  const auto new_encoder = [&]() -> Encoder {
    return [&encode, dates = DateText(times, decimals)](const AttitudeBlock& block, EncodedBlock& out) mutable {
      encode(dates, block, out);
    };
  };
  std::size_t rows = 0;
  stream_rows(ephemeris, {TimeResolution::Kind::decimals, decimals}, new_encoder, [&](const EncodedBlock& block) {
    bytes.write(block.bytes);
    rows += block.rows;
    if (progress) progress(rows);
  });
  bytes.commit();
}

}  // namespace polhode
