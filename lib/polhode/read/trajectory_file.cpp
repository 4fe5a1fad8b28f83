#include "polhode/read/trajectory_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/ccsds_fields.hpp"
#include "polhode/read/ccsds_rules.hpp"
#include "polhode/read/ccsds_tree.hpp"
#include "polhode/read/date_column.hpp"
#include "polhode/read/elements_file.hpp"
#include "polhode/read/horizons_file.hpp"
#include "polhode/read/text_file.hpp"
#include "polhode/read/text_table.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

constexpr int kDegree = 7;  // where the file names none

/// Takes rows in a frame of the file to the wanted one.
class ToFrame {
 public:
  ToFrame(Frame from, Frame to) : from_(from), to_from_icrf_(q_icrf_from(to).toRotationMatrix().transpose()) {
    if (is_inertial(from_)) fixed_ = to_from_icrf_ * q_icrf_from(from_).toRotationMatrix();
  }

  void turn(Instant instant, Vector3& position, Vector3* velocity) const {
    if (is_inertial(from_)) {
      position = fixed_ * position;
      if (velocity != nullptr) *velocity = fixed_ * *velocity;
      return;
    }
    // The frame turns: a central difference over two seconds is within 1e-9 of its rate.
    const Matrix3 now = at(instant);
    if (velocity != nullptr) {
      const Matrix3 rate = 0.5 * (at(instant + Seconds{1.0, 0.0}) - at(instant + Seconds{-1.0, 0.0}));
      *velocity = now * *velocity + rate * position;
    }
    position = now * position;
  }

 private:
  Matrix3 at(Instant instant) const { return to_from_icrf_ * q_icrf_from(from_, instant).toRotationMatrix(); }

  Frame from_;
  Matrix3 to_from_icrf_, fixed_ = Matrix3::Identity();
};

void append(double t_s, const Vector3& position, const Vector3* velocity, const SourceLocation& where,
            OrbitTable& table) {
  if (!table.times_s.empty() && !(table.times_s.back() < t_s)) {
    throw InputError(where, "this time is not after the one above");
  }
  table.times_s.push_back(t_s);
  table.positions_m.push_back(position);
  if (velocity != nullptr) table.velocities_m_s.push_back(*velocity);
}

// --- OEM ------------------------------------------------------------------------------------------------------------

constexpr auto oem_metadata = std::to_array<CcsdsRule>(
    {{"OBJECT_NAME OBJECT_ID CENTER_NAME REF_FRAME TIME_SYSTEM", CcsdsUse::required},
     {"START_TIME STOP_TIME", CcsdsUse::required, CcsdsValue::epoch},
     {"REF_FRAME_EPOCH USEABLE_START_TIME USEABLE_STOP_TIME", CcsdsUse::optional, CcsdsValue::epoch},
     {"INTERPOLATION", CcsdsUse::optional, CcsdsValue::text, {}, "HERMITE LINEAR LAGRANGE"},
     {"INTERPOLATION_DEGREE", CcsdsUse::optional, CcsdsValue::integer}});
constexpr std::array<std::string_view, 10> row_keywords{"EPOCH", "X",     "Y",      "Z",      "X_DOT",
                                                        "Y_DOT", "Z_DOT", "X_DDOT", "Y_DDOT", "Z_DDOT"};

Frame oem_frame(const CcsdsFields& fields) {
  const std::string name = fields.normal("REF_FRAME");
  return located(fields.where("REF_FRAME"), [&] { return frame(name.starts_with("ITRF") ? "ITRF" : name); });
}

class OemReader {
 public:
  OemReader(const std::string& path, const TrajectoryRequest& request) : path_(path), request_(request) {}

  TabulatedOrbit read(std::string_view text) {
    const CcsdsFile file = parse_ccsds(text, path_, CcsdsContent::orbit);
    const CcsdsMessage& message = file.messages.front();
    if (file.messages.size() > 1) {
      throw InputError({path_, file.messages[1].header.line}, "a second OEM; one trajectory is wanted");
    }
    if (message.version != "1.0" && message.version != "2.0" && message.version != "3.0") {
      throw InputError({path_, message.header.line},
                       fmt::format("OEM version {}; 1.0, 2.0 and 3.0 can be read", message.version));
    }
    const CcsdsFields header(message.header, ccsds_rules::header, "the header of an OEM", path_);
    if (message.segments.empty()) throw InputError({path_, message.header.line}, "the OEM has no segment");
    std::vector<OrbitTable> tables;
    std::string object;
    for (const CcsdsSegment& segment : message.segments) tables.push_back(table(segment, object));
    return located({path_, message.segments.front().metadata.line}, [&] { return TabulatedOrbit(std::move(tables)); });
  }

