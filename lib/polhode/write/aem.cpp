#include "polhode/write/aem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/write/ccsds_lines.hpp"
#include "polhode/write/date_text.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/number_text.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {
namespace {

constexpr std::string_view usual_frame_b = "SC_BODY_1";
constexpr double degrees = 180.0 / std::numbers::pi;

/// A number of a row in XML: its element, and the element around it and its neighbours (empty: none).
struct XmlField {
  std::string_view group;
  std::string_view element;
};

struct Form {
  AemType type;
  std::string_view name;
  std::string_view xml_v1;  ///< element of a row; empty: the version does not have the type
  std::string_view xml_v2;
  std::size_t numbers;
  std::array<XmlField, 8> fields;
  bool euler;
  bool angular_velocity;
};

constexpr XmlField q1{"quaternion", "Q1"}, q2{"quaternion", "Q2"}, q3{"quaternion", "Q3"}, qc{"quaternion", "QC"};
constexpr XmlField a1{"", "ANGLE_1"}, a2{"", "ANGLE_2"}, a3{"", "ANGLE_3"};

// Names of the rows' XML elements: NDM/XML schemas ndmxml-2.0.0 (AEM 1.0) and ndmxml-4.0.0 (AEM 2.0).
constexpr std::array attitude_forms{
    Form{
        AemType::quaternion, "QUATERNION", "quaternionState", "quaternionEphemeris", 4, {q1, q2, q3, qc}, false, false},
    Form{AemType::quaternion_derivative,
         "QUATERNION/DERIVATIVE",
         "quaternionDerivative",
         "quaternionDerivative",
         8,
         {q1,
          q2,
          q3,
          qc,
          {"quaternionDot", "Q1_DOT"},
          {"quaternionDot", "Q2_DOT"},
          {"quaternionDot", "Q3_DOT"},
          {"quaternionDot", "QC_DOT"}},
         false,
         false},
    Form{AemType::quaternion_angular_velocity,
         "QUATERNION/ANGVEL",
         "",
         "quaternionAngVel",
         7,
         {q1, q2, q3, qc, {"angVel", "ANGVEL_X"}, {"angVel", "ANGVEL_Y"}, {"angVel", "ANGVEL_Z"}},
         false,
         true},
    Form{AemType::euler_angle, "EULER_ANGLE", "", "eulerAngle", 3, {a1, a2, a3}, true, false},
    Form{AemType::euler_angle_derivative,
         "EULER_ANGLE/DERIVATIVE",
         "",
         "eulerAngleDerivative",
         6,
         {a1, a2, a3, {"", "ANGLE_1_DOT"}, {"", "ANGLE_2_DOT"}, {"", "ANGLE_3_DOT"}},
         true,
         false},
    Form{AemType::euler_angle_angular_velocity,
         "EULER_ANGLE/ANGVEL",
         "",
         "eulerAngleAngVel",
         6,
         {a1, a2, a3, {"", "ANGVEL_X"}, {"", "ANGVEL_Y"}, {"", "ANGVEL_Z"}},
         true,
         true},
};

const Form& form_of(AemType type) {
  return *std::find_if(attitude_forms.begin(), attitude_forms.end(),
                       [type](const Form& form) { return form.type == type; });
}

/// Whether version 1.0 has the type. Its */RATE types are left out: readers disagree on what their rates are.
bool in_version_1(AemType type) {
  return type == AemType::quaternion || type == AemType::quaternion_derivative || type == AemType::euler_angle;
}

/// The numbers of a row in the units of the standard.
void row_numbers(const AemOptions& options, const AttitudeBlock& block, std::size_t row, double* out) {
  const Form& form = form_of(options.type);
  const double* q = &block.q_frame_from_named[4 * row];
  const Eigen::Map<const Vector3> omega(&block.omega_named_rad_s[3 * row]);
  const Quaternion attitude{q[0], q[1], q[2], q[3]};
  const Vector3 angles_rad = form.euler ? euler_angles_rad(options.euler_sequence, attitude) : Vector3::Zero();
  if (form.euler) {
    for (int k = 0; k < 3; ++k) *out++ = angles_rad[k] * degrees;
  } else {
    for (const int k : {1, 2, 3, 0}) *out++ = std::clamp(q[k], -1.0, 1.0);  // the schema allows no 1 + eps
  }
  if (form.angular_velocity) {
    for (int k = 0; k < 3; ++k) *out++ = omega[k] * degrees;
  } else if (options.type == AemType::quaternion_derivative) {
    const Quaternion derivative =
        attitude * Quaternion(0.0, omega.x(), omega.y(), omega.z());  // dq/dt = q (0, omega)/2
    for (const double component : {derivative.x(), derivative.y(), derivative.z(), derivative.w()})
      *out++ = 0.5 * component;
  } else if (options.type == AemType::euler_angle_derivative) {
    const Vector3 rates = euler_rates_rad_s(options.euler_sequence, angles_rad, omega);
    if (!rates.allFinite()) {
      throw ComputationError(
          fmt::format("{} angles have no derivatives where they are singular, as they are in a row; "
                      "take another sequence or QUATERNION/ANGVEL",
                      options.euler_sequence.name()));
    }
    for (int k = 0; k < 3; ++k) *out++ = rates[k] * degrees;
  }
}

/// "ZXZ", in version 1.0 "313".
std::string sequence_name(const AemOptions& options) {
  std::string name = options.euler_sequence.name();
  if (options.version == AdmVersion::v1) {
    for (char& c : name) c = static_cast<char>('1' + (c - 'X'));
  }
  return name;
}

/// Writes either notation.
class Writer {
 public:
  Writer(const std::string& path, const AemOptions& options, const Progress& progress)
      : bytes_(path), options_(options), form_(form_of(options.type)), progress_(progress) {}

