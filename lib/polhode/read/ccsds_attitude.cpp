#include "polhode/read/ccsds_attitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/read/ccsds_fields.hpp"
#include "polhode/read/ccsds_tree.hpp"
#include "polhode/read/text.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

using enum CcsdsValue;

constexpr std::string_view moment = "kg*m**2";

// --- The standard's tables of keywords ------------------------------------------------------------------------------

constexpr bool required = true;
constexpr bool optional = false;

constexpr auto header_rules = std::to_array<CcsdsRule>({{"CLASSIFICATION", optional},
                                                        {"CREATION_DATE", required, epoch},
                                                        {"ORIGINATOR", required},
                                                        {"MESSAGE_ID", optional}});

constexpr auto apm_metadata_rules = std::to_array<CcsdsRule>(
    {{"OBJECT_NAME", required}, {"OBJECT_ID", required}, {"CENTER_NAME", optional}, {"TIME_SYSTEM", required}});

constexpr auto apm_data_rules = std::to_array<CcsdsRule>({{"EPOCH", required, epoch}});

constexpr auto quat_rules = std::to_array<CcsdsRule>({{"REF_FRAME_A", required},
                                                      {"REF_FRAME_B", required},
                                                      {"Q1", required, number},
                                                      {"Q2", required, number},
                                                      {"Q3", required, number},
                                                      {"QC", required, number},
                                                      {"Q1_DOT", optional, number, "1/s"},
                                                      {"Q2_DOT", optional, number, "1/s"},
                                                      {"Q3_DOT", optional, number, "1/s"},
                                                      {"QC_DOT", optional, number, "1/s"}});

constexpr auto quat_rules_v1 = std::to_array<CcsdsRule>({{"EPOCH", required, epoch},
                                                         {"Q_FRAME_A", required},
                                                         {"Q_FRAME_B", required},
                                                         {"Q_DIR", required, text, {}, "A2B B2A"},
                                                         {"Q1", required, number},
                                                         {"Q2", required, number},
                                                         {"Q3", required, number},
                                                         {"QC", required, number},
                                                         {"Q1_DOT", optional, number, "1/s"},
                                                         {"Q2_DOT", optional, number, "1/s"},
                                                         {"Q3_DOT", optional, number, "1/s"},
                                                         {"QC_DOT", optional, number, "1/s"}});

constexpr auto euler_rules = std::to_array<CcsdsRule>({{"REF_FRAME_A", required},
                                                       {"REF_FRAME_B", required},
                                                       {"EULER_ROT_SEQ", required, sequence},
                                                       {"ANGLE_1", required, angle, "deg"},
                                                       {"ANGLE_2", required, angle, "deg"},
                                                       {"ANGLE_3", required, angle, "deg"},
                                                       {"ANGLE_1_DOT", optional, number, "deg/s"},
                                                       {"ANGLE_2_DOT", optional, number, "deg/s"},
                                                       {"ANGLE_3_DOT", optional, number, "deg/s"},
                                                       {"RATE_FRAME", optional}});  // of version 1; read with a warning

// The angles and rates of version 1 are named by axis and may come twice; they are renamed ANGLE_n, ANGLE_n_DOT first.
constexpr auto euler_rules_v1 =
    std::to_array<CcsdsRule>({{"EULER_FRAME_A", required},
                              {"EULER_FRAME_B", required},
                              {"EULER_DIR", required, text, {}, "A2B B2A"},
                              {"EULER_ROT_SEQ", required, sequence},
                              {"RATE_FRAME", optional, text, {}, "EULER_FRAME_A EULER_FRAME_B"},
                              {"ANGLE_1", optional, angle, "deg"},
                              {"ANGLE_2", optional, angle, "deg"},
                              {"ANGLE_3", optional, angle, "deg"},
                              {"ANGLE_1_DOT", optional, number, "deg/s"},
                              {"ANGLE_2_DOT", optional, number, "deg/s"},
                              {"ANGLE_3_DOT", optional, number, "deg/s"}});

constexpr auto angvel_rules = std::to_array<CcsdsRule>({{"REF_FRAME_A", required},
                                                        {"REF_FRAME_B", required},
                                                        {"ANGVEL_FRAME", required},
                                                        {"ANGVEL_X", required, number, "deg/s"},
                                                        {"ANGVEL_Y", required, number, "deg/s"},
                                                        {"ANGVEL_Z", required, number, "deg/s"}});

constexpr auto spin_rules = std::to_array<CcsdsRule>({{"REF_FRAME_A", required},
                                                      {"REF_FRAME_B", required},
                                                      {"SPIN_ALPHA", required, angle, "deg"},
                                                      {"SPIN_DELTA", required, angle, "deg"},
                                                      {"SPIN_ANGLE", required, angle, "deg"},
                                                      {"SPIN_ANGLE_VEL", required, number, "deg/s"},
                                                      {"NUTATION", optional, angle, "deg"},
                                                      {"NUTATION_PER", optional, not_zero, "s"},
                                                      {"NUTATION_PHASE", optional, angle, "deg"},
                                                      {"MOMENTUM_ALPHA", optional, angle, "deg"},
                                                      {"MOMENTUM_DELTA", optional, angle, "deg"},
                                                      {"NUTATION_VEL", optional, number, "deg/s"}});

constexpr auto spin_rules_v1 = std::to_array<CcsdsRule>({{"SPIN_FRAME_A", required},
                                                         {"SPIN_FRAME_B", required},
                                                         {"SPIN_DIR", required, text, {}, "A2B B2A"},
                                                         {"SPIN_ALPHA", required, angle, "deg"},
                                                         {"SPIN_DELTA", required, angle, "deg"},
                                                         {"SPIN_ANGLE", required, angle, "deg"},
                                                         {"SPIN_ANGLE_VEL", required, number, "deg/s"},
                                                         {"NUTATION", optional, angle, "deg"},
                                                         {"NUTATION_PER", optional, not_zero, "s"},
                                                         {"NUTATION_PHASE", optional, angle, "deg"}});

constexpr auto inertia_rules = std::to_array<CcsdsRule>({{"INERTIA_REF_FRAME", required},
                                                         {"IXX", required, positive, moment},
                                                         {"IYY", required, positive, moment},
                                                         {"IZZ", required, positive, moment},
                                                         {"IXY", required, number, moment},
                                                         {"IXZ", required, number, moment},
                                                         {"IYZ", required, number, moment}});

constexpr auto inertia_rules_v1 = std::to_array<CcsdsRule>({{"INERTIA_REF_FRAME", optional},
                                                            {"I11", required, positive, moment},
                                                            {"I22", required, positive, moment},
                                                            {"I33", required, positive, moment},
                                                            {"I12", required, number, moment},
                                                            {"I13", required, number, moment},
                                                            {"I23", required, number, moment}});

constexpr auto apm_man_rules = std::to_array<CcsdsRule>({{"MAN_EPOCH_START", required, epoch},
                                                         {"MAN_DURATION", required, not_negative, "s"},
                                                         {"MAN_REF_FRAME", required},
                                                         {"MAN_TOR_X", required, number, "N*m"},
                                                         {"MAN_TOR_Y", required, number, "N*m"},
                                                         {"MAN_TOR_Z", required, number, "N*m"},
                                                         {"MAN_DELTA_MASS", optional, not_positive, "kg"}});

constexpr auto apm_man_rules_v1 = std::to_array<CcsdsRule>({{"MAN_EPOCH_START", required, epoch},
                                                            {"MAN_DURATION", required, not_negative, "s"},
                                                            {"MAN_REF_FRAME", required},
                                                            {"MAN_TOR_1", required, number, "N*m"},
                                                            {"MAN_TOR_2", required, number, "N*m"},
                                                            {"MAN_TOR_3", required, number, "N*m"}});

constexpr std::string_view attitude_types =
    "QUATERNION QUATERNION/DERIVATIVE QUATERNION/ANGVEL QUATERNION/RATE EULER_ANGLE EULER_ANGLE/DERIVATIVE "
    "EULER_ANGLE/ANGVEL EULER_ANGLE/RATE SPIN SPIN/NUTATION SPIN/NUTATION_MOM";

constexpr auto aem_metadata_rules = std::to_array<CcsdsRule>({{"OBJECT_NAME", required},
                                                              {"OBJECT_ID", required},
                                                              {"CENTER_NAME", optional},
                                                              {"REF_FRAME_A", required},
                                                              {"REF_FRAME_B", required},
                                                              {"TIME_SYSTEM", required},
                                                              {"START_TIME", required, epoch},
                                                              {"USEABLE_START_TIME", optional, epoch},
                                                              {"USEABLE_STOP_TIME", optional, epoch},
                                                              {"STOP_TIME", required, epoch},
                                                              {"ATTITUDE_TYPE", required, text, {}, attitude_types},
                                                              {"EULER_ROT_SEQ", optional, sequence},
                                                              {"ANGVEL_FRAME", optional},
                                                              {"INTERPOLATION_METHOD", optional},
                                                              {"INTERPOLATION_DEGREE", optional, integer},
                                                              {"RATE_FRAME", optional}});  // of version 1

constexpr auto aem_metadata_rules_v1 = std::to_array<CcsdsRule>({{"OBJECT_NAME", required},
                                                                 {"OBJECT_ID", required},
                                                                 {"CENTER_NAME", optional},
                                                                 {"REF_FRAME_A", required},
                                                                 {"REF_FRAME_B", required},
                                                                 {"ATTITUDE_DIR", required, text, {}, "A2B B2A"},
                                                                 {"TIME_SYSTEM", required},
                                                                 {"START_TIME", required, epoch},
                                                                 {"USEABLE_START_TIME", optional, epoch},
                                                                 {"USEABLE_STOP_TIME", optional, epoch},
                                                                 {"STOP_TIME", required, epoch},
                                                                 {"ATTITUDE_TYPE", required, text, {}, attitude_types},
                                                                 {"QUATERNION_TYPE", optional, text, {}, "FIRST LAST"},
                                                                 {"EULER_ROT_SEQ", optional, sequence},
                                                                 {"RATE_FRAME", optional},
                                                                 {"ANGVEL_FRAME", optional},  // of version 2
                                                                 {"INTERPOLATION_METHOD", optional},
                                                                 {"INTERPOLATION_DEGREE", optional, integer}});