  /// In capitals.
  const std::string& centre() const { return centre_; }

 private:
  OrbitTable table(const CcsdsSegment& segment, std::string& object) {
    const CcsdsFields fields(segment.metadata, oem_metadata, "the metadata of an OEM", path_);
    if (object.empty()) object = fields.normal("OBJECT_ID");
    if (fields.normal("OBJECT_ID") != object) {
      throw InputError(fields.where("OBJECT_ID"),
                       fmt::format("{}: another object than the first segment's {}", fields.text("OBJECT_ID"), object));
    }
    if (centre_.empty()) centre_ = request_.centre.empty() ? fields.normal("CENTER_NAME") : ccsds_text(request_.centre);
    if (fields.normal("CENTER_NAME") != centre_) {
      throw InputError(fields.where("CENTER_NAME"),
                       fmt::format("the trajectory is about {}, one about {} is wanted", fields.text("CENTER_NAME"),
                                   request_.centre.empty() ? centre_ : request_.centre));
    }
    const CcsdsClock clock = ccsds_clock(fields.entry("TIME_SYSTEM"), path_);
    if (!clock.known) {
      throw InputError(fields.where("TIME_SYSTEM"),
                       fmt::format("{} cannot be placed beside the body's epoch; UTC, TAI, TT, TDB or GPS is wanted",
                                   fields.text("TIME_SYSTEM")));
    }
    const ToFrame to_frame(oem_frame(fields), request_.frame);
    OrbitTable table;
    const std::string method = fields.has("INTERPOLATION") ? fields.normal("INTERPOLATION") : "LAGRANGE";
    if (fields.has("INTERPOLATION") && method != "LINEAR" && !fields.has("INTERPOLATION_DEGREE")) {
      fields.missing("INTERPOLATION_DEGREE");
    }
    table.degree = method == "LINEAR"                   ? 1
                   : fields.has("INTERPOLATION_DEGREE") ? static_cast<int>(fields.number("INTERPOLATION_DEGREE"))
                                                        : kDegree;
    for (const CcsdsRow& row : segment.data.rows) add(row, clock, to_frame, method == "HERMITE", table);
    if (!fields.has("INTERPOLATION")) {  // as well as a short table allows
      table.degree = std::clamp(static_cast<int>(table.times_s.size()) - 1, 1, kDegree);
    }
    const auto useable_s = [&](std::string_view key) -> std::optional<double> {
      if (!fields.has(key)) return std::nullopt;
      return (clock.date(fields.text(key), fields.where(key)) - request_.zero).high;
    };
    table.useable_from_s = useable_s("USEABLE_START_TIME");
    table.useable_to_s = useable_s("USEABLE_STOP_TIME");
    return table;
  }

  void add(const CcsdsRow& row, const CcsdsClock& clock, const ToFrame& to_frame, bool hermite,
           OrbitTable& table) const {
    const SourceLocation here{path_, row.line};
    if (row.cells.size() != 7 && row.cells.size() != 10) {
      throw InputError(here, fmt::format("{} values; a date and 6 or 9 numbers are wanted", row.cells.size()));
    }
    for (std::size_t k = 0; k < row.cells.size(); ++k) {
      if (!row.cells[k].keyword.empty() && row.cells[k].keyword != row_keywords[k]) {
        throw InputError({path_, row.cells[k].line},
                         fmt::format("{} where {} is wanted", row.cells[k].keyword, row_keywords[k]));
      }
    }
    const Instant instant = clock.date(row.cells[0].value, here);
    Vector3 position, velocity;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      position[i] = 1e3 * ccsds_number(row.cells[1 + k].value, here);
      velocity[i] = 1e3 * ccsds_number(row.cells[4 + k].value, here);
    }
    to_frame.turn(instant, position, hermite ? &velocity : nullptr);
    append((instant - request_.zero).high, position, hermite ? &velocity : nullptr, here, table);
  }

  const std::string& path_;
  const TrajectoryRequest& request_;
  std::string centre_;
};

// --- Tables of text -------------------------------------------------------------------------------------------------

class TableReader {
 public:
  TableReader(std::string_view text, const std::string& path, const TrajectoryRequest& request)
      : table_(text, path), request_(request) {
    if (table_.names().empty()) throw table_.error("the table has no line of column names");
  }

