// The Attitude Parameter Message: one attitude in up to four forms, an inertia, manoeuvres.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "polhode/base/error.hpp"
#include "polhode/base/units.hpp"
#include "polhode/read/ccsds_frames.hpp"
#include "polhode/read/ccsds_reader.hpp"
#include "polhode/read/ccsds_rules.hpp"

namespace polhode {

void name_angles_by_place(CcsdsBlock& block, const std::string& what, const std::string& file) {
  const auto found = std::find_if(block.entries.rbegin(), block.entries.rend(),
                                  [](const CcsdsEntry& e) { return e.keyword == "EULER_ROT_SEQ"; });
  if (found == block.entries.rend())
    throw InputError({file, block.line}, fmt::format("EULER_ROT_SEQ is missing in {}", what));
  CcsdsBlock only;
  only.line = block.line;
  only.entries = {*found};
  constexpr auto rule = std::to_array<CcsdsRule>({{"EULER_ROT_SEQ", CcsdsUse::required, CcsdsValue::sequence}});
  const std::string text = CcsdsFields(only, rule, what, file).text("EULER_ROT_SEQ");
  const EulerSequence axes(text);
  for (const std::string_view kind : {std::string_view("_ANGLE"), std::string_view("_RATE")}) {
    std::array<bool, 3> taken{};
    for (CcsdsEntry& e : block.entries) {
      if (e.keyword.size() != 1 + kind.size() || !e.keyword.ends_with(kind)) continue;
      std::size_t place = 0;
      while (place < 3 && (taken[place] || axes.axes()[place] != e.keyword[0] - 'X')) ++place;
      if (place == 3) {
        throw InputError({file, e.line},
                         fmt::format("{} once too often, or not an axis of EULER_ROT_SEQ = {}", e.keyword, text));
      }
      taken[place] = true;
      e.keyword = fmt::format("ANGLE_{}{}", place + 1, kind == "_RATE" ? "_DOT" : "");
    }
  }
}

namespace {

using Kinematics = CcsdsKinematics;

class ApmReader : CcsdsReader {
 public:
  using CcsdsReader::CcsdsReader;

  CcsdsAttitudeMessage read() {
    const CcsdsSegment& segment = in_.segments[0];
    out_.body.id = metadata(segment, ccsds_rules::apm_metadata).text("OBJECT_ID");
    CcsdsBlock data = segment.data;
    blocks_version_ = version_;
    if (version_ == 1 && !in_.xml && !data.blocks.empty()) {
      warn(fmt::format("line {}: blocks of version 2 under a header of version 1", data.blocks[0].line));
      blocks_version_ = 2;
    } else if (version_ == 1 && !in_.xml) {
      data = split_v1(data);
    }
    v1_ = blocks_version_ == 1;
    const CcsdsFields top(data, v1_ ? std::span<const CcsdsRule>{} : std::span<const CcsdsRule>(ccsds_rules::apm_data),
                          "the data of " + message_name(), file_);
    if (top.has("EPOCH")) epoch_ = date(top, "EPOCH");
    if (data.blocks.empty()) throw error(data.line, fmt::format("{} needs at least one block of data", message_name()));

    constexpr std::array<std::string_view, 6> order{"QUAT", "EULER", "ANGVEL", "SPIN", "INERTIA", "MAN"};
    std::size_t manoeuvres = 0;
    for (CcsdsBlock& block : data.blocks) {
      if (v1_ && block.name == "ANGVEL") refuse(block);
      check_order(block, order);
      if (block.name == "QUAT") {
        read_quat(block);
      } else if (block.name == "EULER") {
        read_euler(block);
      } else if (block.name == "ANGVEL") {
        angular_velocities_.emplace_back(block);
        fields(block, ccsds_rules::angvel);
      } else if (block.name == "SPIN") {
        read_spin(block);
      } else if (block.name == "INERTIA") {
        const auto keys = v1_ ? std::to_array<std::string_view>({"I11", "I22", "I33", "I12", "I13", "I23"})
                              : std::to_array<std::string_view>({"IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"});
        set_inertia(fields(block, ccsds_rules::inertia, blocks_version_), keys);
      } else {
        const CcsdsFields f = fields(block, ccsds_rules::apm_man, blocks_version_);
        date(f, "MAN_EPOCH_START");
        frame_name(f, "MAN_REF_FRAME");
        ++manoeuvres;
      }
    }
    if (manoeuvres > 0) warn(fmt::format("manoeuvres: {}; no motion takes them into account", manoeuvres));
    if (v1_ && !epoch_) throw error(data.line, "Q_FRAME_A is missing: an APM 1.0 has a quaternion");
    apply_angular_velocities();
    choose_state();
    return std::move(out_);
  }

