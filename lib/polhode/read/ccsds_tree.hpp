#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/base/error.hpp"

namespace polhode {

/// `keyword = value [unit]` of a CCSDS message, or an XML element with its `units` attribute.
struct CcsdsEntry {
  std::string keyword;
  std::string value;
  std::string unit;  ///< empty: none given
  std::size_t line = 0;
};

/// A data line of numbers. KVN and the lines of an ACM have values without keywords, an attitudeState of XML has both.
struct CcsdsRow {
  std::vector<CcsdsEntry> cells;
  std::size_t line = 0;
};

/// What stands between X_START and X_STOP, in the file's order of each kind. Comments are left out.
struct CcsdsBlock {
  std::string name;      ///< "QUAT", "META", "SENSOR" …
  std::size_t line = 0;  ///< of its start
  std::vector<CcsdsEntry> entries;
  std::vector<CcsdsRow> rows;
  std::vector<CcsdsBlock> blocks;
};

struct CcsdsSegment {
  CcsdsBlock metadata;
  CcsdsBlock data;
};

/// A message, the same from KVN (CCSDS 504.0-B-2 section 6, 502.0-B-3 section 7) and from XML (section 7 and 8). The
/// states of an OEM are the rows of its `data`.
struct CcsdsMessage {
  std::string kind;     ///< "APM", "AEM", "ACM" or "OEM"
  std::string version;  ///< as written
  bool xml = false;
  CcsdsBlock header;  ///< its line is that of the version
  std::vector<CcsdsSegment> segments;
};

/// Which messages are wanted: attitude (APM, AEM, ACM), or trajectories (OEM).
enum class CcsdsContent { attitude, orbit };

/// Whether a message of this kind is wanted.
bool is_wanted(std::string_view kind, CcsdsContent content);
/// Throws InputError unless it is.
void check_ccsds_kind(std::string_view kind, CcsdsContent content, const SourceLocation& where);
/// Whether CCSDS has a navigation message of this kind: "APM", "OPM" …
bool is_ccsds_kind(std::string_view kind);
/// Capital letters, digits and _.
bool is_ccsds_keyword(std::string_view word);

/// The wanted messages of a file, and what else a combined message holds.
struct CcsdsFile {
  std::vector<CcsdsMessage> messages;
  std::vector<std::string> other_messages;  ///< "OPM" … in an NDM, not read
};

/// Whether the text starts like a CCSDS navigation message, in KVN or XML.
bool is_ccsds(std::string_view text);

/// Splits a file into messages, segments, blocks and entries, without regard to which keywords may stand where. Throws
/// InputError with file and line: lines that are neither `keyword = value`, comment, start or stop of a block nor data;
/// blocks that do not nest; broken XML; elements that no message has; a kind of message that is not wanted.
CcsdsFile parse_ccsds(std::string_view text, const std::string& name, CcsdsContent content = CcsdsContent::attitude);
CcsdsFile parse_ccsds_xml(std::string_view text, const std::string& name, CcsdsContent content);  ///< of a text in XML

}  // namespace polhode
