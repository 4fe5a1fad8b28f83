#include "polhode/read/ccsds_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/ccsds_frames.hpp"
#include "polhode/read/ccsds_rules.hpp"

namespace polhode {

CcsdsReader::CcsdsReader(const CcsdsMessage& message, const std::string& file) : in_(message), file_(file) {
  const std::optional<double> version = parse_number(message.version);
  if (!version || (*version != 1.0 && *version != 2.0) || (*version == 1.0 && message.kind == "ACM")) {
    throw InputError({file, message.header.line},
                     fmt::format("version '{:.60}' of the {} is unknown; {} can be read", message.version, message.kind,
                                 message.kind == "ACM" ? "2.0" : "1.0 and 2.0"));
  }
  version_ = *version == 1.0 ? 1 : 2;
  out_.kind = message.kind;
  out_.version = version_ == 1 ? "1.0" : "2.0";
  const CcsdsFields header(message.header, ccsds_rules::header, "the header of " + message_name(), file);
  out_.body.source = fmt::format("CCSDS {} {} by {}, {}", message.kind, out_.version, header.text("ORIGINATOR"),
                                 header.text("CREATION_DATE"));
  if (message.segments.empty())
    throw InputError({file, message.header.line}, fmt::format("{} without metadata and data", message_name()));
  if (message.kind != "AEM" && message.segments.size() > 1) {
    throw InputError({file, message.segments[1].metadata.line},
                     fmt::format("{} has a single metadata section", message_name()));
  }
}

std::string CcsdsReader::message_name() const { return fmt::format("an {} {}", in_.kind, out_.version); }

std::string CcsdsReader::block_name(const CcsdsBlock& block) const {
  return fmt::format("the {} block of {}", block.name, message_name());
}

void CcsdsReader::warn(std::string text) {
  std::vector<std::string>& list = out_.body.warnings;
  if (std::find(list.begin(), list.end(), text) == list.end()) list.push_back(std::move(text));
}

CcsdsFields CcsdsReader::fields_beside_rows(const CcsdsBlock& block, std::span<const CcsdsRule> rules) const {
  return {block, rules, block_name(block), file_, version_};
}

CcsdsFields CcsdsReader::fields(const CcsdsBlock& block, std::span<const CcsdsRule> rules, int version) const {
  if (!block.rows.empty()) throw error(block.rows[0].line, fmt::format("a line without '=' in {}", block_name(block)));
  return {block, rules, block_name(block), file_, version};
}

CcsdsFields CcsdsReader::metadata(const CcsdsSegment& segment, std::span<const CcsdsRule> rules) {
  const CcsdsBlock& block = segment.metadata;
  if (!block.rows.empty()) throw error(block.rows[0].line, fmt::format("a line without '=' in {}", block_name(block)));
  CcsdsFields f(block, rules, "the metadata of " + message_name(), file_, version_);
  clock_ = ccsds_clock(f.entry("TIME_SYSTEM"), file_);
  if (!clock_.known)
    warn(fmt::format("TIME_SYSTEM {} cannot be related to UTC: times count among themselves only", clock_.name));
  if (out_.body.name.empty()) out_.body.name = f.text("OBJECT_NAME");
  return f;
}

void CcsdsReader::check_order(const CcsdsBlock& block, std::span<const std::string_view> order) {
  const auto found = std::find(order.begin(), order.end(), block.name);
  if (found == order.end()) refuse(block);
  const auto place = static_cast<std::size_t>(found - order.begin());
  if (place < last_place_) {
    throw error(block.line, fmt::format("the {} block comes after the {} block; their order is {}", block.name,
                                        order[last_place_], fmt::join(order, ", ")));
  }
  last_place_ = place;
}

void CcsdsReader::refuse(const CcsdsBlock& block) const {
  throw error(block.line, fmt::format("{} has no block {}", message_name(), block.name));
}

std::string CcsdsReader::frame_name(const CcsdsFields& f, std::string_view keyword) {
  const std::string name = f.text(keyword);
  if (!name.empty() && !is_registered_frame(name)) {
    warn(fmt::format("line {}: {} = {} is not a frame that CCSDS registers; it is taken as a name only",
                     f.entry(keyword).line, keyword, name));
  }
  return name;
}

void CcsdsReader::set_ends(CcsdsKinematics& k, const CcsdsFields& f, std::string_view a, std::string_view b,
                           std::string_view direction) {
  k.tell = [this, told = false](const std::string& doubt) mutable {
    if (!std::exchange(told, true)) warn(doubt);  // of its first row
  };
  k.start = frame_name(f, a);
  k.end = frame_name(f, b);
  if (same_frame(k.start, k.end)) throw f.error(b, fmt::format("{} and {} are the same frame {}", a, b, k.end));
  if (!direction.empty() && f.normal(direction) == "B2A") std::swap(k.start, k.end);
}

EulerSequence CcsdsReader::euler_sequence(const CcsdsFields& f) {
  const std::string text = f.text("EULER_ROT_SEQ");
  if (version_ == 2 && text[0] >= '1' && text[0] <= '3') {
    warn(fmt::format("line {}: EULER_ROT_SEQ = {} in version 2, which writes letters", f.entry("EULER_ROT_SEQ").line,
                     text));
  }
  return EulerSequence(text);
}

void CcsdsReader::set_inertia(const CcsdsFields& f, std::span<const std::string_view, 6> keys) {
  const Vector3 moments(f.number(keys[0]), f.number(keys[1]), f.number(keys[2]));
  Vector3 products = Vector3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (f.has(keys[k + 3])) products[static_cast<Eigen::Index>(k)] = f.number(keys[k + 3]);
  }
  if (out_.body.inertia) {
    warn(fmt::format("line {}: a further inertia; the first one is used", f.start().line));
    return;
  }
  const auto inertia = [&](ProductsOfInertia sign) {
    return inertia_from_tensor(inertia_tensor(moments, products, sign), true);
  };
  out_.body.inertia = located(f.where(keys[0]), [&] { return inertia(ProductsOfInertia::positive_integrals); });
  inertia_frame_ = frame_name(f, "INERTIA_REF_FRAME");
  if (!(products.cwiseAbs().maxCoeff() > 0.0)) return;
  std::string other;
  try {
    const Vector3 m = inertia(ProductsOfInertia::tensor_elements).principal_moments;
    other = fmt::format(
        "; taken as tensor elements instead, as Orekit does, the principal moments would be {:.10g}, {:.10g}, {:.10g}",
        m[0], m[1], m[2]);
  } catch (const InputError&) {
    other.clear();
  }
  note(fmt::format(
      "products of inertia are read as integrals of xy dm, the tensor holds -{} (CCSDS 504.0-B-2 annex F6){}", keys[3],
      other));
}

