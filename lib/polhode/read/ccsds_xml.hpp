#pragma once

#include <string>
#include <string_view>

#include "polhode/read/ccsds_tree.hpp"

namespace polhode {

/// parse_ccsds() of a text in XML.
CcsdsFile parse_ccsds_xml(std::string_view text, const std::string& name, CcsdsContent content);

}  // namespace polhode
