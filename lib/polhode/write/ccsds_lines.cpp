#include "polhode/write/ccsds_lines.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"
#include "polhode/write/document.hpp"

namespace polhode {
namespace {

constexpr std::size_t longest_line = 254;  // of a message in KVN by CCSDS 504.0-B, without its end

std::string xml_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// A value may not be missing.
std::string value_text(std::string_view value) {
  std::string plain = plain_text(value);
  return plain.empty() ? "unknown" : plain;
}

}  // namespace

std::string kvn_line(std::string_view name, std::string_view value) {
  const std::string text = value_text(value);
  std::string line = fmt::format("{} = {}\n", name, text);
  if (line.size() > longest_line + 1) {
    throw InputError(
        fmt::format("{} has {} bytes; with its keyword a line of a CCSDS message has {} at most: shorten it, "
                    "or write XML, which has no such limit",
                    name, text.size(), longest_line));
  }
  return line;
}

std::string xml_element(std::string_view name, std::string_view value) {
  return fmt::format("<{0}>{1}</{0}>\n", name, xml_escaped(value_text(value)));
}

std::string kvn_comment(std::string_view text) {
  constexpr std::string_view keyword = "COMMENT ";
  const std::string plain = plain_text(text);
  std::string_view rest = plain;
  std::string lines;
  do {
    std::size_t end = rest.size();
    if (end > longest_line - keyword.size()) {
      end = longest_line - keyword.size();
      const std::size_t blank = rest.rfind(' ', end);
      const auto is_inside_character = [&] { return (static_cast<unsigned char>(rest[end]) & 0xC0U) == 0x80U; };
      if (blank != std::string_view::npos && blank > 0) {
        end = blank;
      } else {
        while (end > 1 && is_inside_character()) --end;
      }
    }
    lines += fmt::format("{}{}\n", keyword, rest.substr(0, end));
    rest.remove_prefix(end);
    while (rest.starts_with(' ')) rest.remove_prefix(1);
  } while (!rest.empty());
  return lines;
}

std::string xml_comment(std::string_view text) {
  return fmt::format("<COMMENT>{}</COMMENT>\n", xml_escaped(plain_text(text)));
}

std::vector<std::string> comments_on(const EphemerisDescription& description) {
  std::vector<std::string> texts{fmt::format("Method: {}.", description.method)};
  if (description.promised_error_rad) {
    texts.push_back(fmt::format("Promised error of the rows: {:.1e} rad ({}).", *description.promised_error_rad,
                                description.error_meaning));
  } else if (!description.error_meaning.empty()) {
    texts.push_back(fmt::format("Error of the rows: {}.", description.error_meaning));
  }
  if (description.torque_evaluations) {
    texts.push_back(fmt::format("Torque evaluations: {}.", *description.torque_evaluations));
  }
  for (const std::string& caution : description.cautions) texts.push_back("Caution: " + caution + ".");
  if (description.tolerance_rad) {
    texts.push_back(
        fmt::format("Between rows, {}: within {:.3e} rad.", description.interpolation, *description.tolerance_rad));
  }
  if (!description.source.empty()) texts.push_back("Source of the body: " + description.source);
  return texts;
}

}  // namespace polhode
