#include "polhode/read/toml_table.hpp"

// toml++ takes some broken input for impossible, such as "[" before a control character: an assertion, or undefined
// behaviour with NDEBUG. Without either it goes on to say what is wrong. It is compiled here, so that this holds.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_cast<void>(0)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "polhode/base/text.hpp"
#include "polhode/read/range.hpp"

namespace polhode {

struct TomlTable::Node {
  std::shared_ptr<const toml::table> document;  // keeps `table` alive
  const toml::table* table = nullptr;
  std::string path;
  std::string prefix;  // "state." for messages

  std::shared_ptr<const Node> child(const toml::table& of, const std::string& name) const {
    return std::make_shared<const Node>(Node{document, &of, path, prefix + name + "."});
  }
};

namespace {

std::string kind(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return fmt::format("the text '{:.40}'", **node.as_string());
    case toml::node_type::integer:
      return fmt::format("the number {}", **node.as_integer());
    case toml::node_type::floating_point:
      return fmt::format("the number {}", **node.as_floating_point());
    case toml::node_type::boolean:
      return **node.as_boolean() ? "true" : "false";
    case toml::node_type::array:
      return fmt::format("a list of {}", node.as_array()->size());
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time without quotes";
  }
}

/// The word without quotes that is the value of a line `key = word`; empty if the line is another.
std::string_view bare_word(std::string_view text, std::size_t line) {
  for (std::size_t i = 1; i < line; ++i) take_line(text);
  const std::string_view content = take_line(text);
  const std::size_t equals = content.find('=');
  if (equals == std::string_view::npos) return {};
  const std::string_view value = trimmed(content.substr(equals + 1, content.find('#', equals) - equals - 1));
  const auto is_of_word = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' || c == '-' ||
           c == '_' || c == '.' || c == ' ';
  };
  const bool begins = !value.empty() && ((value[0] >= 'a' && value[0] <= 'z') || (value[0] >= 'A' && value[0] <= 'Z'));
  const bool is_word = begins && value.size() <= 60 && std::all_of(value.begin(), value.end(), is_of_word);
  return is_word && value != "true" && value != "false" && value != "inf" && value != "nan" ? value : "";
}

std::size_t line_of(const toml::node& node) { return node.source().begin.line; }

/// What is there for certain.
template <class T>
T& there(T* node) {
  if (node == nullptr) throw std::logic_error("a place in a document of TOML that is none");
  return *node;
}

toml::table& table_at(toml::table& document, const TomlTable::NumberWithSigma& place) {
  toml::node& section = there(document.get(place.section));
  if (toml::array* const list = section.as_array())
    return there(there(list->get(std::stoul(place.table) - 1)).as_table());
  return there(there(there(section.as_table()).get(place.table)).as_table());
}

/// The element that is meant of a number, a list or a matrix; null where there is none.
toml::node* element_at(toml::node* node, int row, int column) {
  for (const int place : {row, column}) {
    if (node == nullptr || place < 0) return node;
    toml::array* const list = node->as_array();
    node = list == nullptr || list->size() != 3 ? nullptr : list->get(static_cast<std::size_t>(place));
  }
  return node;
}

/// Takes the uncertainties out of the tables of a section.
class SigmaTaker {
 public:
  using Number = TomlTable::NumberWithSigma;
  SigmaTaker(const std::string& path, std::vector<Number>& taken) : path_(path), taken_(taken) {}

  void take(toml::table& document, std::string_view section) {
    Number place;
    place.section = section;
    toml::node* const found = document.get(section);
    if (found == nullptr) return;
    if (toml::array* const list = found->as_array()) {
      for (std::size_t i = 0; i < list->size(); ++i) {
        place.table = fmt::format("{}", i + 1);
        if (toml::table* const table = there(list->get(i)).as_table()) take_of(*table, place);
      }
    } else if (toml::table* const tables = found->as_table()) {
      for (auto&& [key, node] : *tables) {
        place.table = key.str();
        if (toml::table* const table = node.as_table()) take_of(*table, place);
      }
    }
  }

