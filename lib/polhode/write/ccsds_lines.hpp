#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "polhode/ephemeris/ephemeris.hpp"

namespace polhode {

/// `name = value` as a line of a CCSDS message in KVN; "unknown" for an empty value, which may not be missing. Throws
/// InputError where it would be longer than CCSDS 504.0-B allows.
std::string kvn_line(std::string_view name, std::string_view value);

/// The same as an element of XML.
std::string xml_element(std::string_view name, std::string_view value);

/// COMMENT lines, as many as the text needs; and the element.
std::string kvn_comment(std::string_view text);
std::string xml_comment(std::string_view text);

/// What an ephemeris says of itself, for comments: its method, error, cautions, interpolation and source.
std::vector<std::string> comments_on(const EphemerisDescription& description);

}  // namespace polhode
