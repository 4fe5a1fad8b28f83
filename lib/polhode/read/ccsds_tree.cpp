#include "polhode/read/ccsds_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <pugixml.hpp>

#include "polhode/base/error.hpp"
#include "polhode/read/text.hpp"

namespace polhode {
namespace {

constexpr std::array<std::string_view, 3> attitude_kinds{"APM", "AEM", "ACM"};
constexpr std::array<std::string_view, 1> orbit_kinds{"OEM"};
constexpr std::array<std::string_view, 12> all_kinds{"APM", "AEM", "ACM", "OPM", "OMM", "OEM",
                                                     "OCM", "TDM", "CDM", "RDM", "PRM", "NDM"};

template <typename List>
bool contains(const List& list, std::string_view item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

bool is_keyword(std::string_view word) {
  return !word.empty() && word.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == std::string_view::npos;
}

/// The kind in CCSDS_kind_VERS, or nothing.
std::string_view kind_of(std::string_view keyword) {
  if (keyword.size() != 14 || !keyword.starts_with("CCSDS_") || !keyword.ends_with("_VERS")) return {};
  return keyword.substr(6, 3);
}

bool is_wanted(std::string_view kind, CcsdsContent content) {
  return content == CcsdsContent::attitude ? contains(attitude_kinds, kind) : contains(orbit_kinds, kind);
}

void check_kind(std::string_view kind, CcsdsContent content, const SourceLocation& where) {
  if (is_wanted(kind, content)) return;
  throw InputError(
      where,
      content == CcsdsContent::attitude
          ? fmt::format("the message is of kind {}, which holds no attitude; attitude messages are APM, AEM and ACM",
                        kind)
          : fmt::format("the message is of kind {}, which holds no trajectory; an OEM is wanted", kind));
}

// --- KVN ---------------------------------------------------------------------------------------------------------

/// A line of KVN, taken apart.
struct KvnLine {
  enum class Kind { nothing, entry, start, stop, row };
  Kind kind = Kind::nothing;
  CcsdsEntry entry;  // of start and stop: the keyword is the block's name
  CcsdsRow row;
};

/// "123.4 [deg]" into value and unit; a name may end in brackets of its own.
void take_unit(CcsdsEntry& entry) {
  if (!entry.value.ends_with(']') || entry.keyword == "OBJECT_NAME" || entry.keyword == "OBJECT_ID") return;
  const std::size_t open = entry.value.rfind('[');
  if (open == std::string::npos) return;
  entry.unit = trimmed(std::string_view(entry.value).substr(open + 1, entry.value.size() - open - 2));
  entry.value = trimmed(std::string_view(entry.value).substr(0, open));
}

KvnLine kvn_line(std::string_view text, std::size_t number, const std::string& name) {
  KvnLine line;
  const std::string_view content = trimmed(text);
  const std::string_view first = content.substr(0, std::min(content.find_first_of(" \t="), content.size()));
  if (content.empty() || first == "COMMENT") return line;
  if (is_keyword(content) && content.ends_with("_START")) {
    line.kind = KvnLine::Kind::start;
    line.entry = {std::string(content.substr(0, content.size() - 6)), "", "", number};
  } else if (is_keyword(content) && content.ends_with("_STOP")) {
    line.kind = KvnLine::Kind::stop;
    line.entry = {std::string(content.substr(0, content.size() - 5)), "", "", number};
  } else if (const std::size_t equals = content.find('='); equals != std::string_view::npos) {
    const std::string_view keyword = trimmed(content.substr(0, equals));
    if (!is_keyword(keyword)) {
      throw InputError({name, number}, fmt::format("'{}' is not a keyword (capital letters, digits and _)", keyword));
    }
    line.kind = KvnLine::Kind::entry;
    line.entry = {std::string(keyword), std::string(trimmed(content.substr(equals + 1))), "", number};
    take_unit(line.entry);
  } else {
    line.kind = KvnLine::Kind::row;
    line.row.line = number;
    for (const std::string_view word : split_words(content))
      line.row.cells.push_back({"", std::string(word), "", number});
  }
  return line;
}

constexpr std::array<std::string_view, 4> header_keywords{"CLASSIFICATION", "CREATION_DATE", "ORIGINATOR",
                                                          "MESSAGE_ID"};
constexpr std::array<std::string_view, 4> apm_metadata_keywords{"OBJECT_NAME", "OBJECT_ID", "CENTER_NAME",
                                                                "TIME_SYSTEM"};

/// Puts KVN lines into a message. Blocks nest by START and STOP; an APM has no marks around header, metadata and data,
/// there the keywords tell.
class KvnBuilder {
 public:
  KvnBuilder(const std::string& name, CcsdsContent content) : name_(name), content_(content) {}

  void take(KvnLine line) {
    const std::size_t number = line.kind == KvnLine::Kind::row ? line.row.line : line.entry.line;
    if (message_.kind.empty() && line.kind != KvnLine::Kind::nothing) {
      const std::string_view kind =
          line.kind == KvnLine::Kind::entry ? kind_of(line.entry.keyword) : std::string_view{};
      if (kind.empty()) throw InputError({name_, number}, "the first line must be CCSDS_xxx_VERS = version");
      check_kind(kind, content_, {name_, number});
      message_.kind = kind;
      message_.version = line.entry.value;
      message_.header.name = "header";
      message_.header.line = number;
      return;
    }
    switch (line.kind) {
      case KvnLine::Kind::nothing:
        return;
      case KvnLine::Kind::start:
        start(std::move(line.entry));
        return;
      case KvnLine::Kind::stop:
        stop(line.entry);
        return;
      case KvnLine::Kind::entry:
        here(line.entry.keyword, number).entries.push_back(std::move(line.entry));
        return;
      case KvnLine::Kind::row:
        if (!open_.empty()) {
          open_.back().rows.push_back(std::move(line.row));
        } else if (message_.kind == "OEM" && !message_.segments.empty()) {  // its states stand in no block
          message_.segments.back().data.rows.push_back(std::move(line.row));
        } else {
          throw InputError({name_, number}, "neither 'keyword = value' nor a line of a data block");
        }
        return;
    }
  }

  CcsdsMessage finish(std::size_t last_line) {
    if (message_.kind.empty()) throw InputError({name_, last_line}, "no CCSDS_xxx_VERS line");
    if (!open_.empty()) {
      throw InputError({name_, open_.back().line},
                       fmt::format("{}_START without {}_STOP", open_.back().name, open_.back().name));
    }
    return std::move(message_);
  }

 private:
  CcsdsSegment& segment(std::size_t line) {
    if (message_.segments.empty()) new_segment(line);
    return message_.segments.back();
  }

  void new_segment(std::size_t line) {
    message_.segments.emplace_back();
    message_.segments.back().metadata.name = "metadata";
    message_.segments.back().metadata.line = line;
    message_.segments.back().data.name = "data";
    message_.segments.back().data.line = line;
  }

  /// The block that an entry belongs to.
  CcsdsBlock& here(std::string_view keyword, std::size_t line) {
    if (!open_.empty()) return open_.back();
    if (message_.kind != "APM") {
      if (message_.segments.empty()) return message_.header;
      throw InputError({name_, line}, fmt::format("{} stands outside of any block", keyword));
    }
    if (message_.segments.empty() && contains(header_keywords, keyword)) return message_.header;
    CcsdsSegment& s = segment(line);
    if (s.data.entries.empty() && s.data.blocks.empty() && contains(apm_metadata_keywords, keyword)) return s.metadata;
    if (s.data.entries.empty() && s.data.blocks.empty()) s.data.line = line;
    return s.data;
  }

  void start(CcsdsEntry entry) {
    if (open_.size() > 4) throw InputError({name_, entry.line}, "blocks within blocks within blocks");
    if (!open_.empty() && !(open_.back().name == "AD" && entry.keyword == "SENSOR")) {
      throw InputError({name_, entry.line},
                       fmt::format("{}_START within {}_START (line {}): {}_STOP is missing", entry.keyword,
                                   open_.back().name, open_.back().line, open_.back().name));
    }
    CcsdsBlock block;
    block.name = std::move(entry.keyword);
    block.line = entry.line;
    open_.push_back(std::move(block));
  }

  void stop(const CcsdsEntry& entry) {
    if (open_.empty() || open_.back().name != entry.keyword) {
      throw InputError({name_, entry.line}, fmt::format("{}_STOP without {}_START", entry.keyword, entry.keyword));
    }
    CcsdsBlock block = std::move(open_.back());
    open_.pop_back();
    if (!open_.empty()) {
      open_.back().blocks.push_back(std::move(block));
    } else if (block.name == "META" && message_.kind != "APM") {
      if (!message_.segments.empty() && message_.segments.back().data.blocks.empty() && message_.kind == "AEM") {
        throw InputError({name_, block.line}, "a second META_START before DATA_START");
      }
      new_segment(block.line);
      message_.segments.back().metadata = std::move(block);
    } else {
      if (message_.segments.empty() && message_.kind != "APM") {
        throw InputError({name_, block.line}, fmt::format("{}_START before META_START", block.name));
      }
      CcsdsSegment& s = segment(block.line);
      if (s.data.entries.empty() && s.data.blocks.empty()) s.data.line = block.line;
      s.data.blocks.push_back(std::move(block));
    }
  }

  const std::string& name_;
  CcsdsContent content_;
  CcsdsMessage message_;
  std::vector<CcsdsBlock> open_;
};

CcsdsFile parse_kvn(std::string_view text, const std::string& name, CcsdsContent content) {
  KvnBuilder builder(name, content);
  std::size_t number = 0;
  while (!text.empty()) builder.take(kvn_line(take_line(text), ++number, name));
  CcsdsFile file;
  file.messages.push_back(builder.finish(number));
  return file;
}

// --- XML ---------------------------------------------------------------------------------------------------------

/// Elements that hold a block, and the block's name in KVN. Names of both versions, and those that Orekit writes.
constexpr std::array<std::pair<std::string_view, std::string_view>, 22> block_elements{
    {{"quaternionState", "QUAT"},
     {"eulerAngleState", "EULER"},
     {"eulerElementsThree", "EULER"},
     {"angularVelocity", "ANGVEL"},
     {"spin", "SPIN"},
     {"eulerElementsSpin", "SPIN"},
     {"spinNutation", "SPIN"},
     {"spinNutationMom", "SPIN"},
     {"inertia", "INERTIA"},
     {"spacecraftParameters", "INERTIA"},
     {"maneuverParameters", "MAN"},
     {"att", "ATT"},
     {"phys", "PHYS"},
     {"cov", "COV"},
     {"man", "MAN"},
     {"ad", "AD"},
     {"user", "USER"},
     {"userDefinedParameters", "USER"},
     {"sensorData", "SENSOR"},
     {"sensor", "SENSOR"},
     {"metadata", "META"},
     {"header", "header"}}};

/// Elements around values that have no counterpart in KVN.
constexpr std::array<std::string_view, 21> wrappers{"quaternion",
                                                    "quaternionDot",
                                                    "quaternionRate",
                                                    "rotationAngles",
                                                    "rotationRates",
                                                    "angVel",
                                                    "nutation",
                                                    "momentum",
                                                    "quaternionEphemeris",
                                                    "quaternionState",
                                                    "quaternionDerivative",
                                                    "quaternionAngVel",
                                                    "quaternionEulerRate",
                                                    "eulerAngle",
                                                    "eulerAngleRate",
                                                    "eulerAngleDerivative",
                                                    "eulerAngleAngVel",
                                                    "spin",
                                                    "spinNutation",
                                                    "spinNutationMom",
                                                    "eulerAngleState"};

class XmlBuilder {
 public:
  XmlBuilder(std::string_view text, const std::string& name, CcsdsContent content) : name_(name), content_(content) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') line_ends_.push_back(i);
    }
    const pugi::xml_parse_result result =
        document_.load_buffer(text.data(), text.size(), pugi::parse_default | pugi::parse_trim_pcdata);
    if (!result) {
      throw InputError({name_, line_at(result.offset)}, fmt::format("broken XML: {}", result.description()));
    }
  }

