#include "polhode/read/toml_table.hpp"

// toml++ 3.3 holds some broken input for impossible ("[" before a control character): an assertion, or undefined
// behaviour with NDEBUG. Without either it goes on to say what is wrong.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_cast<void>(0)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

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

std::size_t line_of(const toml::node& node) { return node.source().begin.line; }

}  // namespace

TomlTable TomlTable::parse(std::string_view text, const std::string& path) {
  try {
    auto document = std::make_shared<const toml::table>(toml::parse(text, path));
    return TomlTable(std::make_shared<const Node>(Node{document, document.get(), path, ""}));
  } catch (const toml::parse_error& problem) {
    throw InputError({path, problem.source().begin.line},
                     fmt::format("not valid TOML: {}", std::string(problem.description())));
  }
}

bool TomlTable::has(std::string_view key) const { return node_->table->contains(key); }

SourceLocation TomlTable::where(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  return {node_->path, line_of(value == nullptr ? *node_->table : *value)};
}

InputError TomlTable::error(std::string_view key, const std::string& message) const {
  return {where(key), fmt::format("{}{}: {}", node_->prefix, key, message)};
}

void TomlTable::allow_only(std::initializer_list<std::string_view> keys) const {
  for (const auto& [key, value] : *node_->table) {
    if (std::find(keys.begin(), keys.end(), key.str()) == keys.end()) {
      throw error(key.str(), fmt::format("unknown key; allowed here: {}", fmt::join(keys, ", ")));
    }
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

Matrix3 TomlTable::matrix3(std::string_view key) const {
  const toml::node* value = node_->table->get(key);
  if (value == nullptr) throw error(key, "this key is missing, three rows of three numbers are wanted");
  const toml::array* rows = value->as_array();
  std::vector<double> elements;
  if (rows != nullptr && rows->size() == 3) {
    for (const toml::node& row : *rows) {
      if (!row.is_array() || row.as_array()->size() != 3) break;
      for (const toml::node& element : *row.as_array()) elements.push_back(finite_number(key, {element}));
    }
  }
  if (elements.size() != 9)
    throw error(key, fmt::format("found {}, three rows of three numbers are wanted", kind(*value)));
  Matrix3 matrix;
  for (std::size_t i = 0; i < 9; ++i) matrix(static_cast<int>(i / 3), static_cast<int>(i % 3)) = elements[i];
  return matrix;
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