int CcsdsReader::score(const std::string& body_axes, const std::optional<Frame>& known_frame) const {
  const bool fits = inertia_frame_.empty() || same_frame(body_axes, inertia_frame_);
  return (known_frame ? 4 : 0) + (fits ? 2 : 0);
}

void CcsdsReader::set_state(const StatedAttitude& attitude, const std::optional<Vector3>& omega, Instant epoch) {
  Body& body = out_.body;
  if (!attitude.known_frame) {
    lack(fmt::format("an attitude in an inertial frame ({} in {} is given)", attitude.body, attitude.frame));
  } else if (!clock_.known) {
    lack(fmt::format("a time system that relates to UTC ({} is given)", clock_.name));
  } else {
    body.state = SpinState{epoch, clock_.scale, *attitude.known_frame, attitude.q_frame_from_body, omega};
  }
  if (body.inertia && !inertia_frame_.empty() && !same_frame(inertia_frame_, attitude.body)) {
    lack(fmt::format("the inertia and the attitude in the same axes (inertia in {}, attitude of {})", inertia_frame_,
                     attitude.body));
  } else if (body.inertia && inertia_frame_.empty()) {
    warn(fmt::format("no INERTIA_REF_FRAME: the inertia is taken in the axes {}", attitude.body));
  }
  lack_rate_and_inertia(omega.has_value());
}

void CcsdsReader::lack_state(std::string_view what) {
  lack(what);
  lack_rate_and_inertia(false);
}

void CcsdsReader::lack_rate_and_inertia(bool has_rate) {
  if (!has_rate) lack("an angular velocity");
  if (!out_.body.inertia) lack("an inertia");
}

AttitudeHistory CcsdsReader::new_history(std::string object_id) {
  out_.body.id = std::move(object_id);
  AttitudeHistory history;
  history.object = out_.body.name;
  history.object_id = out_.body.id;
  history.scale = clock_.scale;
  history.absolute_time = clock_.known;
  return history;
}

void CcsdsReader::add_row(AttitudeSegment& segment, const StatedAttitude& attitude, Instant time) {
  segment.frame = attitude.frame;
  segment.body = attitude.body;
  segment.known_frame = attitude.known_frame;
  segment.samples.push_back({time, attitude.q_frame_from_body, attitude.omega_body_rad_s});
}

void CcsdsReader::finish(AttitudeHistory history) {
  const AttitudeSegment* chosen = nullptr;
  const auto score_of = [this](const AttitudeSegment& s) {
    return score(s.body, s.known_frame) + (s.has_rates() ? 1 : 0);
  };
  for (const AttitudeSegment& s : history.segments) {
    if (chosen == nullptr || score_of(s) > score_of(*chosen)) chosen = &s;
  }
  if (chosen != nullptr) {
    const AttitudeSample& row = chosen->samples.front();
    const StatedAttitude a{
        "ATT", chosen->frame, chosen->body, chosen->known_frame, row.q_frame_from_body, row.omega_body_rad_s};
    out_.body.attitudes.push_back(a);
    set_state(a, row.omega_body_rad_s, row.time);
  } else {
    lack_state("an attitude (ATT block)");
  }
  for (std::size_t i = 0; i < history.segments.size(); ++i) {
    const std::optional<std::string> doubt = doubt_about_interpolation(history.segments[i]);
    if (doubt) warn(history.segments.size() > 1 ? fmt::format("segment {}: {}", i + 1, *doubt) : *doubt);
  }
  history.source = out_.body.source;
  history.warnings = out_.body.warnings;
  if (!history.segments.empty()) out_.history = std::move(history);
}

}  // namespace polhode
