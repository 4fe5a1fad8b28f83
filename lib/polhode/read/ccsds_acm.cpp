// The Attitude Comprehensive Message: attitude histories, the body's mass properties, and what is checked and left out.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/body/uncertain_state.hpp"
#include "polhode/read/ccsds_frames.hpp"
#include "polhode/read/ccsds_reader.hpp"
#include "polhode/read/ccsds_rules.hpp"

namespace polhode {
namespace {

class AcmReader : CcsdsReader {
 public:
  using CcsdsReader::CcsdsReader;

  CcsdsAttitudeMessage read() {
    const CcsdsFields f = metadata(in_.segments[0], ccsds_rules::acm_metadata);
    clock_.zero = date(f, "EPOCH_TZERO");
    if (f.has("NEXT_LEAP_EPOCH")) date(f, "NEXT_LEAP_EPOCH");
    if (f.has("START_TIME") && f.has("STOP_TIME") && time(f, "STOP_TIME") < time(f, "START_TIME"))
      throw f.error("STOP_TIME", "STOP_TIME is before START_TIME");
    const CcsdsBlock& data = in_.segments[0].data;
    if (!data.entries.empty()) {
      throw error(data.entries[0].line,
                  fmt::format("the keyword {} stands outside of any block", data.entries[0].keyword));
    }
    check_data_elements(f, data);

    constexpr std::array<std::string_view, 6> order{"ATT", "PHYS", "COV", "MAN", "AD", "USER"};
    std::string single;  // the block above, if there is at most one such
    const std::string designator = f.text("INTERNATIONAL_DESIGNATOR");
    AttitudeHistory history = new_history(designator.empty() ? f.text("OBJECT_DESIGNATOR") : designator);
    std::size_t manoeuvres = 0;
    for (const CcsdsBlock& block : data.blocks) {
      check_order(block, order);
      if (block.name == single)
        throw error(block.line, fmt::format("a second {} block; there is at most one", block.name));
      single = block.name == "PHYS" || block.name == "AD" || block.name == "USER" ? block.name : "";
      if (block.name == "ATT") {
        history.segments.push_back(read_att(block));
      } else if (block.name == "PHYS") {
        read_phys(block);
      } else if (block.name == "COV") {
        read_cov(block);
      } else if (block.name == "MAN") {
        read_man(block);
        ++manoeuvres;
      } else if (block.name == "AD") {
        read_ad(block);
      } else {
        fields(block, ccsds_rules::user);
        note("user-defined parameters are left out");
      }
    }
    if (manoeuvres > 0) warn(fmt::format("manoeuvres: {}; no motion takes them into account", manoeuvres));
    finish(std::move(history));
    set_covariance();
    return std::move(out_);
  }

 private:
  void check_data_elements(const CcsdsFields& metadata, const CcsdsBlock& data) const {
    if (!metadata.has("ACM_DATA_ELEMENTS")) return;
    std::string listed;
    for (const char c : upper_case(metadata.text("ACM_DATA_ELEMENTS"))) listed += c == ',' ? ' ' : c;
    std::vector<std::string_view> found;
    for (const CcsdsBlock& b : data.blocks) found.push_back(b.name);
    const std::vector<std::string_view> wanted = split_words(listed);
    if (wanted != found) {
      throw metadata.error("ACM_DATA_ELEMENTS",
                           fmt::format("ACM_DATA_ELEMENTS = {}, but the blocks are {}", fmt::join(wanted, ", "),
                                       found.empty() ? "none" : fmt::format("{}", fmt::join(found, ", "))));
    }
  }

  Instant time(std::string_view text, const SourceLocation& at) const {
    const std::optional<double> seconds = parse_number(text);
    if (!seconds) return clock_.date(text, at);
    if (std::abs(*seconds) > 1e12) throw InputError(at, fmt::format("{} seconds from EPOCH_TZERO", text));
    return *clock_.zero + Seconds{*seconds, 0.0};
  }
  Instant time(const CcsdsFields& f, std::string_view keyword) const { return time(f.text(keyword), f.where(keyword)); }

  /// The data lines of a block: a time, which increases, relative to EPOCH_TZERO in all of them or in none, and
  /// numbers.
  template <class Take>
  void read_rows(const CcsdsBlock& block, std::size_t numbers, const Take& take) const {
    if (block.rows.empty()) throw error(block.line, fmt::format("{} has no data lines", block_name(block)));
    const auto is_relative = [](const CcsdsRow& row) { return parse_number(row.cells[0].value).has_value(); };
    std::optional<Instant> above;
    for (const CcsdsRow& row : block.rows) {
      const SourceLocation at{file_, row.line};
      if (row.cells.size() != numbers + 1) {
        throw InputError(at, fmt::format("{} words; a line of {} has a time and {} numbers", row.cells.size(),
                                         block_name(block), numbers));
      }
      const std::string& text = row.cells[0].value;
      if (is_relative(row) != is_relative(block.rows[0])) {
        throw InputError(at,
                         fmt::format("time {}: relative and absolute times are mixed in {}", text, block_name(block)));
      }
      const Instant instant = time(text, at);
      if (above && !(*above < instant))
        throw InputError(at, fmt::format("time {} is not after the one above; times increase", text));
      above = instant;
      std::vector<double> n;
      for (std::size_t c = 1; c < row.cells.size(); ++c) n.push_back(ccsds_number(row.cells[c].value, at));
      take(instant, n, row);
    }
  }

