// The Attitude Ephemeris Message: segments of rows, each with metadata of its own.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "polhode/base/error.hpp"
#include "polhode/read/ccsds_frames.hpp"
#include "polhode/read/ccsds_reader.hpp"
#include "polhode/read/ccsds_rules.hpp"

namespace polhode {
namespace {

/// The columns of a data line after its epoch: table 4-4, version 1 included.
std::vector<std::string_view> columns_of(std::string_view type) {
  std::vector<std::string_view> list;
  const auto add = [&list](std::initializer_list<std::string_view> more) { list.insert(list.end(), more); };
  if (type.starts_with("QUATERNION")) add({"Q1", "Q2", "Q3", "QC"});
  if (type.starts_with("EULER_ANGLE")) add({"ANGLE_1", "ANGLE_2", "ANGLE_3"});
  if (type.starts_with("SPIN")) add({"SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL"});
  if (type == "QUATERNION/DERIVATIVE") add({"Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"});
  if (type == "QUATERNION/RATE" || type == "EULER_ANGLE/RATE" || type == "EULER_ANGLE/DERIVATIVE") {
    add({"ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"});
  }
  if (type.ends_with("/ANGVEL")) add({"ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"});
  if (type == "SPIN/NUTATION") add({"NUTATION", "NUTATION_PER", "NUTATION_PHASE"});
  if (type == "SPIN/NUTATION_MOM") add({"MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"});
  return list;
}

std::string_view unit_of(std::string_view column) {
  if (column.starts_with("Q")) return column.ends_with("_DOT") ? "1/s" : "";
  if (column == "NUTATION_PER") return "s";
  return column.ends_with("_DOT") || column.ends_with("_VEL") || column.starts_with("ANGVEL") ? "deg/s" : "deg";
}

/// What a segment's metadata say about its rows.
struct RowFormat {
  std::string type;
  std::vector<std::string_view> columns;
  bool scalar_first = false;
  CcsdsKinematics kinematics;
};

class AemReader : CcsdsReader {
 public:
  using CcsdsReader::CcsdsReader;
  using Rate = CcsdsKinematics::Rate;

  CcsdsAttitudeMessage read() {
    AttitudeHistory history;
    std::string id;
    for (const CcsdsSegment& segment : in_.segments) {
      const CcsdsFields f = metadata(segment, ccsds_rules::aem_metadata);
      if (history.segments.empty()) {
        id = f.normal("OBJECT_ID");
        history = new_history(f.text("OBJECT_ID"));
      } else if (f.normal("OBJECT_ID") != id) {
        throw f.error("OBJECT_ID", fmt::format("OBJECT_ID = {}: an AEM is about a single object, {} above",
                                               f.text("OBJECT_ID"), id));
      }
      history.segments.push_back(read_segment(f, data_of(segment)));
    }
    finish(std::move(history));
    return std::move(out_);
  }

 private:
  const CcsdsBlock& data_of(const CcsdsSegment& segment) const {
    const std::vector<CcsdsBlock>& blocks = segment.data.blocks;
    for (const CcsdsBlock& b : blocks) {
      if (b.name != "DATA") refuse(b);
    }
    if (blocks.size() != 1) {
      throw error(blocks.size() > 1 ? blocks[1].line : segment.metadata.line,
                  "each META block of an AEM is followed by one DATA block");
    }
    const CcsdsBlock& block = blocks[0];
    if (!block.entries.empty()) {
      throw error(block.entries[0].line,
                  fmt::format("the keyword {} between the data lines", block.entries[0].keyword));
    }
    if (block.rows.empty()) throw error(block.line, "the DATA block has no data lines");
    return block;
  }

