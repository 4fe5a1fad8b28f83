#include "polhode/read/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "polhode/base/text.hpp"

namespace polhode {
namespace {

/// Takes a scalar of YAML off the text: in quotes of either kind, or plain as far as one of `ends`.
std::string take_scalar(std::string_view& text, std::string_view ends) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const char quote = text.empty() ? ' ' : text[0];
  if (quote != '"' && quote != '\'') {
    const std::string_view plain = text.substr(0, text.find_first_of(ends));
    text.remove_prefix(plain.size());
    return std::string(trimmed(plain));
  }
  std::string value;
  std::size_t i = 1;
  for (; i < text.size(); ++i) {
    const bool next_as_it_is = quote == '"' ? text[i] == '\\' : text[i] == quote && text.substr(i + 1, 1) == "'";
    if (next_as_it_is && i + 1 < text.size()) {
      ++i;
    } else if (text[i] == quote) {
      break;
    }
    value += text[i];
  }
  text.remove_prefix(std::min(i + 1, text.size()));
  return value;
}

/// The entries of "{name: x, unit: km}", wherever it begins in the text.
std::vector<std::pair<std::string, std::string>> flow_entries(std::string_view text) {
  std::vector<std::pair<std::string, std::string>> entries;
  std::size_t begin = text.find('{');
  while (begin < text.size()) {
    text.remove_prefix(begin + 1);
    std::string key = take_scalar(text, ":}");
    if (!text.starts_with(':')) break;
    text.remove_prefix(1);
    entries.emplace_back(std::move(key), take_scalar(text, ",}"));
    begin = text.find(',');
  }
  return entries;
}

/// "time" of "!astropy.table.SerializedColumn {name: time}".
std::string column_in(std::string_view value) {
  for (auto& [key, name] : flow_entries(value)) {
    if (key == "name") return std::move(name);
  }
  return {};
}

constexpr bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

}  // namespace

void split_cells(std::string_view line, bool comma, std::vector<std::string>& cells) {
  std::string_view rest = trimmed(line);
  std::size_t count = 0;
  for (bool more = comma || !rest.empty(); more; ++count) {
    std::size_t end = 0;
    bool quoted = false;
    while (end < rest.size() && (quoted || !(comma ? rest[end] == ',' : is_blank(rest[end])))) {
      if (rest[end] == '"') quoted = !quoted;
      ++end;
    }
    if (quoted) end = std::min(comma ? rest.find(',') : rest.find_first_of(" \t"), rest.size());  // never closed
    const std::string_view written = trimmed(rest.substr(0, end));
    if (cells.size() == count) cells.emplace_back();
    std::string& cell = cells[count];
    cell = written;
    if (written.size() > 1 && written.front() == '"' && written.back() == '"') {
      cell.clear();
      for (std::size_t i = 1; i + 1 < written.size(); ++i) {
        cell += written[i];
        if (written[i] == '"' && written[i + 1] == '"') ++i;
      }
    }
    more = end < rest.size();
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (!comma) rest = trimmed(rest);
  }
  cells.resize(count);
}

std::string_view EcsvHeader::find(const Texts& texts, std::string_view key) {
  const auto found = std::find_if(texts.begin(), texts.end(), [&](const auto& text) { return text.first == key; });
  return found == texts.end() ? std::string_view() : found->second;
}

void EcsvHeader::take(std::string_view comment) {
  comment = trimmed(comment);
  if (comment.starts_with("- {")) {
    Texts entries = flow_entries(comment);
    if (!entries.empty() && entries[0].first == "name") {
      units_.emplace_back(entries[0].second, find(entries, "unit"));
    } else {
      std::move(entries.begin(), entries.end(), std::back_inserter(entries_));
    }
    return;
  }
  const std::size_t colon = comment.find(':');
  if (colon == std::string_view::npos) return;
  const std::string_view key = comment.substr(0, colon), value = trimmed(comment.substr(colon + 1));
  if (key == "scale") scale_ = value;
  if (key == "__class__") {
    in_time_ = time_.format.empty() && value == "astropy.time.core.Time";
    if (in_time_) time_.name = last_key_;
  } else if (value.empty()) {
    last_key_ = key;
    in_time_ = false;
  } else if (in_time_) {
    if (key == "format") time_.format = value;
    if (key == "scale") time_.scale = value;
    if (key == "value") time_.value = column_in(value);
    if (key == "jd1") time_.jd1 = column_in(value);
    if (key == "jd2") time_.jd2 = column_in(value);
  }
}

TextTable::TextTable(std::string_view text, std::string path, Comments comments)
    : rest_(without_mark(text)), path_(std::move(path)), comments_(comments) {
  const std::string_view line = take_content();
  if (line.empty()) return;
  comma_ = line.find(',') != std::string_view::npos;
  split_cells(line, comma_, names_);
}

/// The next line that is neither blank nor a comment; empty at the end. Comments before the names are the header.
std::string_view TextTable::take_content() {
  while (!rest_.empty()) {
    std::string_view content = trimmed(take_line(rest_));
    ++line_;
    if (content.starts_with('#')) {
      if (names_.empty()) header_.take(content.substr(1));
      continue;
    }
    if (comments_ == Comments::anywhere) content = trimmed(content.substr(0, content.find('#')));
    if (!content.empty()) return content;
  }
  return {};
}

std::size_t TextTable::column(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found != names_.end() && std::find(found + 1, names_.end(), name) != names_.end()) {
    throw error(fmt::format("there are two columns {:.40}", name));
  }
  return static_cast<std::size_t>(found - names_.begin());
}

void TextTable::check_unit(std::size_t column, std::string_view allowed) const {
  const std::string_view unit = header_.unit(names_[column]);
  if (unit.empty() || contains_word(allowed, unit)) return;
  throw error(fmt::format("column {:.40} has the unit {:.20} by the header; {} is wanted", names_[column], unit,
                          allowed.empty() ? "none" : allowed));
}

bool TextTable::next() {
  const std::string_view line = take_content();
  if (line.empty()) return false;
  split_cells(line, comma_, cells_);
  if (cells_.size() != names_.size()) throw error(fmt::format("{} cells; {} are wanted", cells_.size(), names_.size()));
  return true;
}

double TextTable::number(std::size_t column) const {
  const std::optional<double> value = parse_number(cells_[column]);
  if (!value) throw error(fmt::format("'{:.40}' is not a number", cells_[column]));
  return *value;
}

}  // namespace polhode