constexpr auto acm_metadata_rules = std::to_array<CcsdsRule>({{"CLASSIFICATION", optional},
                                                              {"OBJECT_NAME", required},
                                                              {"INTERNATIONAL_DESIGNATOR", optional},
                                                              {"CATALOG_NAME", optional},
                                                              {"OBJECT_DESIGNATOR", optional},
                                                              {"ORIGINATOR_POC", optional},
                                                              {"ORIGINATOR_POSITION", optional},
                                                              {"ORIGINATOR_PHONE", optional},
                                                              {"ORIGINATOR_EMAIL", optional},
                                                              {"ORIGINATOR_ADDRESS", optional},
                                                              {"ODM_MSG_LINK", optional},
                                                              {"CENTER_NAME", optional},
                                                              {"TIME_SYSTEM", required},
                                                              {"EPOCH_TZERO", required, epoch},
                                                              {"ACM_DATA_ELEMENTS", optional},
                                                              {"START_TIME", optional, CcsdsValue::time},
                                                              {"STOP_TIME", optional, CcsdsValue::time},
                                                              {"TAIMUTC_AT_TZERO", optional, number, "s"},
                                                              {"NEXT_LEAP_EPOCH", optional, epoch},
                                                              {"NEXT_LEAP_TAIMUTC", optional, number, "s"}});

constexpr std::string_view covariance_types =
    "ANGLE ANGLE_GYROBIAS ANGLE_ANGVEL QUATERNION QUATERNION_GYROBIAS QUATERNION_ANGVEL";

constexpr auto att_rules =
    std::to_array<CcsdsRule>({{"ATT_ID", optional},
                              {"ATT_PREV_ID", optional},
                              {"ATT_BASIS", optional},
                              {"ATT_BASIS_ID", optional},
                              {"REF_FRAME_A", required},
                              {"REF_FRAME_B", required},
                              {"NUMBER_STATES", required, integer},
                              {"ATT_TYPE", required, text, {}, "QUATERNION EULER_ANGLES DCM"},
                              {"EULER_ROT_SEQ", optional, sequence},
                              {"RATE_TYPE", optional, text, {}, "ANGVEL Q_DOT EULER_RATE GYRO_BIAS NONE"}});

constexpr auto phys_rules = std::to_array<CcsdsRule>({{"DRAG_COEFF", optional, not_negative},
                                                      {"WET_MASS", optional, positive, "kg"},
                                                      {"DRY_MASS", optional, positive, "kg"},
                                                      {"CP_REF_FRAME", optional},
                                                      {"CP", optional, vector, "m"},
                                                      {"INERTIA_REF_FRAME", optional},
                                                      {"IXX", optional, positive, moment},
                                                      {"IYY", optional, positive, moment},
                                                      {"IZZ", optional, positive, moment},
                                                      {"IXY", optional, number, moment},
                                                      {"IXZ", optional, number, moment},
                                                      {"IYZ", optional, number, moment}});

constexpr auto cov_rules = std::to_array<CcsdsRule>({{"COV_ID", optional},
                                                     {"COV_PREV_ID", optional},
                                                     {"COV_BASIS", optional},
                                                     {"COV_BASIS_ID", optional},
                                                     {"COV_REF_FRAME", optional},
                                                     {"COV_TYPE", required, text, {}, covariance_types}});

constexpr auto acm_man_rules = std::to_array<CcsdsRule>({{"MAN_ID", optional},
                                                         {"MAN_PREV_ID", optional},
                                                         {"MAN_PURPOSE", required},
                                                         {"MAN_BEGIN_TIME", required, CcsdsValue::time, "s"},
                                                         {"MAN_END_TIME", optional, CcsdsValue::time, "s"},
                                                         {"MAN_DURATION", optional, not_negative, "s"},
                                                         {"ACTUATOR_USED", optional},
                                                         {"TARGET_MOMENTUM", optional, vector, "N*m*s"},
                                                         {"TARGET_MOM_FRAME", optional},
                                                         {"TARGET_ATTITUDE", optional, quaternion},
                                                         {"TARGET_SPINRATE", optional, number, "deg/s"}});

constexpr auto ad_rules = std::to_array<CcsdsRule>(
    {{"AD_ID", optional},
     {"AD_PREV_ID", optional},
     {"AD_METHOD", optional, text, {}, "EKF TRIAD QUEST BATCH Q_METHOD FILTER_SMOOTHER"},
     {"ATTITUDE_SOURCE", optional},
     {"NUMBER_STATES", optional, integer},
     {"ATTITUDE_STATES", required, text, {}, "QUATERNION EULER_ANGLES DCM"},
     {"EULER_ROT_SEQ", optional, sequence},
     {"COV_TYPE",
      optional,
      text,
      {},
      "ANGLE ANGLE_GYROBIAS ANGLE_ANGVEL QUATERNION QUATERNION_GYROBIAS QUATERNION_ANGVEL NONE"},
     {"REF_FRAME_A", required},
     {"REF_FRAME_B", required},
     {"RATE_STATES", optional, text, {}, "ANGVEL Q_DOT EULER_RATE GYRO_BIAS NONE"},
     {"SIGMA_U", optional, not_negative, "deg/s**1.5"},
     {"SIGMA_V", optional, not_negative, "deg/s**0.5"},
     {"RATE_PROCESS_NOISE_STDDEV", optional, not_negative, "deg/s**1.5"}});

constexpr auto sensor_rules = std::to_array<CcsdsRule>({{"SENSOR_NUMBER", required, integer},
                                                        {"SENSOR_USED", optional},
                                                        {"NUMBER_SENSOR_NOISE_COVARIANCE", optional, integer},
                                                        {"SENSOR_NOISE_STDDEV", optional, numbers, "deg"},
                                                        {"SENSOR_FREQUENCY", optional, positive, "Hz"}});

constexpr auto user_rules = std::to_array<CcsdsRule>({{"USER_DEFINED_", optional}});

// --- Frames ---------------------------------------------------------------------------------------------------------

/// Whether a name is one of the spacecraft's own frames: SC_BODY_1, STARTRACKER_2, … (the SANA registry of spacecraft
/// body reference frames, and the names of 504.0-B-1 annex A3), with at most one further label.
bool is_local_frame(std::string_view name) {
  constexpr std::array<std::string_view, 23> stems{
      "SC_BODY",       "ACC",    "ACTUATOR",  "AST",        "STARTRACKER", "CSS",     "DSS",        "ESA",
      "GYRO_FRAME",    "GYRO",   "IMU_FRAME", "IMU",        "MTA",         "RW",      "INSTRUMENT", "SA",
      "SC_BODY_FRAME", "SENSOR", "TAM",       "BODY_FRAME", "BODY",        "ANTENNA", "THRUSTER"};
  const std::string text = ccsds_text(name);
  return std::any_of(stems.begin(), stems.end(), [&](std::string_view stem) {
    if (text == stem) return true;
    return text.starts_with(stem) && text.size() > stem.size() + 1 && text[stem.size()] == '_' &&
           text.find('_', stem.size() + 1) == std::string::npos;
  });
}