  RowFormat row_format(const CcsdsFields& f) {
    RowFormat r;
    CcsdsKinematics& k = r.kinematics;
    r.type = f.normal("ATTITUDE_TYPE");
    set_ends(k, f, "REF_FRAME_A", "REF_FRAME_B", version_ == 1 ? "ATTITUDE_DIR" : "");
    r.columns = columns_of(r.type);
    const bool of_v1 = r.type == "QUATERNION/RATE" || r.type == "EULER_ANGLE/RATE";
    const bool of_v2 =
        r.type.ends_with("/ANGVEL") || r.type == "EULER_ANGLE/DERIVATIVE" || r.type == "SPIN/NUTATION_MOM";
    const std::size_t line = f.entry("ATTITUDE_TYPE").line;
    if (version_ == 2 && of_v1) throw error(line, fmt::format("ATTITUDE_TYPE = {} was removed in version 2", r.type));
    if (version_ == 1 && of_v2)
      warn(fmt::format("line {}: ATTITUDE_TYPE = {} of version 2 under a header of version 1", line, r.type));
    if (version_ == 1 && r.type.starts_with("QUATERNION")) {
      if (!f.has("QUATERNION_TYPE")) f.missing("QUATERNION_TYPE");
      r.scalar_first = f.normal("QUATERNION_TYPE") == "FIRST";
    }
    if (f.has("EULER_ROT_SEQ")) k.axes = euler_sequence(f);
    if (r.type.starts_with("EULER_ANGLE")) {
      k.attitude = CcsdsKinematics::Attitude::euler_angles;
      if (!k.axes) f.missing("EULER_ROT_SEQ");
    } else if (r.type.starts_with("SPIN")) {
      k.attitude = CcsdsKinematics::Attitude::spin;
    }
    if (r.type == "SPIN/NUTATION") k.rate = Rate::nutation;
    if (r.type == "SPIN/NUTATION_MOM") k.rate = Rate::momentum;
    if (r.type == "QUATERNION/DERIVATIVE") k.rate = Rate::quaternion;
    if (r.type == "EULER_ANGLE/DERIVATIVE") k.rate = Rate::euler_angles;
    if (of_v1) {
      k.rate = rate_of_v1(f, k);
    } else if (version_ == 2 && f.has("RATE_FRAME")) {
      warn(fmt::format("line {}: RATE_FRAME belongs to version 1; ignored", f.entry("RATE_FRAME").line));
    }
    if (r.type.ends_with("/ANGVEL")) k.rate = angular_velocity(f, k);
    return r;
  }

  Rate rate_of_v1(const CcsdsFields& f, const CcsdsKinematics& k) {
    if (!f.has("RATE_FRAME")) f.missing("RATE_FRAME");
    const std::string frame = f.normal("RATE_FRAME");
    if (frame != "REF_FRAME_A" && frame != "REF_FRAME_B") {
      throw f.error("RATE_FRAME",
                    fmt::format("RATE_FRAME = {}: REF_FRAME_A or REF_FRAME_B is wanted", f.text("RATE_FRAME")));
    }
    if (k.axes) {
      warn(std::string(warning_of_v1_rates));
      return Rate::euler_angles;
    }
    warn("QUATERNION/RATE without EULER_ROT_SEQ: the rates are read as the angular velocity in RATE_FRAME");
    return same_frame(f.text(frame), k.end) ? Rate::angular_velocity_in_end : Rate::angular_velocity_in_start;
  }

  Rate angular_velocity(const CcsdsFields& f, const CcsdsKinematics& k) {
    std::string frame = f.text("ANGVEL_FRAME");
    if (frame == "REF_FRAME_A" || frame == "REF_FRAME_B") frame = f.text(frame);
    if (frame.empty()) {
      warn(fmt::format("line {}: angular velocities without ANGVEL_FRAME; not used", f.entry("ATTITUDE_TYPE").line));
      return Rate::unused;
    }
    if (same_frame(frame, k.end)) return Rate::angular_velocity_in_end;
    if (same_frame(frame, k.start)) return Rate::angular_velocity_in_start;
    warn(fmt::format("line {}: ANGVEL_FRAME = {} is neither of the two frames; the rates are not used",
                     f.entry("ANGVEL_FRAME").line, frame));
    return Rate::unused;
  }

  /// A row's numbers in the order of the columns, and its epoch's text.
  std::vector<double> row_numbers(const CcsdsRow& row, const RowFormat& format, std::string& epoch_text) const {
    const SourceLocation at{file_, row.line};
    std::vector<double> numbers;
    if (!row.cells.empty() && !row.cells[0].keyword.empty()) {  // XML: by name
      CcsdsBlock block{"attitudeState", row.line, row.cells, {}, {}};
      if (version_ == 1 && format.kinematics.axes) {
        block.entries.push_back({"EULER_ROT_SEQ", format.kinematics.axes->name(), "", row.line});
        name_angles_by_place(block, block_name(block), file_);
        block.entries.pop_back();
      }
      std::vector<CcsdsRule> rules{{"EPOCH", CcsdsUse::required, CcsdsValue::epoch}};
      for (const std::string_view c : format.columns)
        rules.push_back({c, CcsdsUse::required, CcsdsValue::number, unit_of(c)});
      const CcsdsFields f(block, rules, fmt::format("an attitudeState of type {}", format.type), file_);
      epoch_text = f.text("EPOCH");
      for (const std::string_view c : format.columns) numbers.push_back(f.number(c));
      return numbers;
    }
    if (row.cells.size() != 1 + format.columns.size()) {
      throw InputError(at, fmt::format("{} words; a line of type {} has an epoch and {} numbers", row.cells.size(),
                                       format.type, format.columns.size()));
    }
    epoch_text = row.cells[0].value;
    for (std::size_t k = 1; k < row.cells.size(); ++k) numbers.push_back(ccsds_number(row.cells[k].value, at));
    if (format.scalar_first) {
      std::rotate(numbers.begin(), numbers.begin() + 1, numbers.begin() + 4);
      if (format.type == "QUATERNION/DERIVATIVE")
        std::rotate(numbers.begin() + 4, numbers.begin() + 5, numbers.begin() + 8);
    }
    return numbers;
  }