  TabulatedOrbit read() {
    const ToFrame to_frame(request_.table_frame.value_or(request_.frame), request_.frame);
    const SourceLocation names_at = table_.here();
    const DateReader instant = clock();
    const std::array<Column, 3> place{column("x"), column("y"), column("z")};
    const bool with_velocity = find("vx") || find("vy") || find("vz");
    std::array<Column, 3> motion{};
    if (with_velocity) motion = {column("vx"), column("vy"), column("vz")};
    const auto value = [this](const Column& column) { return column.to_si * table_.number(column.index); };

    OrbitTable table;
    while (table_.next()) {
      Instant time;
      time = table_.located([&] { return instant(table_.cell(0)); });
      Vector3 position(value(place[0]), value(place[1]), value(place[2])), velocity = Vector3::Zero();
      if (with_velocity) velocity = {value(motion[0]), value(motion[1]), value(motion[2])};
      to_frame.turn(time, position, with_velocity ? &velocity : nullptr);
      append((time - request_.zero).high, position, with_velocity ? &velocity : nullptr, table_.here(), table);
    }
    const int nodes = static_cast<int>(table.times_s.size()) * (with_velocity ? 2 : 1);
    table.degree = std::clamp(nodes - 1, 1, kDegree);
    return located(names_at, [&] { return TabulatedOrbit({std::move(table)}); });
  }

 private:
  struct Column {
    std::size_t index = 0;
    double to_si = 1.0;
  };

  /// What the first column says.
  DateReader clock() const {
    const std::string& name = table_.names()[0];
    if (name == "t_s") {
      table_.check_unit(0, "s");
      return [zero = request_.zero](std::string_view text) {
        const std::optional<double> seconds = parse_number(text);
        if (!seconds) throw InputError(fmt::format("'{:.40}' is not a number of seconds", text));
        return zero + Seconds{*seconds, 0.0};
      };
    }
    if (const DateReader reader = date_column(table_, 0)) return reader;
    throw table_.error(
        fmt::format("the first column is '{:.40}'; allowed: date_, jd_ or mjd_ and a time scale "
                    "(date_tdb), time with its scale in an ECSV header, t_s",
                    name));
  }

  std::optional<Column> find(std::string_view wanted) const {
    const bool speed = wanted.starts_with('v');
    std::optional<Column> found;
    for (std::size_t i = 1; i < table_.names().size(); ++i) {
      const std::string& name = table_.names()[i];
      std::string unit(table_.header().unit(name));  // goes before its name's
      if (name == wanted) {
        if (unit.empty()) {
          throw table_.error(
              fmt::format("column {} has no unit: name it {}{} or the like", name, name, speed ? "_km_s" : "_km"));
        }
      } else if (name.size() > wanted.size() && name.starts_with(wanted) && name[wanted.size()] == '_') {
        if (unit.empty()) {
          unit = name.substr(wanted.size() + 1);
          std::replace(unit.begin(), unit.end(), '_', '/');  // vx_km_s
        }
      } else {
        continue;
      }
      if (found) {
        throw table_.error(
            fmt::format("there are two columns for {}: {} and {}", wanted, table_.names()[found->index], name));
      }
      try {
        found = Column{i, speed ? speed_unit_m_s(unit) : length_unit_m(unit)};
      } catch (const InputError& error) {
        throw table_.error(fmt::format("column {}: {}", name, error.what()));
      }
    }
    return found;
  }

  Column column(std::string_view wanted) const {
    if (const std::optional<Column> found = find(wanted)) return *found;
    throw table_.error(fmt::format("there is no column {}_m, {}_km, or {} with a unit", wanted, wanted, wanted));
  }

  TextTable table_;
  const TrajectoryRequest& request_;
};

}  // namespace

TabulatedOrbit read_trajectory(const std::string& path, const TrajectoryRequest& request) {
  return parse_trajectory(read_text_file(path), path, request);
}

TabulatedOrbit parse_trajectory(const std::string& text, const std::string& path, const TrajectoryRequest& request) {
  if (is_ccsds(text)) {
    if (request.table_frame) {
      throw InputError({path, 1}, "an OEM names its own frame; trajectory_frame is for tables of text");
    }
    return OemReader(path, request).read(text);
  }
  return TableReader(text, path, request).read();
}

CentredTrajectory read_centred_trajectory(const std::string& path, const TrajectoryRequest& request) {
  return parse_centred_trajectory(read_text_file(path), path, request);
}

CentredTrajectory parse_centred_trajectory(const std::string& text, const std::string& path,
                                           const TrajectoryRequest& request) {
  if (is_horizons(text)) return parse_horizons(text, path, request);
  if (is_elements(text)) return parse_elements(text, path, request);
  TrajectoryRequest any = request;
  any.centre.clear();
  if (!is_ccsds(text)) return {Trajectory(parse_trajectory(text, path, any)), {}};
  OemReader reader(path, any);
  TabulatedOrbit orbit = reader.read(text);
  return {Trajectory(std::move(orbit)), reader.centre()};
}

}  // namespace polhode