std::optional<Frame> known_inertial_frame(std::string_view name) {
  try {
    std::string text = ccsds_text(name);
    if (text.starts_with("ICRF") && text.size() == 5) text = "ICRF";  // ICRF1, ICRF2, ICRF3
    const Frame found = frame(text);
    return is_inertial(found) ? std::optional(found) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Names that CCSDS registers for frames that turn or follow an orbit; others are taken as names only, with a warning.
bool is_registered_frame(std::string_view name) {
  constexpr std::array<std::string_view, 35> stems{
      "ALIGN", "B1950", "CIRS", "DTRF", "ECLIP", "EFG", "EQUIN", "EQW", "FIXED", "GCRF", "GRC", "GTOD",
      "ICRF",  "ITRF",  "LVLH", "MCI",  "MOD",   "MOE", "NSW",   "NTW", "PEF",   "PQW",  "QSW", "RSW",
      "RTN",   "SEZ",   "TDR",  "TEME", "TIRS",  "TNW", "TOD",   "TOE", "UVW",   "VNC",  "VVLH"};
  const std::string text = ccsds_text(name);
  return known_inertial_frame(name) || is_local_frame(name) || text.starts_with("WGS84") || text == "VAR" ||
         std::any_of(stems.begin(), stems.end(), [&](std::string_view stem) { return text.starts_with(stem); });
}

/// SC_BODY without a number is SC_BODY_1.
bool same_frame(std::string_view a, std::string_view b) {
  const auto full = [](std::string_view name) {
    const std::string text = ccsds_text(name);
    return text == "SC_BODY" ? std::string("SC_BODY_1") : text;
  };
  if (full(a) == full(b)) return true;
  const std::optional<Frame> fa = known_inertial_frame(a);
  return fa && fa == known_inertial_frame(b);
}

// --- Kinematics -----------------------------------------------------------------------------------------------------

/// A rotation that leads from frame `start` to frame `end`, as messages state them.
struct Kinematics {
  std::string start;
  std::string end;
  Quaternion q_start_from_end;
  std::optional<Vector3> omega_end_rad_s;  ///< of `end` relative to `start`, components in `end`
};

/// Turned round if need be, so that the body's axes are those that move.
StatedAttitude stated(const Kinematics& k, std::string_view block) {
  const bool reversed = is_local_frame(k.start) && !is_local_frame(k.end);
  StatedAttitude s;
  s.block = block;
  s.frame = reversed ? k.end : k.start;
  s.body = reversed ? k.start : k.end;
  s.known_frame = known_inertial_frame(s.frame);
  s.q_frame_from_body = reversed ? k.q_start_from_end.conjugate() : k.q_start_from_end;
  if (k.omega_end_rad_s)
    s.omega_body_rad_s = reversed ? Vector3(-(k.q_start_from_end * *k.omega_end_rad_s)) : *k.omega_end_rad_s;
  return s;
}

/// From q' = q omega / 2; the part of q' along q, which only rounding has, drops out.
Vector3 omega_from_derivative(const Quaternion& q, const Eigen::Vector4d& derivative_vector_then_scalar) {
  const Eigen::Vector4d& d = derivative_vector_then_scalar;
  return 2.0 * (q.conjugate() * Quaternion(d[3], d[0], d[1], d[2])).vec();
}

/// 504.0-B-2 annex F5. Angles in degrees.
struct Spin {
  double alpha = 0.0, delta = 0.0, angle = 0.0, angle_vel = 0.0;
  enum class Model { steady, nutation, momentum } model = Model::steady;
  double third = 0.0, fourth = 0.0, fifth = 0.0;  // NUTATION, _PER, _PHASE or MOMENTUM_ALPHA, _DELTA, NUTATION_VEL
};

std::pair<Quaternion, Vector3> spin_kinematics(const Spin& s) {
  const Quaternion q =
      q_frame_from_body(EulerSequence("ZXZ"), degree * Vector3(s.alpha + 90.0, 90.0 - s.delta, s.angle));
  Vector3 omega(0.0, 0.0, degree * s.angle_vel);
  if (s.model == Spin::Model::nutation) {
    const double nutation = degree * s.third;
    const double phase = degree * s.fifth;
    const Vector3 momentum(std::sin(nutation) * std::cos(phase), -std::sin(nutation) * std::sin(phase),
                           std::cos(nutation));
    omega += 2.0 * std::numbers::pi / s.fourth * momentum;
  } else if (s.model == Spin::Model::momentum) {
    const double alpha = degree * s.third;
    const double delta = degree * s.fourth;
    const Vector3 momentum(std::cos(delta) * std::cos(alpha), std::cos(delta) * std::sin(alpha), std::sin(delta));
    omega += degree * s.fifth * (q.conjugate() * momentum);
  }
  return {q, omega};
}

// --- Messages -------------------------------------------------------------------------------------------------------

class Reader {
 public:
  Reader(const CcsdsMessage& message, const std::string& file) : in_(message), file_(file) {
    out_.kind = message.kind;
    const std::optional<double> version = parse_number(message.version);
    if (!version || (*version != 1.0 && *version != 2.0) || (*version == 1.0 && message.kind == "ACM")) {
      throw InputError({file, message.header.line},
                       fmt::format("version '{}' of the {} is unknown; {} can be read", message.version, message.kind,
                                   message.kind == "ACM" ? "2.0" : "1.0 and 2.0"));
    }
    v1_ = *version == 1.0;
    out_.version = v1_ ? "1.0" : "2.0";
  }

  CcsdsAttitudeMessage read() {
    const CcsdsFields header(in_.header, header_rules, "the header of " + message_name(), file_);
    out_.body.source = fmt::format("CCSDS {} {} by {}, {}", in_.kind, out_.version, header.text("ORIGINATOR"),
                                   header.text("CREATION_DATE"));
    if (in_.segments.empty())
      throw InputError({file_, in_.header.line}, fmt::format("{} without metadata and data", message_name()));
    if (in_.kind != "AEM" && in_.segments.size() > 1) {
      throw InputError({file_, in_.segments[1].metadata.line},
                       fmt::format("{} has a single metadata section", message_name()));
    }
    if (in_.kind == "APM") read_apm(in_.segments[0]);
    if (in_.kind == "AEM") read_aem();
    if (in_.kind == "ACM") read_acm(in_.segments[0]);
    return std::move(out_);
  }

 private:
  std::string message_name() const { return fmt::format("an {} {}", in_.kind, out_.version); }
  std::string block_name(const CcsdsBlock& block) const {
    return fmt::format("the {} block of {}", block.name, message_name());
  }
  void warn(std::string text) {
    std::vector<std::string>& list = out_.body.warnings;
    if (std::find(list.begin(), list.end(), text) == list.end()) list.push_back(std::move(text));
  }
  void note(std::string text) { out_.body.notes.push_back(std::move(text)); }

  void check_no_rows(const CcsdsBlock& block) const {
    if (!block.rows.empty())
      throw InputError({file_, block.rows[0].line}, fmt::format("a line without '=' in {}", block_name(block)));
  }

  /// The fields of a block without data lines.
  CcsdsFields fields(const CcsdsBlock& block, std::span<const CcsdsRule> rules) {
    check_no_rows(block);
    return {block, rules, block_name(block), file_};
  }

  /// A frame's name; warns about one that CCSDS does not register.
  std::string frame_name(const CcsdsFields& f, std::string_view keyword) {
    const std::string name = f.text(keyword);
    if (!name.empty() && !is_registered_frame(name)) {
      warn(fmt::format("line {}: {} = {} is not a frame that CCSDS registers; it is taken as a name only",
                       f.entry(keyword).line, keyword, name));
    }
    return name;
  }

  void set_clock(const CcsdsFields& metadata) {
    clock_ = ccsds_clock(metadata.entry("TIME_SYSTEM"), file_);
    if (!clock_.known) {
      warn(fmt::format("TIME_SYSTEM {} cannot be related to UTC: times count among themselves only", clock_.name));
    }
  }

  EulerSequence euler_sequence(const CcsdsFields& f) {
    const std::string text = f.text("EULER_ROT_SEQ");
    if (!v1_ && text[0] >= '1' && text[0] <= '3') {
      warn(fmt::format("line {}: EULER_ROT_SEQ = {} in version 2, which writes letters", f.entry("EULER_ROT_SEQ").line,
                       text));
    }
    return EulerSequence(text);
  }

  static Eigen::Vector4d four(const CcsdsFields& f, std::string_view a, std::string_view b, std::string_view c,
                              std::string_view d) {
    return {f.number(a), f.number(b), f.number(c), f.number(d)};
  }

  // --- APM

  void read_apm(const CcsdsSegment& segment) {
    check_no_rows(segment.metadata);
    const CcsdsFields metadata(segment.metadata, apm_metadata_rules, "the metadata of " + message_name(), file_);
    set_clock(metadata);
    out_.body.name = metadata.text("OBJECT_NAME");
    out_.body.id = metadata.text("OBJECT_ID");
    CcsdsBlock data = segment.data;
    bool v1_blocks = v1_;
    if (v1_ && !in_.xml && !data.blocks.empty()) {
      warn(fmt::format("line {}: blocks of version 2 under a header of version 1", data.blocks[0].line));
      v1_blocks = false;
    } else if (v1_ && !in_.xml) {
      data = split_v1(data);
    }
    const CcsdsFields top(data, v1_blocks ? std::span<const CcsdsRule>{} : std::span<const CcsdsRule>(apm_data_rules),
                          "the data of " + message_name(), file_);
    std::optional<Instant> epoch_time;
    if (top.has("EPOCH")) epoch_time = clock_.date(top.text("EPOCH"), top.where("EPOCH"));
    if (data.blocks.empty())
      throw InputError({file_, data.line}, fmt::format("{} needs at least one block of data", message_name()));

    constexpr std::array<std::string_view, 6> order{"QUAT", "EULER", "ANGVEL", "SPIN", "INERTIA", "MAN"};
    std::size_t last = 0;
    std::size_t manoeuvres = 0;
    for (CcsdsBlock& block : data.blocks) {
      const auto* const place = std::find(order.begin(), order.end(), block.name);
      const auto index = static_cast<std::size_t>(place - order.begin());
      if (place == order.end() || (v1_blocks && block.name == "ANGVEL")) {
        throw InputError({file_, block.line}, fmt::format("{} has no block {}", message_name(), block.name));
      }
      if (index < last) {
        throw InputError(
            {file_, block.line},
            fmt::format("the {} block comes after the {} block; their order is QUAT, EULER, ANGVEL, SPIN, INERTIA, MAN",
                        block.name, order[last]));
      }
      last = index;
      if (block.name == "QUAT") {
        read_quat(block, v1_blocks, epoch_time);
      } else if (block.name == "EULER") {
        read_euler(block, v1_blocks);
      } else if (block.name == "ANGVEL") {
        angular_velocities_.emplace_back(block);
        fields(block, angvel_rules);
      } else if (block.name == "SPIN") {
        read_spin(block, v1_blocks);
      } else if (block.name == "INERTIA") {
        read_apm_inertia(block, v1_blocks);
      } else {
        const CcsdsFields f = fields(block, v1_blocks ? std::span<const CcsdsRule>(apm_man_rules_v1)
                                                      : std::span<const CcsdsRule>(apm_man_rules));
        clock_.date(f.text("MAN_EPOCH_START"), f.where("MAN_EPOCH_START"));
        frame_name(f, "MAN_REF_FRAME");
        ++manoeuvres;
      }
    }
    if (manoeuvres > 0) note(fmt::format("manoeuvres: {}, checked and left out", manoeuvres));
    if (v1_blocks && !has_block(data, "QUAT")) {
      throw InputError({file_, data.line}, "Q_FRAME_A is missing: an APM 1.0 has a quaternion");
    }
    apply_angular_velocities();
    choose_state(epoch_time.value());
  }

  static bool has_block(const CcsdsBlock& data, std::string_view name) {
    return std::any_of(data.blocks.begin(), data.blocks.end(), [&](const CcsdsBlock& b) { return b.name == name; });
  }

  /// Version 1 has no marks around the blocks of an APM in KVN; their keywords tell.
  CcsdsBlock split_v1(const CcsdsBlock& flat) const {
    const auto block_of = [](std::string_view k) -> std::string_view {
      for (const CcsdsRule& r : quat_rules_v1) {
        if (r.keyword == k) return "QUAT";
      }
      if (k.starts_with("EULER_") || k == "RATE_FRAME" || k.ends_with("_ANGLE") || k.ends_with("_RATE")) {
        return k == "SPIN_ANGLE" ? "SPIN" : "EULER";
      }
      if (k.starts_with("SPIN_") || k.starts_with("NUTATION")) return "SPIN";
      for (const CcsdsRule& r : inertia_rules_v1) {
        if (r.keyword == k) return "INERTIA";
      }
      return k.starts_with("MAN_") ? "MAN" : "";
    };
    CcsdsBlock data;
    data.name = flat.name;
    data.line = flat.line;
    for (const CcsdsEntry& e : flat.entries) {
      const std::string_view name = block_of(e.keyword);
      if (name.empty())
        throw InputError({file_, e.line},
                         fmt::format("the keyword {} is not allowed in {}", e.keyword, message_name()));
      const bool next = data.blocks.empty() || data.blocks.back().name != name || e.keyword == "MAN_EPOCH_START";
      if (next) {
        data.blocks.emplace_back();
        data.blocks.back().name = name;
        data.blocks.back().line = e.line;
      }
      data.blocks.back().entries.push_back(e);
    }
    return data;
  }

  void read_quat(const CcsdsBlock& block, bool v1, std::optional<Instant>& epoch_time) {
    const CcsdsFields f =
        fields(block, v1 ? std::span<const CcsdsRule>(quat_rules_v1) : std::span<const CcsdsRule>(quat_rules));
    if (v1) epoch_time = clock_.date(f.text("EPOCH"), f.where("EPOCH"));
    Kinematics k;
    set_ends(k, f, v1 ? "Q_FRAME_A" : "REF_FRAME_A", v1 ? "Q_FRAME_B" : "REF_FRAME_B", v1 ? "Q_DIR" : "");
    k.q_start_from_end = ccsds_quaternion(four(f, "Q1", "Q2", "Q3", "QC"), f.where("Q1"));
    if (f.all_or_none({"Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"})) {
      k.omega_end_rad_s = omega_from_derivative(k.q_start_from_end, four(f, "Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"));
    }
    out_.body.attitudes.push_back(stated(k, "QUAT"));
  }

  /// `direction`: the keyword that may say B2A, or empty.
  void set_ends(Kinematics& k, const CcsdsFields& f, std::string_view a, std::string_view b,
                std::string_view direction) {
    k.start = frame_name(f, a);
    k.end = frame_name(f, b);
    if (same_frame(k.start, k.end))
      throw InputError(f.where(b), fmt::format("{} and {} are the same frame {}", a, b, k.end));
    if (!direction.empty() && f.normal(direction) == "B2A") std::swap(k.start, k.end);
  }

  /// Gives the angles and rates of version 1 their places in the sequence: X_ANGLE, Z_RATE … become ANGLE_n,
  /// ANGLE_n_DOT.
  void rename_v1_angles(CcsdsBlock& block) const {
    const CcsdsEntry* seq = nullptr;
    for (const CcsdsEntry& e : block.entries) {
      if (e.keyword == "EULER_ROT_SEQ") seq = &e;
    }
    if (seq == nullptr)
      throw InputError({file_, block.line}, fmt::format("EULER_ROT_SEQ is missing in {}", block_name(block)));
    const CcsdsEntry sequence_entry = *seq;
    CcsdsBlock only;
    only.line = block.line;
    only.entries = {sequence_entry};
    constexpr auto rule = std::to_array<CcsdsRule>({{"EULER_ROT_SEQ", required, sequence}});
    const CcsdsFields checked(only, rule, block_name(block), file_);
    const EulerSequence axes(sequence_entry.value);
    for (const std::string_view kind : {std::string_view("_ANGLE"), std::string_view("_RATE")}) {
      std::array<bool, 3> taken{};
      for (CcsdsEntry& e : block.entries) {
        if (e.keyword.size() != 1 + kind.size() || !e.keyword.ends_with(kind)) continue;
        std::size_t place = 0;
        while (place < 3 && (taken[place] || axes.axes()[place] != e.keyword[0] - 'X')) ++place;
        if (place == 3) {
          throw InputError({file_, e.line}, fmt::format("{} once too often, or not an axis of EULER_ROT_SEQ = {}",
                                                        e.keyword, sequence_entry.value));
        }
        taken[place] = true;
        e.keyword = fmt::format("ANGLE_{}{}", place + 1, kind == "_RATE" ? "_DOT" : "");
      }
    }
  }

  void read_euler(CcsdsBlock& block, bool v1) {
    if (v1) rename_v1_angles(block);
    const CcsdsFields f =
        fields(block, v1 ? std::span<const CcsdsRule>(euler_rules_v1) : std::span<const CcsdsRule>(euler_rules));
    const EulerSequence axes = euler_sequence(f);
    Kinematics k;
    set_ends(k, f, v1 ? "EULER_FRAME_A" : "REF_FRAME_A", v1 ? "EULER_FRAME_B" : "REF_FRAME_B", v1 ? "EULER_DIR" : "");
    const bool angles_given = f.all_or_none({"ANGLE_1", "ANGLE_2", "ANGLE_3"});
    const bool rates_given = f.all_or_none({"ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"});
    if (!v1 && f.has("RATE_FRAME"))
      warn(fmt::format("line {}: RATE_FRAME belongs to version 1; ignored", f.entry("RATE_FRAME").line));
    if (v1 && rates_given && !f.has("RATE_FRAME")) {
      throw InputError(f.start(), fmt::format("RATE_FRAME is missing in {}, which has rates", f.what()));
    }
    if (v1 && !angles_given && !rates_given) f.missing("X_ANGLE (or X_RATE)");
    Vector3 angles;
    if (angles_given) {
      angles = degree * Vector3(f.number("ANGLE_1"), f.number("ANGLE_2"), f.number("ANGLE_3"));
      k.q_start_from_end = q_frame_from_body(axes, angles);
    } else {
      // Rates alone, as version 1 allows: the angles are those of the quaternion between the same frames.
      const StatedAttitude* known = nullptr;
      for (const StatedAttitude& s : out_.body.attitudes) {
        if (same_frame(s.frame, k.start) && same_frame(s.body, k.end)) known = &s;
      }
      const StatedAttitude* turned = nullptr;
      for (const StatedAttitude& s : out_.body.attitudes) {
        if (same_frame(s.frame, k.end) && same_frame(s.body, k.start)) turned = &s;
      }
      if (known == nullptr && turned == nullptr) {
        warn(fmt::format("line {}: Euler rates without angles, and no quaternion between the same frames; not used",
                         block.line));
        return;
      }
      k.q_start_from_end = known != nullptr ? known->q_frame_from_body : turned->q_frame_from_body.conjugate();
      angles = euler_angles_rad(axes, k.q_start_from_end);
    }
    if (rates_given) {
      const Vector3 rates = degree * Vector3(f.number("ANGLE_1_DOT"), f.number("ANGLE_2_DOT"), f.number("ANGLE_3_DOT"));
      k.omega_end_rad_s = omega_body_rad_s(axes, angles, rates);
      if (v1) warn_v1_rates();
    }
    out_.body.attitudes.push_back(stated(k, "EULER"));
  }

  void warn_v1_rates() {
    warn(
        "the rates of version 1 are read as derivatives of the Euler angles, as its own examples and Orekit have them; "
        "RATE_FRAME is not used");
  }

  void read_spin(const CcsdsBlock& block, bool v1) {
    const CcsdsFields f =
        fields(block, v1 ? std::span<const CcsdsRule>(spin_rules_v1) : std::span<const CcsdsRule>(spin_rules));
    Kinematics k;
    set_ends(k, f, v1 ? "SPIN_FRAME_A" : "REF_FRAME_A", v1 ? "SPIN_FRAME_B" : "REF_FRAME_B", v1 ? "SPIN_DIR" : "");
    Spin s{f.number("SPIN_ALPHA"), f.number("SPIN_DELTA"), f.number("SPIN_ANGLE"), f.number("SPIN_ANGLE_VEL")};
    if (f.all_or_none({"NUTATION", "NUTATION_PER", "NUTATION_PHASE"})) {
      s.model = Spin::Model::nutation;
      s.third = f.number("NUTATION");
      s.fourth = f.number("NUTATION_PER");
      s.fifth = f.number("NUTATION_PHASE");
    }
    if (!v1 && f.all_or_none({"MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"})) {
      if (s.model == Spin::Model::nutation) {
        throw InputError(f.where("MOMENTUM_ALPHA"),
                         "a SPIN block has either NUTATION, … or MOMENTUM_ALPHA, …, not both");
      }
      s.model = Spin::Model::momentum;
      s.third = f.number("MOMENTUM_ALPHA");
      s.fourth = f.number("MOMENTUM_DELTA");
      s.fifth = f.number("NUTATION_VEL");
    }
    const auto [q, omega] = spin_kinematics(s);
    k.q_start_from_end = q;
    k.omega_end_rad_s = omega;
    out_.body.attitudes.push_back(stated(k, "SPIN"));
  }

  void read_apm_inertia(const CcsdsBlock& block, bool v1) {
    const CcsdsFields f =
        fields(block, v1 ? std::span<const CcsdsRule>(inertia_rules_v1) : std::span<const CcsdsRule>(inertia_rules));
    if (v1) {
      set_inertia(f, {"I11", "I22", "I33", "I12", "I13", "I23"});
    } else {
      set_inertia(f, {"IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"});
    }
  }

  void set_inertia(const CcsdsFields& f, const std::array<std::string_view, 6>& keys) {
    const Vector3 moments(f.number(keys[0]), f.number(keys[1]), f.number(keys[2]));
    Vector3 products = Vector3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (f.has(keys[k + 3])) products[static_cast<Eigen::Index>(k)] = f.number(keys[k + 3]);
    }
    if (out_.body.inertia) {
      warn(fmt::format("line {}: a further inertia; the first one is used", f.start().line));
      return;
    }
    try {
      out_.body.inertia =
          inertia_from_tensor(inertia_tensor(moments, products, ProductsOfInertia::positive_integrals), true);
    } catch (const InputError& error) {
      throw InputError(f.where(keys[0]), error.what());
    }
    inertia_frame_ = frame_name(f, "INERTIA_REF_FRAME");
    if (products.cwiseAbs().maxCoeff() > 0.0) {
      std::string other;
      try {
        const Vector3 m =
            inertia_from_tensor(inertia_tensor(moments, products, ProductsOfInertia::tensor_elements), true)
                .principal_moments;
        other = fmt::format(
            "; taken as tensor elements instead, as Orekit does, the principal moments would be {:.10g}, {:.10g}, "
            "{:.10g}",
            m[0], m[1], m[2]);
      } catch (const InputError&) {
        other.clear();
      }
      note(fmt::format(
          "products of inertia are read as integrals of xy dm, the tensor holds -{} (CCSDS 504.0-B-2 annex F6){}",
          keys[3], other));
    }
  }

  /// The ANGVEL blocks come before the attitudes that they may need (SPIN), hence at the end.
  void apply_angular_velocities() {
    for (const CcsdsBlock& block : angular_velocities_) {
      const CcsdsFields f(block, angvel_rules, block_name(block), file_);
      const std::string a = frame_name(f, "REF_FRAME_A");
      const std::string b = frame_name(f, "REF_FRAME_B");
      const std::string c = frame_name(f, "ANGVEL_FRAME");
      const Vector3 omega = degree * Vector3(f.number("ANGVEL_X"), f.number("ANGVEL_Y"), f.number("ANGVEL_Z"));
      bool used = false;
      for (StatedAttitude& s : out_.body.attitudes) {
        const bool same = same_frame(s.frame, a) && same_frame(s.body, b);
        const bool turned = same_frame(s.frame, b) && same_frame(s.body, a);
        if (!same && !turned) continue;
        // Of B relative to A; of the body relative to the frame it is the opposite if the body is A.
        const double sign = same ? 1.0 : -1.0;
        Vector3 of_body = sign * omega;
        if (same_frame(c, s.frame) || c == (same ? "REF_FRAME_A" : "REF_FRAME_B")) {
          of_body = s.q_frame_from_body.conjugate() * of_body;
        } else if (!same_frame(c, s.body) && c != (same ? "REF_FRAME_B" : "REF_FRAME_A")) {
          continue;
        }
        if (s.omega_body_rad_s && !of_body.isApprox(*s.omega_body_rad_s, 1e-3)) {
          warn(
              fmt::format("line {}: the ANGVEL block and the rates of the {} block differ by {:.3g} deg/s; the ANGVEL "
                          "block is used",
                          block.line, s.block, (of_body - *s.omega_body_rad_s).norm() / degree));
        }
        s.omega_body_rad_s = of_body;
        used = true;
      }
      if (!used) {
        warn(fmt::format(
            "line {}: the angular velocity of {} relative to {} in {} fits no attitude of the message; not used",
            block.line, b, a, c));
      }
    }
  }

  /// The initial state: the first attitude that can be one, completed by the rate of another between the same frames.
  void choose_state(Instant epoch_time) {
    const auto score = [&](const StatedAttitude& s) {
      const bool fits = inertia_frame_.empty() || same_frame(s.body, inertia_frame_);
      return (s.known_frame ? 4 : 0) + (fits ? 2 : 0);
    };
    const StatedAttitude* best = nullptr;
    for (const StatedAttitude& s : out_.body.attitudes) {
      if (best == nullptr || score(s) > score(*best)) best = &s;
    }
    if (best == nullptr) {
      if (!angular_velocities_.empty()) {
        throw InputError({file_, angular_velocities_[0].line},
                         "an angular velocity, but no attitude (QUAT, EULER or SPIN block) that it belongs to");
      }
      require("an attitude (QUAT, EULER or SPIN block)");
      require_rate_and_inertia(false);
      return;
    }
    std::optional<Vector3> omega = best->omega_body_rad_s;
    for (const StatedAttitude& s : out_.body.attitudes) {
      if (&s == best || !same_frame(s.frame, best->frame) || !same_frame(s.body, best->body)) continue;
      const double apart = rotation_angle_rad(s.q_frame_from_body, best->q_frame_from_body);
      if (apart > 1e-3) {
        warn(fmt::format("the {} and {} blocks give attitudes that are {:.4g} deg apart; the first is used",
                         best->block, s.block, apart / degree));
      }
      if (!omega) omega = s.omega_body_rad_s;
    }
    set_state(*best, omega, epoch_time);
  }

  void set_state(const StatedAttitude& attitude, const std::optional<Vector3>& omega, Instant epoch_time) {
    if (!attitude.known_frame) {
      require(fmt::format("an attitude in an inertial frame ({} in {} is given)", attitude.body, attitude.frame));
    } else if (!clock_.known) {
      require(fmt::format("a time system that relates to UTC ({} is given)", clock_.name));
    } else {
      SpinState state;
      state.epoch = epoch_time;
      state.epoch_scale = clock_.scale;
      state.frame = *attitude.known_frame;
      state.q_frame_from_named = attitude.q_frame_from_body;
      state.omega_named_rad_s = omega;
      out_.body.state = state;
    }
    if (out_.body.inertia && !inertia_frame_.empty() && !same_frame(inertia_frame_, attitude.body)) {
      require(fmt::format("the inertia and the attitude in the same axes (inertia in {}, attitude of {})",
                          inertia_frame_, attitude.body));
    } else if (out_.body.inertia && inertia_frame_.empty()) {
      warn(fmt::format("no INERTIA_REF_FRAME: the inertia is taken in the axes {}", attitude.body));
    }
    require_rate_and_inertia(omega.has_value());
  }

  void require_rate_and_inertia(bool has_rate) {
    if (!has_rate) require("an angular velocity");
    if (!out_.body.inertia) require("an inertia");
  }
  void require(std::string what) { out_.body.missing.push_back(std::move(what)); }

  // --- AEM

  void read_aem() {
    AttitudeHistory history;
    std::string id;
    for (const CcsdsSegment& segment : in_.segments) {
      check_no_rows(segment.metadata);
      const CcsdsFields f(
          segment.metadata,
          v1_ ? std::span<const CcsdsRule>(aem_metadata_rules_v1) : std::span<const CcsdsRule>(aem_metadata_rules),
          "the metadata of " + message_name(), file_);
      set_clock(f);
      if (history.segments.empty()) {
        out_.body.name = f.text("OBJECT_NAME");
        id = f.normal("OBJECT_ID");
        history.object = out_.body.name;
        out_.body.id = f.text("OBJECT_ID");
        history.object_id = out_.body.id;
        history.scale = clock_.scale;
        history.absolute_time = clock_.known;
      } else if (f.normal("OBJECT_ID") != id) {
        throw InputError(f.where("OBJECT_ID"), fmt::format("OBJECT_ID = {}: an AEM is about a single object, {} above",
                                                           f.text("OBJECT_ID"), id));
      }
      history.segments.push_back(aem_segment(f, aem_rows(segment)));
    }
    finish_history(std::move(history));
  }

  const CcsdsBlock& aem_rows(const CcsdsSegment& segment) const {
    if (segment.data.blocks.size() != 1 || segment.data.blocks[0].name != "DATA") {
      for (const CcsdsBlock& b : segment.data.blocks) {
        if (b.name != "DATA")
          throw InputError({file_, b.line}, fmt::format("{} has no block {}", message_name(), b.name));
      }
      throw InputError({file_, segment.data.blocks.size() > 1 ? segment.data.blocks[1].line : segment.metadata.line},
                       "each META block of an AEM is followed by one DATA block");
    }
    const CcsdsBlock& block = segment.data.blocks[0];
    if (!block.entries.empty()) {
      throw InputError({file_, block.entries[0].line},
                       fmt::format("the keyword {} between the data lines", block.entries[0].keyword));
    }
    if (block.rows.empty()) throw InputError({file_, block.line}, "the DATA block has no data lines");
    return block;
  }

  /// The columns of a data line after its epoch: table 4-4, version 1 included.
  static std::vector<std::string_view> columns(std::string_view type) {
    static constexpr std::array<std::string_view, 4> q{"Q1", "Q2", "Q3", "QC"};
    static constexpr std::array<std::string_view, 3> e{"ANGLE_1", "ANGLE_2", "ANGLE_3"};
    static constexpr std::array<std::string_view, 4> s{"SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL"};
    std::vector<std::string_view> list;
    const auto add = [&list](std::initializer_list<std::string_view> more) { list.insert(list.end(), more); };
    if (type.starts_with("QUATERNION")) list.assign(q.begin(), q.end());
    if (type.starts_with("EULER_ANGLE")) list.assign(e.begin(), e.end());
    if (type.starts_with("SPIN")) list.assign(s.begin(), s.end());
    if (type == "QUATERNION/DERIVATIVE") add({"Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"});
    if (type == "QUATERNION/RATE" || type == "EULER_ANGLE/RATE" || type == "EULER_ANGLE/DERIVATIVE") {
      add({"ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"});
    }
    if (type.ends_with("/ANGVEL")) add({"ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"});
    if (type == "SPIN/NUTATION") add({"NUTATION", "NUTATION_PER", "NUTATION_PHASE"});
    if (type == "SPIN/NUTATION_MOM") add({"MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"});
    return list;
  }

  /// What a segment's metadata say about its rows.
  struct RowFormat {
    std::string type;
    std::vector<std::string_view> columns;
    bool scalar_first = false;
    std::optional<EulerSequence> axes;
    std::string start, end;  // frames, in the direction of the rotation
    enum class Rate { none, in_end, in_start } angular_velocity = Rate::none;
  };

  RowFormat row_format(const CcsdsFields& f) {
    RowFormat r;
    r.type = f.normal("ATTITUDE_TYPE");
    Kinematics ends;
    set_ends(ends, f, "REF_FRAME_A", "REF_FRAME_B", v1_ ? "ATTITUDE_DIR" : "");
    r.start = ends.start;
    r.end = ends.end;
    r.columns = columns(r.type);
    const bool of_v1 = r.type == "QUATERNION/RATE" || r.type == "EULER_ANGLE/RATE";
    const bool of_v2 =
        r.type.ends_with("/ANGVEL") || r.type == "EULER_ANGLE/DERIVATIVE" || r.type == "SPIN/NUTATION_MOM";
    const std::size_t line = f.entry("ATTITUDE_TYPE").line;
    if (!v1_ && of_v1)
      throw InputError({file_, line}, fmt::format("ATTITUDE_TYPE = {} was removed in version 2", r.type));
    if (v1_ && of_v2)
      warn(fmt::format("line {}: ATTITUDE_TYPE = {} of version 2 under a header of version 1", line, r.type));
    if (v1_ && r.type.starts_with("QUATERNION")) {
      if (!f.has("QUATERNION_TYPE")) f.missing("QUATERNION_TYPE");
      r.scalar_first = f.normal("QUATERNION_TYPE") == "FIRST";
    }
    if (f.has("EULER_ROT_SEQ")) r.axes = euler_sequence(f);
    if (r.type.starts_with("EULER_ANGLE") && !r.axes) f.missing("EULER_ROT_SEQ");
    if (of_v1) {
      if (!f.has("RATE_FRAME")) f.missing("RATE_FRAME");
      const std::string frame = f.normal("RATE_FRAME");
      if (frame != "REF_FRAME_A" && frame != "REF_FRAME_B") {
        throw InputError(f.where("RATE_FRAME"),
                         fmt::format("RATE_FRAME = {}: REF_FRAME_A or REF_FRAME_B is wanted", f.text("RATE_FRAME")));
      }
      if (r.axes) {
        warn_v1_rates();
      } else {
        r.angular_velocity = same_frame(f.text(frame), r.end) ? RowFormat::Rate::in_end : RowFormat::Rate::in_start;
        warn("QUATERNION/RATE without EULER_ROT_SEQ: the rates are read as the angular velocity in RATE_FRAME");
      }
    } else if (!v1_ && f.has("RATE_FRAME")) {
      warn(fmt::format("line {}: RATE_FRAME belongs to version 1; ignored", f.entry("RATE_FRAME").line));
    }
    if (r.type.ends_with("/ANGVEL")) {
      std::string frame = f.text("ANGVEL_FRAME");
      if (frame == "REF_FRAME_A" || frame == "REF_FRAME_B") frame = f.text(frame);
      if (frame.empty()) {
        warn(fmt::format("line {}: angular velocities without ANGVEL_FRAME; not used", line));
      } else if (same_frame(frame, r.end)) {
        r.angular_velocity = RowFormat::Rate::in_end;
      } else if (same_frame(frame, r.start)) {
        r.angular_velocity = RowFormat::Rate::in_start;
      } else {
        warn(fmt::format("line {}: ANGVEL_FRAME = {} is neither of the two frames; the rates are not used",
                         f.entry("ANGVEL_FRAME").line, frame));
      }
    }
    return r;
  }

  /// A row's numbers by the names of its columns, and its epoch's text.
  std::vector<double> row_numbers(const CcsdsRow& row, const RowFormat& format, std::string& epoch_text) const {
    const SourceLocation at{file_, row.line};
    std::vector<double> numbers;
    if (!row.cells.empty() && !row.cells[0].keyword.empty()) {  // XML: by name
      CcsdsBlock block;
      block.name = "attitudeState";
      block.line = row.line;
      block.entries = row.cells;
      if (v1_ && format.axes) {
        block.entries.push_back({"EULER_ROT_SEQ", format.axes->name(), "", row.line});
        rename_v1_angles(block);
        block.entries.pop_back();
      }
      std::vector<CcsdsRule> rules{{"EPOCH", required, epoch}};
      for (const std::string_view c : format.columns) rules.push_back({c, required, number, unit_of(c)});
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

  static std::string_view unit_of(std::string_view column) {
    if (column.starts_with("Q")) return column.ends_with("_DOT") ? "1/s" : "";
    if (column == "NUTATION_PER") return "s";
    return column.ends_with("_DOT") || column.ends_with("_VEL") || column.starts_with("ANGVEL") ? "deg/s" : "deg";
  }

  StatedAttitude row_attitude(const std::vector<double>& n, const RowFormat& format, const SourceLocation& at) const {
    Kinematics k{format.start, format.end, {}, {}};
    const auto three = [&n](std::size_t i) { return Vector3(degree * n[i], degree * n[i + 1], degree * n[i + 2]); };
    if (format.type.starts_with("SPIN")) {
      Spin s{n[0], n[1], n[2], n[3]};
      if (n.size() == 7) {
        s.model = format.type == "SPIN/NUTATION" ? Spin::Model::nutation : Spin::Model::momentum;
        s.third = n[4];
        s.fourth = n[5];
        s.fifth = n[6];
        if (s.model == Spin::Model::nutation && s.fourth == 0.0) throw InputError(at, "NUTATION_PER is 0");
      }
      const auto [q, omega] = spin_kinematics(s);
      k.q_start_from_end = q;
      k.omega_end_rad_s = omega;
    } else if (format.type.starts_with("EULER_ANGLE")) {
      k.q_start_from_end = q_frame_from_body(*format.axes, three(0));
      if (format.type.ends_with("/RATE") || format.type.ends_with("/DERIVATIVE"))
        k.omega_end_rad_s = omega_body_rad_s(*format.axes, three(0), three(3));
    } else {
      k.q_start_from_end = ccsds_quaternion({n[0], n[1], n[2], n[3]}, at);
      if (format.type == "QUATERNION/DERIVATIVE")
        k.omega_end_rad_s = omega_from_derivative(k.q_start_from_end, {n[4], n[5], n[6], n[7]});
      if (format.type == "QUATERNION/RATE" && format.axes) {
        k.omega_end_rad_s =
            omega_body_rad_s(*format.axes, euler_angles_rad(*format.axes, k.q_start_from_end), three(4));
      }
    }
    // Of B relative to A in the direction of the rotation, whose components may be given in either.
    if (format.angular_velocity != RowFormat::Rate::none) {
      const Vector3 omega = three(n.size() - 3);
      k.omega_end_rad_s =
          format.angular_velocity == RowFormat::Rate::in_end ? omega : Vector3(k.q_start_from_end.conjugate() * omega);
    }
    if (k.omega_end_rad_s && !k.omega_end_rad_s->allFinite())
      throw InputError(at, "the rates give no finite angular velocity");
    return stated(k, "ATT");
  }

  AttitudeSegment aem_segment(const CcsdsFields& f, const CcsdsBlock& block) {
    const RowFormat format = row_format(f);
    AttitudeSegment segment;
    const Instant start = clock_.date(f.text("START_TIME"), f.where("START_TIME"));
    const Instant stop = clock_.date(f.text("STOP_TIME"), f.where("STOP_TIME"));
    if (stop < start) throw InputError(f.where("STOP_TIME"), "STOP_TIME is before START_TIME");
    if (f.has("USEABLE_START_TIME"))
      segment.usable_start = clock_.date(f.text("USEABLE_START_TIME"), f.where("USEABLE_START_TIME"));
    if (f.has("USEABLE_STOP_TIME"))
      segment.usable_stop = clock_.date(f.text("USEABLE_STOP_TIME"), f.where("USEABLE_STOP_TIME"));
    if (segment.usable_start && segment.usable_stop && *segment.usable_stop < *segment.usable_start) {
      throw InputError(f.where("USEABLE_STOP_TIME"), "USEABLE_STOP_TIME is before USEABLE_START_TIME");
    }
    if (segment.usable_start && (*segment.usable_start < start || stop < *segment.usable_start)) {
      throw InputError(f.where("USEABLE_START_TIME"), "USEABLE_START_TIME is outside of START_TIME to STOP_TIME");
    }
    if (segment.usable_stop && (*segment.usable_stop < start || stop < *segment.usable_stop)) {
      throw InputError(f.where("USEABLE_STOP_TIME"), "USEABLE_STOP_TIME is outside of START_TIME to STOP_TIME");
    }
    for (const CcsdsRow& row : block.rows) {
      const SourceLocation at{file_, row.line};
      std::string epoch_text;
      const std::vector<double> numbers = row_numbers(row, format, epoch_text);
      const StatedAttitude a = row_attitude(numbers, format, at);
      const AttitudeSample sample{clock_.date(epoch_text, at), a.q_frame_from_body, a.omega_body_rad_s};
      check_order(segment, sample, at, epoch_text);
      // Real files round the span and the rows differently; a second more is another matter.
      if ((start - sample.time).high >= 1.0 || (sample.time - stop).high >= 1.0) {
        throw InputError(at, fmt::format("{} is outside of START_TIME to STOP_TIME", epoch_text));
      }
      segment.frame = a.frame;
      segment.body = a.body;
      segment.known_frame = a.known_frame;
      segment.samples.push_back(sample);
    }
    if ((segment.samples.front().time - start).high > 1.0 || (stop - segment.samples.back().time).high > 1.0) {
      warn(fmt::format("line {}: the data lines do not reach from START_TIME to STOP_TIME", block.line));
    }
    set_interpolation(segment, f);
    return segment;
  }

  void check_order(const AttitudeSegment& segment, const AttitudeSample& sample, const SourceLocation& at,
                   std::string_view epoch_text) const {
    if (!segment.samples.empty() && !(segment.samples.back().time < sample.time)) {
      throw InputError(at, fmt::format("time {} is not after the one above; times increase", epoch_text));
    }
  }

  void set_interpolation(AttitudeSegment& segment, const CcsdsFields& f) {
    const bool rates = segment.has_rates();
    segment.method = rates ? AttitudeInterpolation::hermite : AttitudeInterpolation::linear;
    segment.degree = rates ? 3 : 1;
    if (!f.has("INTERPOLATION_METHOD")) {
      if (f.has("INTERPOLATION_DEGREE")) warn("INTERPOLATION_DEGREE without INTERPOLATION_METHOD; not used");
      return;
    }
    const std::string method = f.normal("INTERPOLATION_METHOD");
    const std::size_t line = f.entry("INTERPOLATION_METHOD").line;
    if (method != "LINEAR" && method != "LAGRANGE" && method != "HERMITE") {
      warn(fmt::format("line {}: INTERPOLATION_METHOD = {} is none of LINEAR, LAGRANGE, HERMITE; {} is used", line,
                       method, name(segment.method)));
      return;
    }
    if (!f.has("INTERPOLATION_DEGREE") && method != "LINEAR") {
      throw InputError({file_, line}, "INTERPOLATION_DEGREE is missing: it goes with INTERPOLATION_METHOD");
    }
    segment.method = method == "LINEAR"
                         ? AttitudeInterpolation::linear
                         : (method == "LAGRANGE" ? AttitudeInterpolation::lagrange : AttitudeInterpolation::hermite);
    segment.degree = f.has("INTERPOLATION_DEGREE") ? static_cast<int>(f.number("INTERPOLATION_DEGREE")) : 1;
    segment.method_stated = true;
    const std::size_t per_row = rates && segment.method == AttitudeInterpolation::hermite ? 2 : 1;
    const std::size_t needed = (static_cast<std::size_t>(segment.degree) + per_row) / per_row;
    if (segment.method != AttitudeInterpolation::linear && segment.samples.size() < needed) {
      warn(fmt::format("line {}: {} rows are too few for {} of degree {}; the degree is reduced", line,
                       segment.samples.size(), method, segment.degree));
    }
    if (segment.method == AttitudeInterpolation::hermite && !rates) {
      warn(fmt::format("line {}: HERMITE without rates is the same as LAGRANGE", line));
    }
  }

  /// The first row that has a rate, else the first row, is the state.
  void finish_history(AttitudeHistory history) {
    const AttitudeSegment* chosen = nullptr;
    const auto score = [&](const AttitudeSegment& s) {
      const bool fits = inertia_frame_.empty() || same_frame(s.body, inertia_frame_);
      return (s.known_frame ? 4 : 0) + (fits ? 2 : 0) + (s.samples.front().omega_body_rad_s ? 1 : 0);
    };
    for (const AttitudeSegment& s : history.segments) {
      if (chosen == nullptr || score(s) > score(*chosen)) chosen = &s;
    }
    if (chosen != nullptr) {
      const AttitudeSample& row = chosen->samples.front();
      const StatedAttitude a{
          "ATT", chosen->frame, chosen->body, chosen->known_frame, row.q_frame_from_body, row.omega_body_rad_s};
      out_.body.attitudes.push_back(a);
      set_state(a, row.omega_body_rad_s, row.time);
    } else {
      require("an attitude (ATT block)");
      require_rate_and_inertia(false);
    }
    history.source = out_.body.source;
    history.warnings = out_.body.warnings;
    if (!history.segments.empty()) out_.history = std::move(history);
  }

  // --- ACM

  void read_acm(const CcsdsSegment& segment) {
    check_no_rows(segment.metadata);
    const CcsdsFields metadata(segment.metadata, acm_metadata_rules, "the metadata of " + message_name(), file_);
    set_clock(metadata);
    out_.body.name = metadata.text("OBJECT_NAME");
    clock_.zero = clock_.date(metadata.text("EPOCH_TZERO"), metadata.where("EPOCH_TZERO"));
    if (metadata.has("NEXT_LEAP_EPOCH"))
      clock_.date(metadata.text("NEXT_LEAP_EPOCH"), metadata.where("NEXT_LEAP_EPOCH"));
    if (metadata.has("START_TIME") && metadata.has("STOP_TIME") &&
        acm_time(metadata.text("STOP_TIME"), metadata.where("STOP_TIME")) <
            acm_time(metadata.text("START_TIME"), metadata.where("START_TIME"))) {
      throw InputError(metadata.where("STOP_TIME"), "STOP_TIME is before START_TIME");
    }
    const CcsdsBlock& data = segment.data;
    if (!data.entries.empty()) {
      throw InputError({file_, data.entries[0].line},
                       fmt::format("the keyword {} stands outside of any block", data.entries[0].keyword));
    }
    check_data_elements(metadata, data);

    constexpr std::array<std::string_view, 6> order{"ATT", "PHYS", "COV", "MAN", "AD", "USER"};
    std::size_t last = 0;
    bool last_is_single = false;
    AttitudeHistory history;
    history.object = out_.body.name;
    out_.body.id = metadata.text("INTERNATIONAL_DESIGNATOR");
    if (out_.body.id.empty()) out_.body.id = metadata.text("OBJECT_DESIGNATOR");
    history.object_id = out_.body.id;
    history.scale = clock_.scale;
    history.absolute_time = clock_.known;
    std::size_t covariances = 0;
    std::size_t manoeuvres = 0;
    for (const CcsdsBlock& block : data.blocks) {
      const auto* const place = std::find(order.begin(), order.end(), block.name);
      const auto index = static_cast<std::size_t>(place - order.begin());
      if (place == order.end())
        throw InputError({file_, block.line}, fmt::format("{} has no block {}", message_name(), block.name));
      if (index < last) {
        throw InputError(
            {file_, block.line},
            fmt::format("the {} block comes after the {} block; their order is ATT, PHYS, COV, MAN, AD, USER",
                        block.name, order[last]));
      }
      if (index == last && last_is_single)
        throw InputError({file_, block.line}, fmt::format("a second {} block; there is at most one", block.name));
      last = index;
      last_is_single = block.name == "PHYS" || block.name == "AD" || block.name == "USER";
      if (block.name == "ATT") {
        history.segments.push_back(acm_segment(block));
      } else if (block.name == "PHYS") {
        read_phys(block);
      } else if (block.name == "COV") {
        read_cov(block);
        ++covariances;
      } else if (block.name == "MAN") {
        read_acm_man(block);
        ++manoeuvres;
      } else if (block.name == "AD") {
        read_ad(block);
      } else {
        fields(block, user_rules);
        note("user-defined parameters are left out");
      }
    }
    if (covariances > 0) note(fmt::format("covariance histories: {}, checked and left out", covariances));
    if (manoeuvres > 0) note(fmt::format("manoeuvres: {}, checked and left out", manoeuvres));
    finish_history(std::move(history));
  }

  void check_data_elements(const CcsdsFields& metadata, const CcsdsBlock& data) const {
    if (!metadata.has("ACM_DATA_ELEMENTS")) return;
    std::string listed;
    for (const char c : upper_case(metadata.text("ACM_DATA_ELEMENTS"))) listed += c == ',' ? ' ' : c;
    std::string found;
    for (const CcsdsBlock& b : data.blocks) found += (found.empty() ? "" : ", ") + b.name;
    std::string wanted;
    for (const std::string_view w : split_words(listed)) wanted += (wanted.empty() ? "" : ", ") + std::string(w);
    if (wanted != found) {
      throw InputError(metadata.where("ACM_DATA_ELEMENTS"), fmt::format("ACM_DATA_ELEMENTS = {}, but the blocks are {}",
                                                                        wanted, found.empty() ? "none" : found));
    }
  }

  bool is_relative(std::string_view text) const { return parse_number(text).has_value(); }

  Instant acm_time(std::string_view text, const SourceLocation& at) const {
    const std::optional<double> seconds = parse_number(text);
    if (!seconds) return clock_.date(text, at);
    if (std::abs(*seconds) > 1e12) throw InputError(at, fmt::format("{} seconds from EPOCH_TZERO", text));
    return *clock_.zero + Seconds{*seconds, 0.0};
  }

  /// The times of a block's rows: increasing, and all of one kind.
  Instant row_time(const CcsdsBlock& block, std::size_t index, const std::optional<Instant>& above) const {
    const CcsdsRow& row = block.rows[index];
    const SourceLocation at{file_, row.line};
    const std::string& text = row.cells[0].value;
    if (is_relative(text) != is_relative(block.rows[0].cells[0].value)) {
      throw InputError(at,
                       fmt::format("time {}: relative and absolute times are mixed in {}", text, block_name(block)));
    }
    const Instant t = acm_time(text, at);
    if (above && !(*above < t))
      throw InputError(at, fmt::format("time {} is not after the one above; times increase", text));
    return t;
  }

  void check_width(const CcsdsBlock& block, const CcsdsRow& row, std::size_t numbers) const {
    if (row.cells.size() != numbers + 1) {
      throw InputError({file_, row.line}, fmt::format("{} words; a line of {} has a time and {} numbers",
                                                      row.cells.size(), block_name(block), numbers));
    }
  }

  AttitudeSegment acm_segment(const CcsdsBlock& block) {
    const CcsdsFields f(block, att_rules, block_name(block), file_);
    const std::string attitude = f.normal("ATT_TYPE");
    const std::string rate = f.has("RATE_TYPE") ? f.normal("RATE_TYPE") : "NONE";
    const std::size_t first = attitude == "QUATERNION" ? 4 : (attitude == "DCM" ? 9 : 3);
    const std::size_t second = rate == "NONE" ? 0 : (rate == "Q_DOT" ? 4 : 3);
    if (static_cast<std::size_t>(f.number("NUMBER_STATES")) != first + second) {
      throw InputError(f.where("NUMBER_STATES"), fmt::format("NUMBER_STATES = {}, but {} with rate {} has {}",
                                                             f.text("NUMBER_STATES"), attitude, rate, first + second));
    }
    std::optional<EulerSequence> axes;
    if (f.has("EULER_ROT_SEQ")) axes = euler_sequence(f);
    if ((attitude == "EULER_ANGLES" || rate == "EULER_RATE") && !axes) f.missing("EULER_ROT_SEQ");
    Kinematics k;
    set_ends(k, f, "REF_FRAME_A", "REF_FRAME_B", "");
    if (rate == "GYRO_BIAS") note(fmt::format("line {}: GYRO_BIAS is a correction, not a rate; left out", block.line));
    if (attitude == "DCM" && rate == "Q_DOT") {
      warn(fmt::format("line {}: Q_DOT with a matrix leaves the quaternion's sign open; QC >= 0 is assumed",
                       block.line));
    }
    if (block.rows.empty())
      throw InputError({file_, block.line}, fmt::format("{} has no data lines", block_name(block)));
    AttitudeSegment segment;
    std::optional<Instant> above;
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      const CcsdsRow& row = block.rows[i];
      const SourceLocation at{file_, row.line};
      check_width(block, row, first + second);
      above = row_time(block, i, above);
      std::vector<double> n;
      for (std::size_t c = 1; c < row.cells.size(); ++c) n.push_back(ccsds_number(row.cells[c].value, at));
      Vector3 angles = Vector3::Zero();
      if (attitude == "QUATERNION") {
        k.q_start_from_end = ccsds_quaternion({n[0], n[1], n[2], n[3]}, at);
      } else if (attitude == "EULER_ANGLES") {
        angles = degree * Vector3(n[0], n[1], n[2]);
        k.q_start_from_end = q_frame_from_body(*axes, angles);
      } else {
        k.q_start_from_end = from_columns(n, at);
      }
      const auto vector = [&](std::size_t c) { return Vector3(degree * n[c], degree * n[c + 1], degree * n[c + 2]); };
      if (rate == "ANGVEL") k.omega_end_rad_s = vector(first);
      if (rate == "Q_DOT")
        k.omega_end_rad_s =
            omega_from_derivative(k.q_start_from_end, {n[first], n[first + 1], n[first + 2], n[first + 3]});
      if (rate == "EULER_RATE") {
        if (attitude != "EULER_ANGLES") angles = euler_angles_rad(*axes, k.q_start_from_end);
        k.omega_end_rad_s = omega_body_rad_s(*axes, angles, vector(first));
      }
      if (k.omega_end_rad_s && !k.omega_end_rad_s->allFinite())
        throw InputError(at, "the rates give no finite angular velocity");
      const StatedAttitude a = stated(k, "ATT");
      segment.frame = a.frame;
      segment.body = a.body;
      segment.known_frame = a.known_frame;
      segment.samples.push_back({*above, a.q_frame_from_body, a.omega_body_rad_s});
    }
    const bool rates = segment.has_rates();
    segment.method = rates ? AttitudeInterpolation::hermite : AttitudeInterpolation::linear;
    segment.degree = rates ? 3 : 1;
    return segment;
  }

  /// The transformation matrix of B from A, column by column (504.0-B-2 annex B4): X_B = M X_A.
  static Quaternion from_columns(const std::vector<double>& n, const SourceLocation& at) {
    Matrix3 m;
    for (Eigen::Index i = 0; i < 9; ++i) m(i % 3, i / 3) = n[static_cast<std::size_t>(i)];
    const double fault = (m * m.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff();
    if (!(fault <= 2.0 * ccsds_norm_tolerance) || !(m.determinant() > 0.0)) {
      throw InputError(at,
                       fmt::format("the matrix is no rotation (determinant {:.4g}, columns not orthonormal by {:.2g})",
                                   m.determinant(), fault));
    }
    return Quaternion(Matrix3(m.transpose())).normalized();
  }

  void read_phys(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, phys_rules);
    if (f.has("CP_REF_FRAME") && !f.has("CP"))
      throw InputError(f.where("CP_REF_FRAME"), "CP_REF_FRAME is given without CP");
    if (f.has("CP") && !f.has("CP_REF_FRAME"))
      warn(fmt::format("line {}: CP without CP_REF_FRAME", f.entry("CP").line));
    if (f.has("WET_MASS") && f.has("DRY_MASS") && f.number("DRY_MASS") > f.number("WET_MASS")) {
      throw InputError(f.where("DRY_MASS"), "DRY_MASS is larger than WET_MASS");
    }
    if (f.all_or_none({"IXX", "IYY", "IZZ"})) {
      set_inertia(f, {"IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"});
      if (!f.all_or_none({"IXY", "IXZ", "IYZ"})) warn("no products of inertia are given; they are taken as 0");
    } else if (f.has("IXY") || f.has("IXZ") || f.has("IYZ")) {
      f.missing("IXX");
    }
  }

  void read_cov(const CcsdsBlock& block) {
    const CcsdsFields f(block, cov_rules, block_name(block), file_);
    const std::string type = f.normal("COV_TYPE");
    const std::size_t numbers = (type.starts_with("ANGLE") ? 3 : 4) + (type.find('_') != std::string::npos ? 3 : 0);
    frame_name(f, "COV_REF_FRAME");
    if (block.rows.empty())
      throw InputError({file_, block.line}, fmt::format("{} has no data lines", block_name(block)));
    std::optional<Instant> above;
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      const CcsdsRow& row = block.rows[i];
      check_width(block, row, numbers);
      above = row_time(block, i, above);
      for (std::size_t c = 1; c < row.cells.size(); ++c) {
        if (ccsds_number(row.cells[c].value, {file_, row.line}) < 0.0) {
          throw InputError({file_, row.line}, fmt::format("variance {} is negative", row.cells[c].value));
        }
      }
    }
  }

  void read_acm_man(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, acm_man_rules);
    if (f.has("MAN_END_TIME") && f.has("MAN_DURATION")) {
      throw InputError(f.where("MAN_DURATION"), "either MAN_END_TIME or MAN_DURATION is given, not both");
    }
    if (!f.has("MAN_END_TIME") && !f.has("MAN_DURATION")) f.missing("MAN_END_TIME (or MAN_DURATION)");
    const Instant begin = acm_time(f.text("MAN_BEGIN_TIME"), f.where("MAN_BEGIN_TIME"));
    if (f.has("MAN_END_TIME") && acm_time(f.text("MAN_END_TIME"), f.where("MAN_END_TIME")) < begin) {
      throw InputError(f.where("MAN_END_TIME"), "MAN_END_TIME is before MAN_BEGIN_TIME");
    }
    if (f.has("TARGET_MOM_FRAME") && !f.has("TARGET_MOMENTUM")) {
      throw InputError(f.where("TARGET_MOM_FRAME"), "TARGET_MOM_FRAME is given without TARGET_MOMENTUM");
    }
    if (f.has("TARGET_MOMENTUM") && !f.has("TARGET_MOM_FRAME")) {
      warn(fmt::format("line {}: TARGET_MOMENTUM without TARGET_MOM_FRAME", f.entry("TARGET_MOMENTUM").line));
    }
  }

  void read_ad(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, ad_rules);
    const bool has_rate = f.has("RATE_STATES") && f.normal("RATE_STATES") != "NONE";
    if (has_rate && f.has("NUMBER_STATES") && f.number("NUMBER_STATES") < 6.0) {
      throw InputError(f.where("NUMBER_STATES"),
                       fmt::format("NUMBER_STATES = {}; with rates there are at least 6", f.text("NUMBER_STATES")));
    }
    if (f.normal("ATTITUDE_STATES") == "EULER_ANGLES" && !f.has("EULER_ROT_SEQ")) f.missing("EULER_ROT_SEQ");
    std::vector<std::pair<double, std::size_t>> numbers_used;
    for (const CcsdsBlock& sensor : block.blocks) {
      const CcsdsFields s = fields(sensor, sensor_rules);
      const double index = s.number("SENSOR_NUMBER");
      for (const auto& [used, line] : numbers_used) {
        if (used == index)
          throw InputError(s.where("SENSOR_NUMBER"),
                           fmt::format("SENSOR_NUMBER {} is already used on line {}", index, line));
      }
      numbers_used.emplace_back(index, s.entry("SENSOR_NUMBER").line);
      const std::size_t deviations = s.has("SENSOR_NOISE_STDDEV") ? s.numbers("SENSOR_NOISE_STDDEV").size() : 0;
      if (s.has("NUMBER_SENSOR_NOISE_COVARIANCE") &&
          s.number("NUMBER_SENSOR_NOISE_COVARIANCE") != static_cast<double>(deviations)) {
        throw InputError(s.where("NUMBER_SENSOR_NOISE_COVARIANCE"),
                         fmt::format("NUMBER_SENSOR_NOISE_COVARIANCE = {}, but SENSOR_NOISE_STDDEV has {}",
                                     s.text("NUMBER_SENSOR_NOISE_COVARIANCE"), deviations));
      }
    }
    note(fmt::format("attitude determination with {} sensors, checked and left out", block.blocks.size()));
  }

  const CcsdsMessage& in_;
  const std::string& file_;
  CcsdsAttitudeMessage out_;
  bool v1_ = false;
  CcsdsClock clock_;
  std::vector<CcsdsBlock> angular_velocities_;
  std::string inertia_frame_;
};

}  // namespace

std::vector<CcsdsAttitudeMessage> parse_ccsds_attitude(std::string_view text, const std::string& name) {
  const CcsdsFile file = parse_ccsds(text, name);
  std::vector<CcsdsAttitudeMessage> messages;
  for (const CcsdsMessage& m : file.messages) messages.push_back(Reader(m, name).read());
  for (const std::string& other : file.other_messages) {
    messages.front().body.notes.push_back(fmt::format("the file also holds an {}, not read", other));
  }
  return messages;
}

}  // namespace polhode
