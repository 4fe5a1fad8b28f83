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

BodyAndHistory read_ccsds_attitude(const std::string& text, const RowOfFile& place, const ContentOf&) {
  std::vector<CcsdsAttitudeMessage> messages = parse_ccsds_attitude(text, place.file);
  std::optional<AttitudeHistory> history;
  std::size_t best = 0;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (messages[i].body.missing.size() < messages[best].body.missing.size()) best = i;
    if (!messages[i].history) continue;
    if (!history) {
      history = std::move(messages[i].history);
    } else {
      history->warnings.push_back(
          fmt::format("{}: a further attitude history, of {}; the first is used", place.file, messages[i].body.name));
    }
  }
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (i == best) continue;
    messages[best].body.notes.push_back(fmt::format("the file also holds an {} {} of {}", messages[i].kind,
                                                    messages[i].version, messages[i].body.name));
  }
  return {std::move(messages[best].body), std::move(history)};
}

}  // namespace polhode