 private:
  static constexpr std::string_view kSigma = "_sigma";

  void take_of(toml::table& table, Number place) {
    std::vector<std::string> keys;
    for (auto&& [key, node] : table) {
      if (key.str().ends_with(kSigma)) keys.emplace_back(key.str());
    }
    for (const std::string& key : keys) {
      place.key = key.substr(0, key.size() - kSigma.size());
      toml::node& sigma = there(table.get(key));
      toml::node* const found = table.get(place.key);
      const auto refuse = [&](const char* message) {
        place.row = place.column = -1;
        return InputError({path_, line_of(sigma)}, fmt::format("{}_sigma: {}", place.name(), message));
      };
      if (found == nullptr) throw refuse("there is no number that it goes with");
      toml::node& number = *found;
      toml::array* const list = number.as_array();
      const bool is_list = list != nullptr, is_matrix = is_list && !list->empty() && there(list->get(0)).is_array();
      for (place.row = is_list ? 0 : -1; place.row < (is_list ? 3 : 0); ++place.row) {
        const int first = is_matrix ? place.row : -1;
        for (place.column = first; place.column < (is_matrix ? 3 : 0); ++place.column) {
          const auto value = value_at(number, place.row, place.column);
          const auto size = value_at(sigma, place.row, place.column);
          if (!value || !size) {
            throw refuse("an uncertainty has the form of its number: one, three, or three rows of three");
          }
          if (!(*size >= 0.0 && *size <= kGreatestSigmaRead))
            throw refuse("an uncertainty of 0 or more is wanted, up to 1e100");
          if (is_matrix && *size != value_at(sigma, place.column, place.row)) {
            throw refuse("found a matrix that is not symmetric; its elements are those of a symmetric one");
          }
          place.value = *value, place.sigma = *size;
          if (*size > 0.0) taken_.push_back(place);
        }
      }
      table.erase(key);
    }
  }

  static std::optional<double> value_at(toml::node& node, int row, int column) {
    const toml::node* const element = element_at(&node, row, column);
    if (element == nullptr || !element->is_number()) return std::nullopt;
    const auto value = element->value<double>();
    return value && std::isfinite(*value) ? value : std::nullopt;
  }

  const std::string& path_;
  std::vector<Number>& taken_;
};

/// Whether the text begins with a character from U+00A1 to U+0499, U+2C5E to U+3057 (but U+3000) or U+FB26 to U+FEFE:
/// toml++ takes them for impossible where it looks for white space, which is undefined behaviour.
bool is_never_expected(std::string_view text) {
  const std::string_view two = text.substr(0, 2), three = text.substr(0, 3);
  return (two >= "\xC2\xA1" && two <= "\xD2\x99") ||
         (three >= "\xE2\xB1\x9E" && three <= "\xE3\x81\x97" && three != "\xE3\x80\x80") ||
         (three >= "\xEF\xAC\xA6" && three <= "\xEF\xBB\xBE");
}

/// How deep tables and lists are nested: by brackets that are open, and by the parts of dotted keys.
class Nesting {
 public:
  /// The next character outside strings and comments; the depth behind it.
  std::size_t after(char c) {
    if (c == '[' || c == '{') {
      open_.push_back(around_);
      around_ += dots_ + 1;
      dots_ = 0;
    } else if (c == ']' || c == '}' || c == ',' || c == '\n') {
      if ((c == ']' || c == '}') && !open_.empty()) {
        around_ = open_.back();
        open_.pop_back();
      }
      dots_ = 0;
    } else if (c == '.') {
      ++dots_;
    }
    return around_ + dots_;
  }

 private:
  std::vector<std::size_t> open_;  // the depth around each open bracket
  std::size_t around_ = 0;         // the last of them
  std::size_t dots_ = 0;           // of the key, or number, that is being read
};

