#include "polhode/read/attitude_history_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/fits_table.hpp"
#include "polhode/read/range.hpp"
#include "polhode/read/text_table.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

/// Names the frame and the interpolation of rows from a file that says nothing of the latter. A frame that is not known
/// is a name only, as in CCSDS messages.
void finish(AttitudeHistory& history, AttitudeSegment segment, const std::string& frame_name, const std::string& path) {
  if (segment.samples.empty()) throw InputError({path, 0}, "the table has no rows");
  segment.frame = frame_name;
  try {
    const Frame known = frame(frame_name);
    if (is_inertial(known)) segment.known_frame = known;
  } catch (const InputError&) {
    history.warnings.push_back(
        fmt::format("{}: the frame {:.40} is not known; it is taken as a name only", path, frame_name));
  }
  segment.choose_method();
  if (const std::optional<std::string> doubt = doubt_about_interpolation(segment)) {
    history.warnings.push_back(fmt::format("{}: {}", path, *doubt));
  }
  history.segments.push_back(std::move(segment));
}

/// Adds a row; times increase, quaternions are unit.
void add_row(AttitudeSegment& segment, const AttitudeSample& sample, const SourceLocation& where) {
  const double norm = sample.q_frame_from_body.coeffs().stableNorm();
  if (!(std::abs(norm - 1.0) <= 1e-3)) {
    throw InputError(
        where, fmt::format("row {}: the quaternion has length {:.6g}, it must be 1", segment.samples.size() + 1, norm));
  }
  if (sample.omega_body_rad_s && !(sample.omega_body_rad_s->stableNorm() <= kGreatestRead)) {
    throw InputError(
        where, fmt::format("row {}: the rate is {:.6g} rad/s, up to {:g} rad/s can be read", segment.samples.size() + 1,
                           sample.omega_body_rad_s->stableNorm(), kGreatestRead));
  }
  if (!segment.samples.empty() && !(segment.samples.back().time < sample.time)) {
    throw InputError(where, fmt::format("row {}: its time is not after the one above", segment.samples.size() + 1));
  }
  segment.samples.push_back({sample.time, sample.q_frame_from_body.normalized(), sample.omega_body_rad_s});
}

// --- FITS -----------------------------------------------------------------------------------------------------------

bool is_fits(std::string_view text) { return text.starts_with("SIMPLE  ="); }

