#include "polhode/read/ccsds_attitude.hpp"

#include <fmt/format.h>

#include "polhode/read/ccsds_reader.hpp"

namespace polhode {

std::vector<CcsdsAttitudeMessage> parse_ccsds_attitude(std::string_view text, const std::string& name) {
  const CcsdsFile file = parse_ccsds(text, name);
  std::vector<CcsdsAttitudeMessage> messages;
  for (const CcsdsMessage& m : file.messages) {
    messages.push_back((m.kind == "APM" ? read_apm : m.kind == "AEM" ? read_aem : read_acm)(m, name));
  }
  for (const std::string& other : file.other_messages) {
    messages.front().body.notes.push_back(fmt::format("the file also holds an {}, not read", other));
  }
  return messages;
}

}  // namespace polhode