/// Refuses what toml++ does not survive: those characters where it would look for white space (outside strings and
/// comments, and in strings after a backslash), and depths at which its functions, which call themselves once a level,
/// overflow the stack. Follows the strings of valid TOML; behind an error that toml++ reports, it may refuse more.
void refuse_what_breaks_the_parser(std::string_view text, const std::string& path) {
  constexpr std::size_t most_levels = 100;
  const auto place = [&](std::size_t i) {
    const std::string_view before = text.substr(0, i);
    return SourceLocation{path, 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'))};
  };
  const auto check = [&](std::size_t i) {
    if (!is_never_expected(text.substr(i))) return;
    throw InputError(
        place(i),
        "not valid TOML: found a character that is allowed in comments and in quotes, but not after a backslash");
  };
  Nesting nesting;
  std::string_view quotes;  // that began the string at i
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = text.substr(i);
    if (quotes.empty()) {
      check(i);
      if (rest[0] == '#') {
        i = std::min(text.find('\n', i), text.size());
        continue;
      }
      if (nesting.after(rest[0]) > most_levels) {
        throw InputError(place(i), fmt::format("tables or lists are nested more than {} levels deep", most_levels));
      }
      const bool may_begin = i == 0 || std::string_view(" \t\r\n=,[{.").find(text[i - 1]) != std::string_view::npos;
      for (const std::string_view some : {"'", "\"", "'''", "\"\"\""}) {
        if (may_begin && rest.starts_with(some)) quotes = some;  // elsewhere toml++ goes on with what stands before
      }
      i += std::max<std::size_t>(quotes.size(), 1);
    } else if (rest.starts_with(quotes)) {
      i += quotes.size();
      for (int more = 0; more < 2 && quotes.size() == 3 && text.substr(i, 1) == quotes.substr(0, 1); ++more) ++i;
      quotes = {};
    } else if (rest[0] == '\\' && quotes[0] == '"') {
      const std::size_t next = std::min(text.find_first_not_of(" \t\r\n", i + 1), text.size());
      check(next);
      i = next == i + 1 ? i + 2 : next;  // an escaped character, or a line that goes on
    } else {
      ++i;
    }
  }
}

}  // namespace

TomlTable TomlTable::parse(std::string_view text, const std::string& path) {
  std::vector<NumberWithSigma> none;
  return parse_with_sigmas(text, path, {}, none);
}

TomlTable TomlTable::parse_with_sigmas(std::string_view text, const std::string& path,
                                       std::initializer_list<std::string_view> sections,
                                       std::vector<NumberWithSigma>& taken) {
  constexpr std::size_t most_bytes = 16U << 20U;
  if (text.size() > most_bytes) {
    throw InputError({path, 0}, fmt::format("is too large for TOML: at most {} MiB are read", most_bytes >> 20U));
  }
  refuse_what_breaks_the_parser(text, path);
  try {
    auto document = std::make_shared<toml::table>(toml::parse(text, path));
    for (const std::string_view section : sections) SigmaTaker(path, taken).take(*document, section);
    return TomlTable(std::make_shared<const Node>(Node{document, document.get(), path, ""}));
  } catch (const toml::parse_error& problem) {
    const std::size_t line = problem.source().begin.line;
    const std::string_view word = bare_word(text, line);
    if (!word.empty()) {
      throw InputError({path, line}, fmt::format("not valid TOML: {0} is text, which stands in quotes: \"{0}\"", word));
    }
    throw InputError({path, line}, fmt::format("not valid TOML: {}", std::string(problem.description())));
  }
}

std::string TomlTable::NumberWithSigma::name() const {
  std::string out = fmt::format("{}.{}.{}", section, table, key);
  if (row >= 0) out += fmt::format(".{}", "xyz"[row]);
  if (column >= 0) out += "xyz"[column];
  return out;
}