  AttitudeSegment read_att(const CcsdsBlock& block) {
    using enum CcsdsKinematics::Attitude;
    using Rate = CcsdsKinematics::Rate;
    const CcsdsFields f = fields_beside_rows(block, ccsds_rules::att);
    const std::string attitude = f.normal("ATT_TYPE");
    const std::string rate = f.has("RATE_TYPE") ? f.normal("RATE_TYPE") : "NONE";
    CcsdsKinematics k;
    k.attitude = attitude == "QUATERNION" ? quaternion : attitude == "DCM" ? matrix : euler_angles;
    k.rate = rate == "NONE"     ? Rate::none
             : rate == "Q_DOT"  ? Rate::quaternion
             : rate == "ANGVEL" ? Rate::angular_velocity_in_end
                                : (rate == "EULER_RATE" ? Rate::euler_angles : Rate::unused);
    const std::size_t numbers = k.attitude_numbers() + k.rate_numbers();
    if (static_cast<std::size_t>(f.number("NUMBER_STATES")) != numbers) {
      throw f.error("NUMBER_STATES", fmt::format("NUMBER_STATES = {}, but {} with rate {} has {}",
                                                 f.text("NUMBER_STATES"), attitude, rate, numbers));
    }
    if (f.has("EULER_ROT_SEQ")) k.axes = euler_sequence(f);
    if ((k.attitude == euler_angles || k.rate == Rate::euler_angles) && !k.axes) f.missing("EULER_ROT_SEQ");
    set_ends(k, f);
    if (rate == "GYRO_BIAS") note(fmt::format("line {}: GYRO_BIAS is a correction, not a rate; left out", block.line));
    if (k.attitude == matrix && k.rate == Rate::quaternion) {
      warn(fmt::format("line {}: Q_DOT with a matrix leaves the quaternion's sign open; QC >= 0 is assumed",
                       block.line));
    }
    AttitudeSegment segment;
    read_rows(block, numbers, [&](Instant instant, const std::vector<double>& n, const CcsdsRow& row) {
      add_row(segment, k.stated(n, "ATT", {file_, row.line}), instant);
    });
    segment.choose_method();
    return segment;
  }

  void read_phys(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, ccsds_rules::phys);
    if (f.has("CP_REF_FRAME") && !f.has("CP")) throw f.error("CP_REF_FRAME", "CP_REF_FRAME is given without CP");
    if (f.has("CP") && !f.has("CP_REF_FRAME"))
      warn(fmt::format("line {}: CP without CP_REF_FRAME", f.entry("CP").line));
    if (f.has("WET_MASS") && f.has("DRY_MASS") && f.number("DRY_MASS") > f.number("WET_MASS"))
      throw f.error("DRY_MASS", "DRY_MASS is larger than WET_MASS");
    if (f.all_or_none({"IXX", "IYY", "IZZ"})) {
      set_inertia(f, std::to_array<std::string_view>({"IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"}));
      if (!f.all_or_none({"IXY", "IXZ", "IYZ"})) warn("no products of inertia are given; they are taken as 0");
    } else if (f.has("IXY") || f.has("IXZ") || f.has("IYZ")) {
      f.missing("IXX");
    }
  }

  void read_cov(const CcsdsBlock& block) {
    const CcsdsFields f = fields_beside_rows(block, ccsds_rules::cov);
    const std::string type = f.normal("COV_TYPE");
    const std::size_t numbers = (type.starts_with("ANGLE") ? 3 : 4) + (type.find('_') != std::string::npos ? 3 : 0);
    Variances variances{frame_name(f, "COV_REF_FRAME"), type == "ANGLE" || type == "ANGLE_ANGVEL", {}};
    read_rows(block, numbers, [&](Instant time, const std::vector<double>& n, const CcsdsRow& row) {
      const auto negative = std::find_if(n.begin(), n.end(), [](double variance) { return variance < 0.0; });
      if (negative != n.end()) {
        const auto column = static_cast<std::size_t>(negative - n.begin()) + 1;
        throw error(row.line, fmt::format("variance {} is negative", row.cells[column].value));
      }
      variances.rows.emplace_back(time, n);
    });
    variances_.push_back(std::move(variances));
  }

