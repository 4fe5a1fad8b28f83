#include "polhode/read/body.hpp"

#include "polhode/read/body_file.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {

Body read_body(const std::string& path) { return parse_body_file(read_text_file(path), path); }

}  // namespace polhode