TomlTable TomlTable::with_values(std::span<const NumberWithSigma> numbers) const {
  auto document = std::make_shared<toml::table>(*node_->document);
  for (const NumberWithSigma& number : numbers) {
    toml::table& table = table_at(*document, number);
    if (number.row < 0) {
      table.insert_or_assign(number.key, number.value);
      continue;
    }
    for (const auto& [row, column] : {std::pair(number.row, number.column), std::pair(number.column, number.row)}) {
      if (row < 0) continue;
      toml::array& list = there(there(table.get(number.key)).as_array());
      toml::array& numbers_of = column < 0 ? list : there(there(list.get(static_cast<std::size_t>(row))).as_array());
      numbers_of.replace(numbers_of.cbegin() + (column < 0 ? row : column), number.value);
    }
  }
  return TomlTable(std::make_shared<const Node>(Node{document, document.get(), node_->path, ""}));
}

bool TomlTable::has(std::string_view key) const { return node_->table->contains(key); }

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : *node_->table) names.emplace_back(key.str());
  return names;
}

SourceLocation TomlTable::where(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  return {node_->path, line_of(value == nullptr ? *node_->table : *value)};
}

InputError TomlTable::error(std::string_view key, const std::string& message) const {
  return {where(key), fmt::format("{}{}: {}", node_->prefix, key, message)};
}

void TomlTable::allow_only(std::span<const std::string_view> keys) const { allow_only(keys, {}); }

void TomlTable::allow_only(std::span<const std::string_view> keys, std::span<const std::string_view> with_sigma) const {
  constexpr std::string_view sigma = "_sigma";
  const auto among = [](std::span<const std::string_view> names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const auto& [key, value] : *node_->table) {
    const std::string_view name = key.str();
    if (among(keys, name) || among(with_sigma, name)) continue;
    if (name.ends_with(sigma) && among(with_sigma, name.substr(0, name.size() - sigma.size()))) {
      const std::string_view number = name.substr(0, name.size() - sigma.size());
      if (!has(number)) throw error(name, fmt::format("goes with {}, which is not given", number));
      continue;
    }
    std::string allowed = fmt::format("{}{}{}", fmt::join(with_sigma, ", "),
                                      keys.empty() || with_sigma.empty() ? "" : ", ", fmt::join(keys, ", "));
    if (!with_sigma.empty()) {
      allowed += fmt::format(", and uncertainties: {}_sigma", fmt::join(with_sigma, "_sigma, "));
    }
    throw error(name, fmt::format("unknown key; allowed here: {}", allowed));
  }
}

std::string_view TomlTable::one_of(std::initializer_list<std::string_view> keys) const {
  std::string_view found;
  for (const std::string_view key : keys) {
    if (!has(key)) continue;
    if (!found.empty()) throw error(key, fmt::format("cannot stand beside {}; one of them is enough", found));
    found = key;
  }
  if (found.empty()) {
    throw InputError({node_->path, line_of(*node_->table)},
                     fmt::format("{}one of these keys is needed: {}", node_->prefix.empty() ? "" : node_->prefix + " ",
                                 fmt::join(keys, ", ")));
  }
  return found;
}

bool TomlTable::is_number(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  return value != nullptr && value->is_number();
}

bool TomlTable::is_array(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  return value != nullptr && value->is_array();
}

std::optional<std::string> TomlTable::optional_text(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_string()) throw error(key, fmt::format("found {}, text in quotes is wanted", kind(*value)));
  return **value->as_string();
}

std::string TomlTable::text(std::string_view key) const {
  if (auto value = optional_text(key)) return *value;
  throw error(key, "this key is missing, text is wanted");
}

std::string TomlTable::file_name(std::string_view key) const {
  std::string name = text(key);
  if (name.empty()) throw error(key, "found '', the name of a file is wanted");
  if (name.find('\0') != std::string::npos) {
    throw error(key, "found a text that holds the character U+0000, which no name of a file does");
  }
  return name;
}

struct TomlTable::Element {
  const toml::node& node;
};