  CcsdsFile build() {
    CcsdsFile file;
    const pugi::xml_node root = document_.document_element();
    const std::string kind = upper_case(local_name(root));
    if (kind != "NDM") {
      file.messages.push_back(message(root, kind));
      return file;
    }
    for (const pugi::xml_node child : elements(root)) {
      const std::string child_kind = upper_case(local_name(child));
      if (is_wanted(child_kind, content_)) {
        file.messages.push_back(message(child, child_kind));
      } else if (contains(all_kinds, child_kind)) {
        file.other_messages.push_back(child_kind);
      } else if (child_kind != "COMMENT" && child_kind != "MESSAGE_ID") {
        fail(child, fmt::format("<{}> is no message that an NDM may hold", child.name()));
      }
    }
    if (file.messages.empty()) {
      fail(root, content_ == CcsdsContent::attitude ? "the NDM holds no APM, AEM or ACM" : "the NDM holds no OEM");
    }
    return file;
  }

 private:
  static std::string_view local_name(const pugi::xml_node& node) {
    const std::string_view name = node.name();
    const std::size_t colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
  }

  static std::vector<pugi::xml_node> elements(const pugi::xml_node& parent) {
    std::vector<pugi::xml_node> list;
    for (const pugi::xml_node& child : parent.children()) {
      if (child.type() == pugi::node_element) list.push_back(child);
    }
    return list;
  }

