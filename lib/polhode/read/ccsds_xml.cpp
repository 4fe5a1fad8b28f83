// CCSDS messages in XML, taken apart as those in KVN are.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <pugixml.hpp>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/ccsds_tree.hpp"

namespace polhode {
namespace {

/// Names of blocks in KVN, and the elements that hold them: of both versions, and those that Orekit writes.
constexpr auto block_elements = std::to_array<std::pair<std::string_view, std::string_view>>(
    {{"QUAT", "quaternionState"},
     {"EULER", "eulerAngleState eulerElementsThree"},
     {"ANGVEL", "angularVelocity"},
     {"SPIN", "spin eulerElementsSpin spinNutation spinNutationMom"},
     {"INERTIA", "inertia spacecraftParameters"},
     {"MAN", "maneuverParameters man"},
     {"ATT", "att"},
     {"PHYS", "phys"},
     {"COV", "cov"},
     {"AD", "ad"},
     {"USER", "user userDefinedParameters"},
     {"SENSOR", "sensorData sensor"},
     {"META", "metadata"},
     {"header", "header"}});

/// Elements around values that have no counterpart in KVN.
constexpr std::string_view wrappers =
    "quaternion quaternionDot quaternionRate rotationAngles rotationRates angVel nutation momentum "
    "quaternionEphemeris quaternionState quaternionDerivative quaternionAngVel quaternionEulerRate eulerAngle "
    "eulerAngleRate eulerAngleDerivative eulerAngleAngVel spin spinNutation spinNutationMom eulerAngleState";

class XmlBuilder {
 public:
  XmlBuilder(std::string_view text, const std::string& name, CcsdsContent content) : name_(name), content_(content) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') line_ends_.push_back(i);
    }
    const pugi::xml_parse_result result =
        document_.load_buffer(text.data(), text.size(), pugi::parse_default | pugi::parse_trim_pcdata);
    if (!result) throw InputError({name_, line_at(result.offset)}, fmt::format("broken XML: {}", result.description()));
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
      } else if (is_ccsds_kind(child_kind)) {
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
    check_ccsds_kind(kind, content_, {name_, line_of(node)});
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
      s.data.rows = rows(parts[1], "stateVector", "covarianceMatrix");
      return s;
    }
    if (kind == "AEM") {
      s.data.blocks.push_back({"DATA", s.data.line, {}, rows(parts[1], "attitudeState", ""), {}});
      return s;
    }
    for (const pugi::xml_node& child : elements(parts[1])) {
      const std::string_view name = local_name(child);
      if (name == "COMMENT") continue;
      if (is_ccsds_keyword(name)) {
        s.data.entries.push_back(entry(child));
        continue;
      }
      const auto* const found = std::find_if(block_elements.begin(), block_elements.end(),
                                             [&](const auto& b) { return contains_word(b.second, name); });
      if (found == block_elements.end()) fail(child, fmt::format("<{}> is no block of an {}", child.name(), kind));
      s.data.blocks.push_back(block(child, found->first));
    }
    return s;
  }

  /// The data lines of an ephemeris; elements `left_out` are left out.
  std::vector<CcsdsRow> rows(const pugi::xml_node& data, std::string_view element, std::string_view left_out) {
    std::vector<CcsdsRow> list;
    for (const pugi::xml_node& child : elements(data)) {
      const std::string_view name = local_name(child);
      if (name == "COMMENT" || name == left_out) continue;
      if (name != element) fail(child, fmt::format("<{}> where <{}> is wanted", child.name(), element));
      CcsdsRow row;
      row.line = line_of(child);
      flatten(child, row.cells, 0);
      list.push_back(std::move(row));
    }
    return list;
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
      if (!is_ccsds_keyword(e.keyword)) fail(child, fmt::format("<{}> has no attribute angle or rate", child.name()));
      entries.push_back(std::move(e));
    } else if (name == "USER_DEFINED") {
      CcsdsEntry e = entry(child);
      e.keyword = std::string("USER_DEFINED_") + child.attribute("parameter").value();
      entries.push_back(std::move(e));
    } else if (is_ccsds_keyword(name)) {
      entries.push_back(entry(child));
    } else if (contains_word(wrappers, name)) {
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

CcsdsFile parse_ccsds_xml(std::string_view text, const std::string& name, CcsdsContent content) {
  return XmlBuilder(text, name, content).build();
}

}  // namespace polhode
