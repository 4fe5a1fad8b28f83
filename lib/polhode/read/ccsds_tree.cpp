#include "polhode/read/ccsds_tree.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"

namespace polhode {
namespace {

/// The kind in CCSDS_kind_VERS, or nothing.
std::string_view kind_of(std::string_view keyword) {
  if (keyword.size() != 14 || !keyword.starts_with("CCSDS_") || !keyword.ends_with("_VERS")) return {};
  return keyword.substr(6, 3);
}

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
  if (is_ccsds_keyword(content) && content.ends_with("_START")) {
    line.kind = KvnLine::Kind::start;
    line.entry = {std::string(content.substr(0, content.size() - 6)), "", "", number};
  } else if (is_ccsds_keyword(content) && content.ends_with("_STOP")) {
    line.kind = KvnLine::Kind::stop;
    line.entry = {std::string(content.substr(0, content.size() - 5)), "", "", number};
  } else if (const std::size_t equals = content.find('='); equals != std::string_view::npos) {
    const std::string_view keyword = trimmed(content.substr(0, equals));
    if (!is_ccsds_keyword(keyword))
      throw InputError({name, number},
                       fmt::format("'{:.60}' is not a keyword (capital letters, digits and _)", keyword));
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

constexpr std::string_view header_keywords = "CLASSIFICATION CREATION_DATE ORIGINATOR MESSAGE_ID";
constexpr std::string_view apm_metadata_keywords = "OBJECT_NAME OBJECT_ID CENTER_NAME TIME_SYSTEM";

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
      check_ccsds_kind(kind, content_, {name_, number});
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
    if (message_.segments.empty() && contains_word(header_keywords, keyword)) return message_.header;
    CcsdsSegment& s = segment(line);
    if (s.data.entries.empty() && s.data.blocks.empty() && contains_word(apm_metadata_keywords, keyword))
      return s.metadata;
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
    if (open_.empty() || open_.back().name != entry.keyword)
      throw InputError({name_, entry.line}, fmt::format("{}_STOP without {}_START", entry.keyword, entry.keyword));
    CcsdsBlock block = std::move(open_.back());
    open_.pop_back();
    if (!open_.empty()) {
      open_.back().blocks.push_back(std::move(block));
    } else if (block.name == "META" && message_.kind != "APM") {
      if (!message_.segments.empty() && message_.segments.back().data.blocks.empty() && message_.kind == "AEM")
        throw InputError({name_, block.line}, "a second META_START before DATA_START");
      new_segment(block.line);
      message_.segments.back().metadata = std::move(block);
    } else {
      if (message_.segments.empty() && message_.kind != "APM")
        throw InputError({name_, block.line}, fmt::format("{}_START before META_START", block.name));
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

}  // namespace

bool is_ccsds_keyword(std::string_view word) {
  return !word.empty() && word.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == std::string_view::npos;
}

bool is_ccsds_kind(std::string_view kind) {
  return contains_word("APM AEM ACM OPM OMM OEM OCM TDM CDM RDM PRM NDM", kind);
}

bool is_wanted(std::string_view kind, CcsdsContent content) {
  return content == CcsdsContent::attitude ? contains_word("APM AEM ACM", kind) : kind == "OEM";
}

void check_ccsds_kind(std::string_view kind, CcsdsContent content, const SourceLocation& where) {
  if (is_wanted(kind, content)) return;
  throw InputError(
      where,
      content == CcsdsContent::attitude
          ? fmt::format("the message is of kind {}, which holds no attitude; attitude messages are APM, AEM and ACM",
                        kind)
          : fmt::format("the message is of kind {}, which holds no trajectory; an OEM is wanted", kind));
}

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
    return is_ccsds_kind(kind);
  }
  return false;
}

CcsdsFile parse_ccsds(std::string_view text, const std::string& name, CcsdsContent content) {
  const std::string_view unmarked = without_mark(text);
  const std::size_t first = unmarked.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && unmarked[first] == '<') return parse_ccsds_xml(text, name, content);
  return parse_kvn(unmarked, name, content);
}

}  // namespace polhode