  std::size_t line_at(std::ptrdiff_t offset) const {
    return 1 +
           static_cast<std::size_t>(std::lower_bound(line_ends_.begin(), line_ends_.end(),
                                                     static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0))) -
                                    line_ends_.begin());
  }
  std::size_t line_of(const pugi::xml_node& node) const { return line_at(node.offset_debug()); }

  [[noreturn]] void fail(const pugi::xml_node& node, const std::string& message) const {
    throw InputError({name_, line_of(node)}, message);
  }

  CcsdsMessage message(const pugi::xml_node& node, const std::string& kind) {
    check_kind(kind, content_, {name_, line_of(node)});
    CcsdsMessage m;
    m.kind = kind;
    m.xml = true;
    m.version = node.attribute("version").value();
    const std::string_view id = node.attribute("id").value();
    if (id != "CCSDS_" + kind + "_VERS") fail(node, fmt::format("id=\"{}\", wanted is id=\"CCSDS_{}_VERS\"", id, kind));
    m.header.name = "header";
    m.header.line = line_of(node);
    bool has_body = false;
    for (const pugi::xml_node& child : elements(node)) {
      const std::string_view name = local_name(child);
      if (name == "header" && m.header.entries.empty() && !has_body) {
        m.header = block(child, "header");
      } else if (name == "body" && !has_body) {
        has_body = true;
        for (const pugi::xml_node& part : elements(child)) {
          if (local_name(part) != "segment") fail(part, fmt::format("<{}> where <segment> is wanted", part.name()));
          m.segments.push_back(segment(part, kind));
        }
      } else {
        fail(child, fmt::format("<{}> where one <header> and then one <body> are wanted", child.name()));
      }
    }
    return m;
  }

  CcsdsSegment segment(const pugi::xml_node& node, const std::string& kind) {
    const std::vector<pugi::xml_node> parts = elements(node);
    if (parts.size() != 2 || local_name(parts[0]) != "metadata" || local_name(parts[1]) != "data") {
      fail(node, "a segment has one <metadata> and then one <data>");
    }
    CcsdsSegment s;
    s.metadata = block(parts[0], "META");
    s.data.name = "data";
    s.data.line = line_of(parts[1]);
    if (kind == "OEM") {
      for (const pugi::xml_node& child : elements(parts[1])) {
        const std::string_view name = local_name(child);
        if (name == "COMMENT" || name == "covarianceMatrix") continue;
        if (name != "stateVector") fail(child, fmt::format("<{}> where <stateVector> is wanted", child.name()));
        CcsdsRow row;
        row.line = line_of(child);
        flatten(child, row.cells, 0);
        s.data.rows.push_back(std::move(row));
      }
      return s;
    }
    if (kind == "AEM") {
      CcsdsBlock rows;
      rows.name = "DATA";
      rows.line = s.data.line;
      for (const pugi::xml_node& child : elements(parts[1])) {
        const std::string_view name = local_name(child);
        if (name == "COMMENT") continue;
        if (name != "attitudeState") fail(child, fmt::format("<{}> where <attitudeState> is wanted", child.name()));
        CcsdsRow row;
        row.line = line_of(child);
        flatten(child, row.cells, 0);
        rows.rows.push_back(std::move(row));
      }
      s.data.blocks.push_back(std::move(rows));
      return s;
    }
    for (const pugi::xml_node& child : elements(parts[1])) {
      const std::string_view name = local_name(child);
      if (name == "COMMENT") continue;
      if (is_keyword(name)) {
        s.data.entries.push_back(entry(child));
        continue;
      }
      const auto* const found =
          std::find_if(block_elements.begin(), block_elements.end(), [&](const auto& b) { return b.first == name; });
      if (found == block_elements.end()) fail(child, fmt::format("<{}> is no block of an {}", child.name(), kind));
      s.data.blocks.push_back(block(child, found->second));
    }
    return s;
  }

  CcsdsBlock block(const pugi::xml_node& node, std::string_view name) {
    CcsdsBlock b;
    b.name = name;
    b.line = line_of(node);
    for (const pugi::xml_node& child : elements(node)) {
      const std::string_view child_name = local_name(child);
      if (child_name == "attLine" || child_name == "covLine") {
        CcsdsRow row;
        row.line = line_of(child);
        for (const std::string_view word : split_words(child.text().get())) {
          row.cells.push_back({"", std::string(word), "", row.line});
        }
        b.rows.push_back(std::move(row));
      } else if (name == "AD" && (child_name == "sensorData" || child_name == "sensor")) {
        b.blocks.push_back(block(child, "SENSOR"));
      } else {
        flatten_child(child, b.entries, 0);
      }
    }
    return b;
  }

  void flatten(const pugi::xml_node& node, std::vector<CcsdsEntry>& entries, int depth) {
    if (depth > 4) fail(node, fmt::format("<{}> is nested too deeply", node.name()));
    for (const pugi::xml_node& child : elements(node)) flatten_child(child, entries, depth);
  }

  void flatten_child(const pugi::xml_node& child, std::vector<CcsdsEntry>& entries, int depth) {
    const std::string_view name = local_name(child);
    if (name == "COMMENT") return;
    if (name == "rotation1" || name == "rotation2" || name == "rotation3") {
      CcsdsEntry e = entry(child);
      e.keyword = child.attribute("angle") ? child.attribute("angle").value() : child.attribute("rate").value();
      if (!is_keyword(e.keyword)) fail(child, fmt::format("<{}> has no attribute angle or rate", child.name()));
      entries.push_back(std::move(e));
    } else if (name == "USER_DEFINED") {
      CcsdsEntry e = entry(child);
      e.keyword = std::string("USER_DEFINED_") + child.attribute("parameter").value();
      entries.push_back(std::move(e));
    } else if (is_keyword(name)) {
      entries.push_back(entry(child));
    } else if (contains(wrappers, name)) {
      flatten(child, entries, depth + 1);
    } else {
      fail(child, fmt::format("<{}> cannot stand in <{}>", child.name(), child.parent().name()));
    }
  }

  CcsdsEntry entry(const pugi::xml_node& node) const {
    if (!elements(node).empty()) fail(node, fmt::format("<{}> holds elements where a value is wanted", node.name()));
    const pugi::xml_attribute unit = node.attribute("units") ? node.attribute("units") : node.attribute("unit");
    return {std::string(local_name(node)), std::string(trimmed(node.text().get())), std::string(trimmed(unit.value())),
            line_of(node)};
  }

  const std::string& name_;
  CcsdsContent content_;
  pugi::xml_document document_;
  std::vector<std::size_t> line_ends_;
};

}  // namespace

bool is_ccsds(std::string_view text) {
  text = without_mark(text);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return false;
  text.remove_prefix(first);
  if (text.starts_with("CCSDS_")) return true;
  if (!text.starts_with('<')) return false;
  // The first element decides: <apm, <ndm:apm, <ndm …
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string_view::npos && at < 4096; ++at) {
    std::string_view tag = text.substr(at + 1, 32);
    if (tag.starts_with('?') || tag.starts_with('!')) continue;
    tag = tag.substr(0, tag.find_first_of(" \t\r\n/>"));
    const std::size_t colon = tag.find(':');
    const std::string kind = upper_case(colon == std::string_view::npos ? tag : tag.substr(colon + 1));
    return contains(all_kinds, kind);
  }
  return false;
}

CcsdsFile parse_ccsds(std::string_view text, const std::string& name, CcsdsContent content) {
  const std::string_view unmarked = without_mark(text);
  const std::size_t first = unmarked.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && unmarked[first] == '<') return XmlBuilder(text, name, content).build();
  return parse_kvn(unmarked, name, content);
}

}  // namespace polhode