  /// Of the state: the row at its epoch, of small turns about the body's axes or those of the attitude's frame, and of
  /// rates. Other rows follow from it, or from what the motion does not know.
  void set_covariance() {
    Body& body = out_.body;
    std::size_t left_out = variances_.size();
    const std::optional<StatedAttitude> attitude =
        body.attitudes.empty() ? std::nullopt : std::optional(body.attitudes.back());
    for (const Variances& variances : variances_) {
      if (body.uncertainty || !variances.of_angles || !attitude || !body.state) continue;
      StateSigmas sigmas;
      if (known_inertial_frame(variances.frame) == attitude->known_frame && attitude->known_frame) {
        sigmas.named_from_axes = attitude->q_frame_from_body.conjugate().toRotationMatrix();
      } else if (!same_frame(variances.frame, attitude->body)) {
        continue;
      }
      for (const auto& [time, n] : variances.rows) {
        if (std::abs((time - body.state->epoch).high) > 1e-6) continue;
        sigmas.turn_deg = Vector3(n.data()).cwiseSqrt();
        if (n.size() == 6) sigmas.rate_deg_s = Vector3(n.data() + 3).cwiseSqrt();
        set_state_uncertainty(body, sigmas);
        note(
            fmt::format("the covariance at the state's epoch is taken: {:.3g}, {:.3g}, {:.3g} deg about the axes of {}",
                        sigmas.turn_deg[0], sigmas.turn_deg[1], sigmas.turn_deg[2], variances.frame));
        --left_out;
        break;
      }
    }
    if (left_out > 0) note(fmt::format("covariance histories: {}, checked and left out", left_out));
  }

  void read_man(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, ccsds_rules::acm_man);
    if (f.has("MAN_END_TIME") && f.has("MAN_DURATION"))
      throw f.error("MAN_DURATION", "either MAN_END_TIME or MAN_DURATION is given, not both");
    if (!f.has("MAN_END_TIME") && !f.has("MAN_DURATION")) f.missing("MAN_END_TIME (or MAN_DURATION)");
    const Instant begin = time(f, "MAN_BEGIN_TIME");
    if (f.has("MAN_END_TIME") && time(f, "MAN_END_TIME") < begin)
      throw f.error("MAN_END_TIME", "MAN_END_TIME is before MAN_BEGIN_TIME");
    if (f.has("TARGET_MOM_FRAME") && !f.has("TARGET_MOMENTUM"))
      throw f.error("TARGET_MOM_FRAME", "TARGET_MOM_FRAME is given without TARGET_MOMENTUM");
    if (f.has("TARGET_MOMENTUM") && !f.has("TARGET_MOM_FRAME"))
      warn(fmt::format("line {}: TARGET_MOMENTUM without TARGET_MOM_FRAME", f.entry("TARGET_MOMENTUM").line));
  }

  void read_ad(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, ccsds_rules::ad);
    const bool has_rate = f.has("RATE_STATES") && f.normal("RATE_STATES") != "NONE";
    if (has_rate && f.has("NUMBER_STATES") && f.number("NUMBER_STATES") < 6.0) {
      throw f.error("NUMBER_STATES",
                    fmt::format("NUMBER_STATES = {}; with rates there are at least 6", f.text("NUMBER_STATES")));
    }
    if (f.normal("ATTITUDE_STATES") == "EULER_ANGLES" && !f.has("EULER_ROT_SEQ")) f.missing("EULER_ROT_SEQ");
    std::vector<std::pair<double, std::size_t>> numbers_used;
    for (const CcsdsBlock& sensor : block.blocks) {
      const CcsdsFields s = fields(sensor, ccsds_rules::sensor);
      const double index = s.number("SENSOR_NUMBER");
      for (const auto& [used, line] : numbers_used) {
        if (used == index)
          throw s.error("SENSOR_NUMBER", fmt::format("SENSOR_NUMBER {} is already used on line {}", index, line));
      }
      numbers_used.emplace_back(index, s.entry("SENSOR_NUMBER").line);
      const std::size_t deviations = s.has("SENSOR_NOISE_STDDEV") ? s.numbers("SENSOR_NOISE_STDDEV").size() : 0;
      if (s.has("NUMBER_SENSOR_NOISE_COVARIANCE") &&
          s.number("NUMBER_SENSOR_NOISE_COVARIANCE") != static_cast<double>(deviations)) {
        throw s.error("NUMBER_SENSOR_NOISE_COVARIANCE",
                      fmt::format("NUMBER_SENSOR_NOISE_COVARIANCE = {}, but SENSOR_NOISE_STDDEV has {}",
                                  s.text("NUMBER_SENSOR_NOISE_COVARIANCE"), deviations));
      }
    }
    note(fmt::format("attitude determination with {} sensors, checked and left out", block.blocks.size()));
  }

  /// A COV block. An ACM has variances only.
  struct Variances {
    std::string frame;
    bool of_angles = false;
    std::vector<std::pair<Instant, std::vector<double>>> rows;
  };
  std::vector<Variances> variances_;
};

}  // namespace

CcsdsAttitudeMessage read_acm(const CcsdsMessage& message, const std::string& file) {
  return AcmReader(message, file).read();
}

}  // namespace polhode