/// INERTIA1..3 with QPRINC0..3 of our own tables; nothing if they are not there or cannot be.
std::optional<Inertia> inertia_of(const FitsTable& table) {
  std::array<double, 3> moments{};
  std::array<double, 4> q{};
  for (std::size_t k = 0; k < 3; ++k) moments[k] = table.number(fmt::format("INERTIA{}", k + 1)).value_or(0.0);
  for (std::size_t k = 0; k < 4; ++k) q[k] = table.number(fmt::format("QPRINC{}", k)).value_or(0.0);
  const Quaternion q_named_from_principal(q[0], q[1], q[2], q[3]);
  if (!(std::abs(q_named_from_principal.norm() - 1.0) <= 1e-9)) return std::nullopt;
  if (!std::is_sorted(moments.begin(), moments.end())) return std::nullopt;
  try {
    Inertia inertia =
        inertia_from_moments({moments[0], moments[1], moments[2]}, table.unit("INERTIA1") == "kg m2");  // checks them
    check_range(inertia);
    inertia.named_from_principal = q_named_from_principal.normalized().toRotationMatrix();
    return inertia;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

AttitudeHistory parse_fits(std::string_view bytes, const std::string& path) {
  const FitsTable table(bytes, "ATTITUDE", path);
  const auto fail = [&path](const std::string& message) { return InputError({path, 0}, message); };
  AttitudeHistory history;
  history.object = table.text("OBJECT").value_or("");
  history.object_id = table.text("OBJECTID").value_or("");
  history.source = "FITS table ATTITUDE";
  history.inertia = inertia_of(table);
  if (!table.checksum_is_right()) {
    history.warnings.push_back(path + ": CHECKSUM is wrong: the header was changed by what leaves it as it was");
  }
  const std::optional<std::string> scale = table.text("TIMESYS");
  if (!scale) throw fail("TIMESYS is missing");
  history.scale = located({path, 0}, [&] { return time_scale(*scale); });
  if (history.scale == TimeScale::et) {
    throw fail(
        "TIMESYS is ET, which is TT by the standard of FITS and SPICE's ET, up to 1.7 ms away, by some programs; "
        "set it to TT or TDB");
  }
  // Where both are given the pair wins (FITS 4.0, 9.2.2).
  double day = 0.0;
  double fraction = 0.0;
  if (const auto integer = table.number("MJDREFI"); integer) {
    day = *integer;
    fraction = table.number("MJDREFF").value_or(0.0);
  } else if (const auto whole = table.number("MJDREF"); whole) {
    day = *whole;
  } else {
    throw fail("MJDREF is missing: times cannot be placed");
  }
  if (!(std::abs(day) < 1e7) || !(std::abs(fraction) < 1e7)) throw fail("MJDREF is out of range");
  const Instant reference = parse_date(fmt::format("MJD {:.17g} {:.17g}", day, fraction), history.scale);
  const std::string order = upper_case(table.text("QORDER").value_or("XYZS"));
  const std::string direction = upper_case(table.text("QDIR").value_or("A2B"));
  if (order != "XYZS" && order != "SXYZ")
    throw fail(fmt::format("QORDER = {}; XYZS (scalar last) and SXYZ can be read", order));
  if (direction != "A2B" && direction != "B2A")
    throw fail(fmt::format("QDIR = {}; A2B and B2A can be read", direction));
  std::string frame_name = table.text("REFFRAMA").value_or("");
  if (frame_name.empty()) {
    frame_name = "ICRF";
    history.warnings.push_back(path + ": no REFFRAMA; ICRF is assumed");
  }
  const auto time = table.column("TIME", 1);
  const auto low = table.column("TIME_LO", 1);
  const auto q = table.column("QPARAM", 4);
  const auto omega = table.column("OMEGA", 3);
  if (!time || !q) throw fail("the table ATTITUDE has no column TIME or QPARAM");
  const auto factor = [&fail](const auto& column, const char* name, const char* usual, const auto& of_unit) {
    try {
      return of_unit(column.unit.empty() ? usual : column.unit);
    } catch (const InputError& error) {
      throw fail(fmt::format("{}: {}", name, error.what()));
    }
  };
  const double time_s = factor(*time, "TIME", "s", duration_unit_s);
  // What is to be added to each TIME (FITS 4.0, 9.4.1, and OGIP 93-003).
  const double offset = table.number("TIMEOFFS").value_or(0.0) + table.number("TIMEZERO").value_or(0.0);
  const double rate_factor = omega ? factor(*omega, "OMEGA", "rad/s", angular_velocity_unit_rad_s) : 1.0;
  const Instant zero =
      Instant::from_tt_j2000(since_j2000(reference, history.scale));  // seconds as a sum of two doubles
  AttitudeSegment segment;
  segment.body = table.text("REFFRAMB").value_or("BODY");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double seconds = time_s * (time->values[row] + offset);
    if (!(std::abs(seconds) < 1e12)) throw fail(fmt::format("row {}: TIME is out of range", row + 1));
    const Instant elapsed = zero + Seconds{seconds, low ? low->values[row] : 0.0};
    const double* v = q->values.data() + 4 * row;
    const Quaternion given = order == "XYZS" ? Quaternion(v[3], v[0], v[1], v[2]) : Quaternion(v[0], v[1], v[2], v[3]);
    AttitudeSample sample{instant_from_j2000(elapsed.tt_since_j2000(), history.scale),
                          direction == "A2B" ? given : given.conjugate(),
                          {}};
    if (omega) sample.omega_body_rad_s = rate_factor * Eigen::Map<const Vector3>(omega->values.data() + 3 * row);
    add_row(segment, sample, {path, 0});
  }
  finish(history, std::move(segment), frame_name, path);
  return history;
}

// --- Text -----------------------------------------------------------------------------------------------------------

constexpr std::string_view date_prefix = "date_";

bool is_text_table(std::string_view text) {
  if (text.substr(0, 1 << 16).find(date_prefix) == std::string_view::npos) return false;
  while (text.starts_with('#')) take_line(text);
  return text.starts_with(date_prefix);
}

AttitudeHistory parse_text_table(std::string_view text, const std::string& path) {
  TextTable table(text, path);
  AttitudeHistory history;
  history.source = "table of text";
  history.object = table.header().entry("object");
  history.object_id = table.header().entry("object_id");
  std::string frame_name(table.header().entry("frame_a"));
  const std::size_t columns = table.names().size();
  if (columns == 0 || !table.names()[0].starts_with(date_prefix))
    throw table.error("the first column is wanted to be date_ and a time scale, as date_tdb");
  // What an ECSV header says of the column goes before its name, which a change of scale leaves as it was.
  const EcsvHeader::Time& time = table.header().time();
  const bool stated = !time.scale.empty() && table.names()[0] == (time.value.empty() ? time.name : time.value);
  history.scale = table.located([&] {
    return time_scale(stated ? std::string_view(time.scale)
                             : std::string_view(table.names()[0]).substr(date_prefix.size()));
  });
  const std::array<std::size_t, 4> q{table.column("q_scalar"), table.column("q_x"), table.column("q_y"),
                                     table.column("q_z")};
  const std::array<std::size_t, 3> omega{table.column("omega_body_x_rad_s"), table.column("omega_body_y_rad_s"),
                                         table.column("omega_body_z_rad_s")};
  const auto all = [columns](const auto& list) { return *std::max_element(list.begin(), list.end()) < columns; };
  if (!all(q)) throw table.error("the columns q_x, q_y, q_z, q_scalar are wanted");
  const bool rates = all(omega);
  for (const std::size_t column : q) table.check_unit(column, "");
  table.check_unit(0, "");
  Vector3 rate_unit_rad_s = Vector3::Ones();
  for (std::size_t k = 0; rates && k < 3; ++k) {
    const std::string_view unit = table.header().unit(table.names()[omega[k]]);
    if (!unit.empty()) {
      rate_unit_rad_s[static_cast<Eigen::Index>(k)] = table.located([&] { return angular_velocity_unit_rad_s(unit); });
    }
  }
  const std::size_t frame_at = table.column("frame");
  if (frame_name.empty() && frame_at == columns) {
    frame_name = "ICRF";
    history.warnings.push_back(path + ": the table has no column frame; ICRF is assumed");
  }
  std::string unknown;
  for (std::size_t i = 1; i < columns; ++i) {
    const std::string& name = table.names()[i];
    const auto has = [i](const auto& list) { return std::find(list.begin(), list.end(), i) != list.end(); };
    if (i == frame_at || has(q) || (rates && has(omega)) || name.starts_with("momentum_body_")) continue;
    unknown += fmt::format("{}{:.40}", unknown.empty() ? "" : ", ", name);
  }
  if (!unknown.empty()) {
    history.warnings.push_back(fmt::format("{}: not read: {}{}", path, unknown,
                                           rates ? "" : "; rates are omega_body_x_rad_s, _y_rad_s and _z_rad_s"));
  }
  AttitudeSegment segment;
  segment.body = "BODY";
  while (table.next()) {
    AttitudeSample sample;
    sample.q_frame_from_body = {table.number(q[0]), table.number(q[1]), table.number(q[2]), table.number(q[3])};
    if (rates) {
      sample.omega_body_rad_s =
          rate_unit_rad_s.cwiseProduct(Vector3(table.number(omega[0]), table.number(omega[1]), table.number(omega[2])));
    }
    if (frame_at < columns) {
      const std::string& here_frame = table.cell(frame_at);
      if (frame_name.empty()) frame_name = here_frame;
      if (here_frame.empty() || here_frame != frame_name) {
        throw table.error(fmt::format("the frame is '{:.40}', after '{:.40}'; a table has one frame, which is named",
                                      here_frame, frame_name));
      }
    }
    sample.time = table.located([&] { return parse_date(table.cell(0), history.scale); });
    add_row(segment, sample, table.here());
  }
  finish(history, std::move(segment), frame_name, path);
  return history;
}

}  // namespace

bool is_attitude_table(std::string_view text) { return is_fits(text) || is_text_table(text); }

BodyAndHistory read_attitude_table(const std::string& text, const RowOfFile& place, const ContentOf&) {
  const std::string& path = place.file;
  AttitudeHistory history = is_fits(text) ? parse_fits(text, path) : parse_text_table(text, path);
  const AttitudeSegment& segment = history.segments.front();
  const AttitudeSample& row = segment.samples.front();
  Body body;
  body.name = history.object.empty() ? path : history.object;
  body.id = history.object_id;
  body.source = history.source;
  body.warnings = history.warnings;
  if (segment.known_frame) {
    body.state = SpinState{row.time, history.scale, *segment.known_frame, row.q_frame_from_body, row.omega_body_rad_s};
  } else {
    body.missing.push_back("an attitude in an inertial frame (" + segment.frame + " is given)");
  }
  if (!row.omega_body_rad_s) body.missing.emplace_back("an angular velocity");
  body.inertia = history.inertia;
  if (!body.inertia) body.missing.emplace_back("an inertia");
  return {std::move(body), std::move(history), true};
}

}  // namespace polhode
