#include "polhode/read/body.hpp"

#include <fmt/format.h>

#include "polhode/read/body_file.hpp"
#include "polhode/read/ccsds_attitude.hpp"
#include "polhode/read/ccsds_tree.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

/// Of several messages the one that lacks least, the first of them.
Body body_of_messages(const std::string& text, const std::string& path) {
  std::vector<CcsdsAttitudeMessage> messages = parse_ccsds_attitude(text, path);
  std::size_t best = 0;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    if (messages[i].body.missing.size() < messages[best].body.missing.size()) best = i;
  }
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (i == best) continue;
    messages[best].body.notes.push_back(fmt::format("the file also holds an {} {} of {}", messages[i].kind,
                                                    messages[i].version, messages[i].body.name));
  }
  return std::move(messages[best].body);
}

}  // namespace

Body read_body(const std::string& path) {
  const std::string text = read_text_file(path);
  if (is_ccsds(text)) return body_of_messages(text, path);
  return parse_body_file(text, path);
}

}  // namespace polhode