  void begin() {
    const char* version = options_.version == AdmVersion::v1 ? "1.0" : "2.0";
    if (options_.xml) {
      bytes_.write(fmt::format(
          "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<aem xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
          "xsi:noNamespaceSchemaLocation=\"https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-{}.xsd\" "
          "id=\"CCSDS_AEM_VERS\" version=\"{}\">\n<header>\n",
          options_.version == AdmVersion::v1 ? "2.0.0-master-2.0" : "4.0.0-master-4.0", version));
    } else {
      key("CCSDS_AEM_VERS", version);
    }
    comment("Written by " + creator());
    key("CREATION_DATE", creation_date());
    key("ORIGINATOR", "POLHODE");
    bytes_.write(options_.xml ? "</header>\n<body>\n" : "");
  }

  void segment(const Ephemeris& ephemeris) {
    const EphemerisDescription& description = ephemeris.description();
    const TimeGrid& times = ephemeris.times();
    const int decimals = times.decimals();
    const TimeResolution resolution{TimeResolution::Kind::decimals, decimals};
    const auto date = [&](std::size_t row) {
      std::string text;
      DateText(times, decimals).append(text, times.time(row, resolution));
      return text;
    };
    const std::string first = date(0);
    const std::string last = date(times.size() - 1);
    const std::string_view frame_b = description.body_axes.empty() ? usual_frame_b : description.body_axes;
    bytes_.write(options_.xml ? "<segment>\n<metadata>\n" : "\nMETA_START\n");
    comment(
        fmt::format("Frame B is the axes that the body's file names. The quaternion takes components from A to B;"));
    comment("a body turned by +90 deg about z of A has Q1 Q2 Q3 QC = 0 0 0.7071 0.7071.");
    for (const std::string& text : comments_on(description)) comment(text);
    key("OBJECT_NAME", description.object);
    key("OBJECT_ID", description.object_id.empty() ? description.object : description.object_id);
    key("REF_FRAME_A", ephemeris.frame_name());
    key("REF_FRAME_B", frame_b);
    if (options_.version == AdmVersion::v1) key("ATTITUDE_DIR", "A2B");
    key("TIME_SYSTEM", name(times.scale()));
    key("START_TIME", first);
    key("STOP_TIME", last);
    key("ATTITUDE_TYPE", form_.name);
    if (options_.version == AdmVersion::v1 && !form_.euler) key("QUATERNION_TYPE", "LAST");
    if (form_.euler) key("EULER_ROT_SEQ", sequence_name(options_));
    if (form_.angular_velocity) key("ANGVEL_FRAME", frame_b);
    if (!description.ccsds_interpolation.empty()) {
      key("INTERPOLATION_METHOD", description.ccsds_interpolation);
      key("INTERPOLATION_DEGREE", std::to_string(description.ccsds_interpolation_degree));
    }
    bytes_.write(options_.xml ? "</metadata>\n<data>\n" : "META_STOP\n\nDATA_START\n");
    const auto encode = [&](DateText& dates, const AttitudeBlock& block, EncodedBlock& out) {
      out.bytes.clear();
      std::array<double, 8> numbers{};
      for (std::size_t row = 0; row < block.rows; ++row) {
        row_numbers(options_, block, row, numbers.data());
        options_.xml ? xml_row(out.bytes, dates, block.time[row], numbers)
                     : kvn_row(out.bytes, dates, block.time[row], numbers);
      }
    };
    const auto new_encoder = [&]() -> Encoder {
      return [&encode, dates = DateText(times, decimals)](const AttitudeBlock& block, EncodedBlock& out) mutable {
        encode(dates, block, out);
      };
    };
    stream_rows(ephemeris, resolution, new_encoder, [&](const EncodedBlock& block) {
      bytes_.write(block.bytes);
      rows_ += block.rows;
      if (progress_) progress_(rows_);
    });
    bytes_.write(options_.xml ? "</data>\n</segment>\n" : "DATA_STOP\n");
  }

  void end() {
    bytes_.write(options_.xml ? "</body>\n</aem>\n" : "");
    bytes_.commit();
  }

