#pragma once

#include <span>
#include <string>
#include <string_view>

#include "polhode/read/ccsds_attitude.hpp"
#include "polhode/read/ccsds_fields.hpp"
#include "polhode/read/ccsds_kinematics.hpp"
#include "polhode/read/ccsds_tree.hpp"

namespace polhode {

/// The reader of each kind of message. They throw InputError.
CcsdsAttitudeMessage read_apm(const CcsdsMessage& message, const std::string& file);
CcsdsAttitudeMessage read_aem(const CcsdsMessage& message, const std::string& file);
CcsdsAttitudeMessage read_acm(const CcsdsMessage& message, const std::string& file);

/// Gives the angles and rates of version 1 their places in the sequence: X_ANGLE, Z_RATE … become ANGLE_n, ANGLE_n_DOT.
/// `what` names the block in messages.
void name_angles_by_place(CcsdsBlock& block, const std::string& what, const std::string& file);

inline constexpr std::string_view warning_of_v1_rates =
    "the rates of version 1 are read as derivatives of the Euler angles, as its own examples and Orekit have them; "
    "RATE_FRAME is not used";

/// What they share: the message, its names in the texts for people, and the body that comes of it.
class CcsdsReader {
 public:
  /// Reads the version and the header.
  CcsdsReader(const CcsdsMessage& message, const std::string& file);

 protected:
  std::string message_name() const;
  std::string block_name(const CcsdsBlock& block) const;
  InputError error(std::size_t line, const std::string& message) const { return {{file_, line}, message}; }
  void warn(std::string text);
  void note(std::string_view text) { out_.body.notes.emplace_back(text); }

  /// The fields of a block, by the rules of this message's version or of the given one; those of a block without data
  /// lines; and those of a segment's metadata, which set the clock.
  CcsdsFields fields_beside_rows(const CcsdsBlock& block, std::span<const CcsdsRule> rules) const;
  CcsdsFields fields(const CcsdsBlock& block, std::span<const CcsdsRule> rules, int version) const;
  CcsdsFields fields(const CcsdsBlock& block, std::span<const CcsdsRule> rules) const {
    return fields(block, rules, version_);
  }
  CcsdsFields metadata(const CcsdsSegment& segment, std::span<const CcsdsRule> rules);

  /// Holds the blocks of the data, one after another, against their order.
  void check_order(const CcsdsBlock& block, std::span<const std::string_view> order);
  [[noreturn]] void refuse(const CcsdsBlock& block) const;

  /// A frame's name; warns about one that CCSDS does not register.
  std::string frame_name(const CcsdsFields& f, std::string_view keyword);
  /// The frames that a rotation leads from and to; `direction` is the keyword that may say B2A, or empty.
  void set_ends(CcsdsKinematics& k, const CcsdsFields& f, std::string_view a = "REF_FRAME_A",
                std::string_view b = "REF_FRAME_B", std::string_view direction = {});
  EulerSequence euler_sequence(const CcsdsFields& f);
  Instant date(const CcsdsFields& f, std::string_view keyword) const {
    return clock_.date(f.text(keyword), f.where(keyword));
  }

  /// The body's inertia, from the keywords of its three moments and three products.
  void set_inertia(const CcsdsFields& f, std::span<const std::string_view, 6> keys);

  /// How well an attitude serves as the state.
  int score(const std::string& body_axes, const std::optional<Frame>& known_frame) const;
  void set_state(const StatedAttitude& attitude, const std::optional<Vector3>& omega, Instant epoch);
  /// Of a message whose data hold nothing that can be the state.
  void lack_state(std::string_view what);
  /// A history with the names that the message gives.
  AttitudeHistory new_history(std::string object_id);
  static void add_row(AttitudeSegment& segment, const StatedAttitude& attitude, Instant time);
  /// Keeps it; the first row that has a rate, else the first row, is the state.
  void finish(AttitudeHistory history);

  const CcsdsMessage& in_;
  const std::string& file_;
  int version_ = 2;
  CcsdsAttitudeMessage out_;
  CcsdsClock clock_;

 private:
  void lack_rate_and_inertia(bool has_rate);
  void lack(std::string_view what) { out_.body.missing.emplace_back(what); }

  std::string inertia_frame_;
  std::size_t last_place_ = 0;
};

}  // namespace polhode