 private:
  /// Version 1 has no marks around the blocks of an APM in KVN; their keywords tell.
  CcsdsBlock split_v1(const CcsdsBlock& flat) const {
    const auto has = [](std::span<const CcsdsRule> rules, std::string_view keyword) {
      return std::any_of(rules.begin(), rules.end(), [&](const CcsdsRule& r) { return r.may(1) && r.names(keyword); });
    };
    const auto block_of = [&has](std::string_view k) -> std::string_view {
      if (has(ccsds_rules::quat, k)) return "QUAT";
      if (k.starts_with("EULER_") || k == "RATE_FRAME" || k.ends_with("_ANGLE") || k.ends_with("_RATE"))
        return k == "SPIN_ANGLE" ? "SPIN" : "EULER";
      if (k.starts_with("SPIN_") || k.starts_with("NUTATION")) return "SPIN";
      if (has(ccsds_rules::inertia, k)) return "INERTIA";
      return k.starts_with("MAN_") ? "MAN" : "";
    };
    CcsdsBlock data;
    data.name = flat.name;
    data.line = flat.line;
    for (const CcsdsEntry& e : flat.entries) {
      const std::string_view name = block_of(e.keyword);
      if (name.empty())
        throw error(e.line, fmt::format("the keyword {} is not allowed in {}", e.keyword, message_name()));
      if (data.blocks.empty() || data.blocks.back().name != name || e.keyword == "MAN_EPOCH_START") {
        data.blocks.push_back({std::string(name), e.line, {}, {}, {}});
      }
      data.blocks.back().entries.push_back(e);
    }
    return data;
  }

  /// The frames, whose keywords have a prefix of their own in version 1.
  Kinematics kinematics(const CcsdsFields& f, const std::string& prefix, Kinematics::Attitude attitude) {
    Kinematics k;
    k.attitude = attitude;
    if (v1_) {
      set_ends(k, f, prefix + "_FRAME_A", prefix + "_FRAME_B", prefix + "_DIR");
    } else {
      set_ends(k, f);
    }
    return k;
  }

  void state(StatedAttitude attitude, const SourceLocation& where) {
    out_.body.attitudes.push_back(std::move(attitude));
    lines_.push_back(where.line);
  }

  std::string block_of(std::size_t attitude) const {
    return fmt::format("the {} block (line {})", out_.body.attitudes[attitude].block, lines_[attitude]);
  }

  void read_quat(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, ccsds_rules::quat, blocks_version_);
    if (v1_) epoch_ = date(f, "EPOCH");
    Kinematics k = kinematics(f, "Q", Kinematics::Attitude::quaternion);
    std::vector<double> numbers;
    f.append({"Q1", "Q2", "Q3", "QC"}, numbers);
    if (f.append({"Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"}, numbers)) k.rate = Kinematics::Rate::quaternion;
    state(k.stated(numbers, "QUAT", f.where("Q1")), f.start());
  }

  void read_euler(CcsdsBlock& block) {
    if (v1_) name_angles_by_place(block, block_name(block), file_);
    const CcsdsFields f = fields(block, ccsds_rules::euler, blocks_version_);
    const EulerSequence axes = euler_sequence(f);
    Kinematics k = kinematics(f, "EULER", Kinematics::Attitude::euler_angles);
    k.axes = axes;
    std::vector<double> numbers;
    const bool angles_given = f.append({"ANGLE_1", "ANGLE_2", "ANGLE_3"}, numbers);
    const bool rates_given = f.append({"ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"}, numbers);
    if (rates_given) k.rate = Kinematics::Rate::euler_angles;
    if (!v1_ && f.has("RATE_FRAME"))
      warn(fmt::format("line {}: RATE_FRAME belongs to version 1; ignored", f.entry("RATE_FRAME").line));
    if (v1_ && rates_given && !f.has("RATE_FRAME"))
      throw InputError(f.start(), fmt::format("RATE_FRAME is missing in {}, which has rates", f.what()));
    if (v1_ && !angles_given && !rates_given) f.missing("X_ANGLE (or X_RATE)");
    if (angles_given) {
      state(k.stated(numbers, "EULER", f.start()), f.start());
    } else {
      // Rates alone, as version 1 allows: the angles are those of the quaternion between the same frames.
      const auto last_between = [this](const std::string& frame, const std::string& body) -> const StatedAttitude* {
        const auto& list = out_.body.attitudes;
        const auto found = std::find_if(list.rbegin(), list.rend(), [&](const StatedAttitude& s) {
          return same_frame(s.frame, frame) && same_frame(s.body, body);
        });
        return found == list.rend() ? nullptr : &*found;
      };
      const StatedAttitude* known = last_between(k.start, k.end);
      const StatedAttitude* turned = last_between(k.end, k.start);
      if (known == nullptr && turned == nullptr) {
        warn(fmt::format("line {}: Euler rates without angles, and no quaternion between the same frames; not used",
                         block.line));
        return;
      }
      const Quaternion q = known != nullptr ? known->q_frame_from_body : turned->q_frame_from_body.conjugate();
      state(k.stated(q, numbers, "EULER", f.start()), f.start());
    }
    if (rates_given && v1_) warn(std::string(warning_of_v1_rates));
  }