 private:
  void key(std::string_view name, std::string_view value) {
    bytes_.write(options_.xml ? xml_element(name, value) : kvn_line(name, value));
  }
  void comment(const std::string& text) { bytes_.write(options_.xml ? xml_comment(text) : kvn_comment(text)); }

  void kvn_row(std::string& out, DateText& dates, Seconds time, const std::array<double, 8>& numbers) const {
    dates.append(out, time);
    for (std::size_t k = 0; k < form_.numbers; ++k) append_number(out, ' ', numbers[k]);
    out.push_back('\n');
  }

  void xml_row(std::string& out, DateText& dates, Seconds time, const std::array<double, 8>& numbers) const {
    const std::string_view element = options_.version == AdmVersion::v1 ? form_.xml_v1 : form_.xml_v2;
    const auto tag = [&out](std::string_view open, std::string_view name) {
      out.append(open).append(name).push_back('>');
    };
    out += "<attitudeState>";
    tag("<", element);
    out += "<EPOCH>";
    dates.append(out, time);
    out += "</EPOCH>";
    std::string_view group;
    for (std::size_t k = 0; k < form_.numbers; ++k) {
      const XmlField& field = form_.fields[k];
      const std::string_view wanted =
          field.group == "quaternionDot" && options_.version == AdmVersion::v1 ? "quaternionRate" : field.group;
      if (wanted != group) {
        if (!group.empty()) tag("</", group);
        group = wanted;
        if (!group.empty()) tag("<", group);
      }
      out.append("<").append(field.element);
      append_number(out, '>', numbers[k]);
      tag("</", field.element);
    }
    if (!group.empty()) tag("</", group);
    tag("</", element);
    out += "</attitudeState>\n";
  }

  OutputBytes bytes_;
  const AemOptions& options_;
  const Form& form_;
  const Progress& progress_;
  std::size_t rows_ = 0;
};

}  // namespace

AemType aem_type(std::string_view name) {
  const std::string upper = upper_case(name);
  std::string allowed;
  for (const Form& form : attitude_forms) {
    if (upper == form.name) return form.type;
    allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", form.name);
  }
  throw InputError(fmt::format("attitude type '{:.60}' is not one of {}", name, allowed));
}

AdmVersion adm_version(std::string_view name) {
  if (name == "1.0") return AdmVersion::v1;
  if (name == "2.0") return AdmVersion::v2;
  throw InputError(fmt::format("ADM version '{:.60}' is not one of 1.0, 2.0", name));
}

namespace {

/// Readers could not tell which of two segments to take.
void refuse_overlaps(std::span<const Ephemeris> segments) {
  const auto end = [](const Ephemeris& segment, bool last) {
    const TimeGrid& times = segment.times();
    return times.instant(times.time(last ? times.size() - 1 : 0, {}));
  };
  std::vector<std::size_t> order(segments.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return end(segments[a], false) < end(segments[b], false); });
  for (std::size_t i = 1, farthest = 0; i < order.size(); ++i) {
    const Ephemeris &one = segments[order[farthest]], &other = segments[order[i]];
    const Instant begin = end(other, false), stop = std::min(end(one, true), end(other, true));
    const bool twice = begin == end(one, false) && end(one, true) == end(other, true);
    constexpr Seconds rounding{1e-6, 0.0};  // scales round one instant differently
    if (twice || begin + rounding < stop) {
      const TimeScale scale = other.times().scale();
      throw InputError(fmt::format(
          "segments {} and {} both hold from {} to {} {}; segments of an AEM may share an instant at most: let each "
          "span begin where another ends, or later",
          std::min(order[farthest], order[i]) + 1, std::max(order[farthest], order[i]) + 1,
          format_date(begin, scale, 3), format_date(stop, scale, 3), name(scale)));
    }
    if (end(one, true) < end(other, true)) farthest = i;
  }
}

}  // namespace

void write_aem(const std::string& path, std::span<const Ephemeris> segments, const AemOptions& options,
               const Progress& progress) {
  const Form& form = form_of(options.type);
  if (options.version == AdmVersion::v1 && !in_version_1(options.type)) {
    throw InputError(
        fmt::format("attitude type {} is not one that is written as ADM 1.0: QUATERNION, "
                    "QUATERNION/DERIVATIVE, EULER_ANGLE (the rates of its other types are read in two ways)",
                    form.name));
  }
  if (options.version == AdmVersion::v1 && options.xml && form.xml_v1.empty()) {
    throw InputError(fmt::format("{} is written as ADM 1.0 in KVN only", form.name));
  }
  for (const Ephemeris& ephemeris : segments) {
    const TimeScale scale = ephemeris.times().scale();
    if (scale == TimeScale::et) {
      throw TimeScaleError("CCSDS knows no time scale ET; take TDB, or UTC, TAI, TT, GPS");
    }
  }
  refuse_overlaps(segments);
  Writer writer(path, options, progress);
  writer.begin();
  for (const Ephemeris& ephemeris : segments) writer.segment(ephemeris);
  writer.end();
}

}  // namespace polhode