  AttitudeSegment read_segment(const CcsdsFields& f, const CcsdsBlock& block) {
    const RowFormat format = row_format(f);
    AttitudeSegment segment;
    const Instant start = date(f, "START_TIME");
    const Instant stop = date(f, "STOP_TIME");
    if (stop < start) throw f.error("STOP_TIME", "STOP_TIME is before START_TIME");
    if (f.has("USEABLE_START_TIME")) segment.usable_start = date(f, "USEABLE_START_TIME");
    if (f.has("USEABLE_STOP_TIME")) segment.usable_stop = date(f, "USEABLE_STOP_TIME");
    if (segment.usable_start && segment.usable_stop && *segment.usable_stop < *segment.usable_start)
      throw f.error("USEABLE_STOP_TIME", "USEABLE_STOP_TIME is before USEABLE_START_TIME");
    const auto check_within = [&](const std::optional<Instant>& time, std::string_view keyword) {
      if (time && (*time < start || stop < *time))
        throw f.error(keyword, fmt::format("{} is outside of START_TIME to STOP_TIME", keyword));
    };
    check_within(segment.usable_start, "USEABLE_START_TIME");
    check_within(segment.usable_stop, "USEABLE_STOP_TIME");
    for (const CcsdsRow& row : block.rows) {
      const SourceLocation at{file_, row.line};
      std::string epoch_text;
      const std::vector<double> numbers = row_numbers(row, format, epoch_text);
      const StatedAttitude a = format.kinematics.stated(numbers, "ATT", at);
      const AttitudeSample sample{clock_.date(epoch_text, at), a.q_frame_from_body, a.omega_body_rad_s};
      if (!segment.samples.empty() && !(segment.samples.back().time < sample.time))
        throw InputError(at, fmt::format("time {} is not after the one above; times increase", epoch_text));
      // Real files round the span and the rows differently; a second more is another matter.
      if ((start - sample.time).high >= 1.0 || (sample.time - stop).high >= 1.0)
        throw InputError(at, fmt::format("{} is outside of START_TIME to STOP_TIME", epoch_text));
      add_row(segment, a, sample.time);
    }
    if ((segment.samples.front().time - start).high > 1.0 || (stop - segment.samples.back().time).high > 1.0)
      warn(fmt::format("line {}: the data lines do not reach from START_TIME to STOP_TIME", block.line));
    set_interpolation(segment, f);
    return segment;
  }

  void set_interpolation(AttitudeSegment& segment, const CcsdsFields& f) {
    segment.choose_method();
    if (!f.has("INTERPOLATION_METHOD")) {
      if (f.has("INTERPOLATION_DEGREE")) warn("INTERPOLATION_DEGREE without INTERPOLATION_METHOD; not used");
      return;
    }
    const std::string method = f.normal("INTERPOLATION_METHOD");
    const std::size_t line = f.entry("INTERPOLATION_METHOD").line;
    constexpr std::array methods{AttitudeInterpolation::linear, AttitudeInterpolation::lagrange,
                                 AttitudeInterpolation::hermite};
    const auto* const known =
        std::find_if(methods.begin(), methods.end(), [&](AttitudeInterpolation m) { return name(m) == method; });
    if (known == methods.end()) {
      warn(fmt::format("line {}: INTERPOLATION_METHOD = {} is none of LINEAR, LAGRANGE, HERMITE; {} is used", line,
                       method, name(segment.method)));
      return;
    }
    if (!f.has("INTERPOLATION_DEGREE") && method != "LINEAR")
      throw error(line, "INTERPOLATION_DEGREE is missing: it goes with INTERPOLATION_METHOD");
    segment.method = *known;
    segment.degree = f.has("INTERPOLATION_DEGREE") ? static_cast<int>(f.number("INTERPOLATION_DEGREE")) : 1;
    segment.method_stated = true;
    const std::size_t per_row = segment.has_rates() && segment.method == AttitudeInterpolation::hermite ? 2 : 1;
    const std::size_t needed = (static_cast<std::size_t>(segment.degree) + per_row) / per_row;
    if (segment.method != AttitudeInterpolation::linear && segment.samples.size() < needed) {
      warn(fmt::format("line {}: {} rows are too few for {} of degree {}; the degree is reduced", line,
                       segment.samples.size(), method, segment.degree));
    }
    if (segment.method == AttitudeInterpolation::hermite && !segment.has_rates())
      warn(fmt::format("line {}: HERMITE without rates is the same as LAGRANGE", line));
  }
};

}  // namespace

CcsdsAttitudeMessage read_aem(const CcsdsMessage& message, const std::string& file) {
  return AemReader(message, file).read();
}

}  // namespace polhode