double TomlTable::finite_number(std::string_view key, const Element& element) const {
  const toml::node& node = element.node;
  if (const auto* integer = node.as_integer()) return static_cast<double>(**integer);
  const auto* floating = node.as_floating_point();
  if (floating != nullptr && std::isfinite(**floating)) return **floating;
  throw InputError({node_->path, line_of(node)},
                   fmt::format("{}{}: found {}, a finite number is wanted", node_->prefix, key, kind(node)));
}

double TomlTable::number(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  if (value == nullptr) throw error(key, "this key is missing, a number is wanted");
  return finite_number(key, {*value});
}

double TomlTable::positive_number(std::string_view key) const {
  const double found = number(key);
  if (!(found > 0.0)) throw error(key, fmt::format("found {}, a positive number is wanted", found));
  return found;
}

std::vector<double> TomlTable::numbers(std::string_view key, std::size_t count) const {
  const toml::node* value = node_->table->get(key);
  if (value == nullptr) throw error(key, fmt::format("this key is missing, a list of {} numbers is wanted", count));
  const toml::array* list = value->as_array();
  if (list == nullptr || list->size() != count) {
    throw error(key, fmt::format("found {}, a list of {} numbers is wanted", kind(*value), count));
  }
  std::vector<double> out;
  for (const toml::node& element : *list) out.push_back(finite_number(key, {element}));
  return out;
}

Vector3 TomlTable::vector3(std::string_view key) const {
  const std::vector<double> v = numbers(key, 3);
  return {v[0], v[1], v[2]};
}

std::vector<std::vector<double>> TomlTable::square(std::string_view key, std::size_t size) const {
  const toml::node* value = node_->table->get(key);
  const std::string wanted =
      size == 3 ? "three rows of three numbers are wanted" : fmt::format("{0} rows of {0} numbers are wanted", size);
  if (value == nullptr) throw error(key, "this key is missing, " + wanted);
  const toml::array* rows = value->as_array();
  if (rows == nullptr || rows->size() != size) throw error(key, fmt::format("found {}, {}", kind(*value), wanted));
  std::vector<std::vector<double>> matrix;
  for (const toml::node& row : *rows) {
    if (!row.is_array() || row.as_array()->size() != size) {
      throw InputError({node_->path, line_of(row)},
                       fmt::format("{}{}: found {} in the place of a row, {}", node_->prefix, key, kind(row), wanted));
    }
    std::vector<double>& numbers = matrix.emplace_back();
    for (const toml::node& element : *row.as_array()) numbers.push_back(finite_number(key, {element}));
  }
  return matrix;
}

Matrix3 TomlTable::matrix3(std::string_view key) const {
  const std::vector<std::vector<double>> rows = square(key, 3);
  Matrix3 matrix;
  for (int i = 0; i < 3; ++i) matrix.row(i) = Eigen::Map<const Vector3>(rows[static_cast<std::size_t>(i)].data());
  return matrix;
}

std::vector<std::string> TomlTable::texts(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  constexpr const char* wanted = "a list of texts in quotes is wanted";
  if (value == nullptr) throw error(key, fmt::format("this key is missing, {}", wanted));
  if (!value->is_array()) throw error(key, fmt::format("found {}, {}", kind(*value), wanted));
  std::vector<std::string> out;
  for (const toml::node& element : *value->as_array()) {
    if (!element.is_string()) throw error(key, fmt::format("found {}, {}", kind(element), wanted));
    out.push_back(**element.as_string());
  }
  return out;
}

TomlTable TomlTable::table(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  if (value == nullptr) throw error(key, "this table is missing");
  if (!value->is_table()) throw error(key, fmt::format("found {}, a table is wanted", kind(*value)));
  return TomlTable(node_->child(*value->as_table(), std::string(key)));
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  if (value == nullptr) return {};
  if (!value->is_array_of_tables()) {
    throw error(key, fmt::format("found {}, tables headed [[{}]] are wanted", kind(*value), key));
  }
  std::vector<TomlTable> out;
  for (const toml::node& element : *value->as_array()) {
    out.push_back(TomlTable(node_->child(*element.as_table(), std::string(key))));
  }
  return out;
}

}  // namespace polhode