  void read_spin(const CcsdsBlock& block) {
    const CcsdsFields f = fields(block, ccsds_rules::spin, blocks_version_);
    Kinematics k = kinematics(f, "SPIN", Kinematics::Attitude::spin);
    std::vector<double> numbers;
    f.append({"SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL"}, numbers);
    if (f.append({"NUTATION", "NUTATION_PER", "NUTATION_PHASE"}, numbers)) k.rate = Kinematics::Rate::nutation;
    if (f.append({"MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"}, numbers)) {
      if (k.rate == Kinematics::Rate::nutation)
        throw f.error("MOMENTUM_ALPHA", "a SPIN block has either NUTATION, … or MOMENTUM_ALPHA, …, not both");
      k.rate = Kinematics::Rate::momentum;
    }
    state(k.stated(numbers, "SPIN", f.start()), f.start());
  }

  /// The ANGVEL blocks come before the attitudes that they may need (SPIN), hence at the end.
  void apply_angular_velocities() {
    std::vector<std::string> rates_of;  // of each attitude: what gives its rates
    for (std::size_t i = 0; i < lines_.size(); ++i) rates_of.push_back("the rates of " + block_of(i));
    for (const CcsdsBlock& block : angular_velocities_) {
      const CcsdsFields f = fields(block, ccsds_rules::angvel);
      const std::string a = frame_name(f, "REF_FRAME_A");
      const std::string b = frame_name(f, "REF_FRAME_B");
      const std::string c = frame_name(f, "ANGVEL_FRAME");
      const Vector3 omega = degree * Vector3(f.number("ANGVEL_X"), f.number("ANGVEL_Y"), f.number("ANGVEL_Z"));
      bool used = false;
      for (std::size_t i = 0; i < lines_.size(); ++i) {
        StatedAttitude& s = out_.body.attitudes[i];
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
          warn(fmt::format("line {}: the ANGVEL block and {} differ by {:.3g} deg/s; the ANGVEL block is used",
                           block.line, rates_of[i], (of_body - *s.omega_body_rad_s).norm() / degree));
        }
        s.omega_body_rad_s = of_body;
        rates_of[i] = fmt::format("that of line {}", block.line);
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
  void choose_state() {
    const std::vector<StatedAttitude>& all = out_.body.attitudes;
    const auto score_of = [this](const StatedAttitude& s) { return score(s.body, s.known_frame); };
    const auto best = std::max_element(
        all.begin(), all.end(), [&](const auto& one, const auto& other) { return score_of(one) < score_of(other); });
    if (best == all.end()) {
      if (!angular_velocities_.empty()) {
        throw error(angular_velocities_[0].line,
                    "an angular velocity, but no attitude (QUAT, EULER or SPIN block) that it belongs to");
      }
      lack_state("an attitude (QUAT, EULER or SPIN block)");
      return;
    }
    std::optional<Vector3> omega = best->omega_body_rad_s;
    const auto chosen = static_cast<std::size_t>(best - all.begin());
    std::size_t rates_of = chosen;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const StatedAttitude& s = all[i];
      if (i == chosen || !same_frame(s.frame, best->frame) || !same_frame(s.body, best->body)) continue;
      const double apart = rotation_angle_rad(s.q_frame_from_body, best->q_frame_from_body);
      if (apart > 1e-3) {
        warn(fmt::format("{} and {} give attitudes that are {:.4g} deg apart; the first is used", block_of(chosen),
                         block_of(i), apart / degree));
      } else if (omega && s.omega_body_rad_s && !omega->isApprox(*s.omega_body_rad_s, 1e-3)) {
        warn(fmt::format("{} and {} give rates that differ by {:.3g} deg/s; the first are used", block_of(rates_of),
                         block_of(i), (*omega - *s.omega_body_rad_s).norm() / degree));
      }
      if (!omega) {
        omega = s.omega_body_rad_s;
        rates_of = i;
      }
    }
    set_state(*best, omega, epoch_.value());
  }

  int blocks_version_ = 2;  // that of the message, but for blocks of version 2 under a header of version 1
  bool v1_ = false;         // of the blocks
  std::optional<Instant> epoch_;
  std::vector<CcsdsBlock> angular_velocities_;
  std::vector<std::size_t> lines_;  // of the blocks of the body's attitudes
};

}  // namespace

CcsdsAttitudeMessage read_apm(const CcsdsMessage& message, const std::string& file) {
  return ApmReader(message, file).read();
}

}  // namespace polhode
