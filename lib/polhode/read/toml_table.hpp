#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/geometry.hpp"

namespace polhode {

/// A table of a TOML file, read strictly: every failure is an InputError with file, line, key, what was found and what
/// is wanted. Numbers are finite. Tables share the document, which lives as long as any of them.
class TomlTable {
 public:
  /// The document's root table. `path` is for messages.
  static TomlTable parse(std::string_view text, const std::string& path);

  /// A number in a table of a section of a document, beside which its uncertainty stands under KEY_sigma.
  struct NumberWithSigma {
    std::string section, table;  ///< [[section]] number `table` from 1, or [section.table]
    std::string key;             ///< of a number, of a list of three, or of a symmetric matrix of three rows
    int row = -1, column = -1;   ///< of the list or matrix; -1: there is none
    double value = 0.0, sigma = 0.0;

    /// "torque.2.quality_factor", "torque.1.torque_n_m.x", "orbit.earth.mu_m3_s2"
    std::string name() const;
  };
  /// The same of a document in which the tables of these sections may hold uncertainties: those that are not 0 are
  /// taken out of it. Throws InputError where a sigma has no number, another form, or is negative.
  static TomlTable parse_with_sigmas(std::string_view text, const std::string& path,
                                     std::initializer_list<std::string_view> sections,
                                     std::vector<NumberWithSigma>& taken);
  /// The document, of which this is the root, with their `value`s in the place of those numbers. Messages about it name
  /// no lines.
  TomlTable with_values(std::span<const NumberWithSigma> numbers) const;

  bool has(std::string_view key) const;
  bool is_number(std::string_view key) const;
  bool is_array(std::string_view key) const;
  std::vector<std::string> keys() const;
  /// Refuses any key that is not among these.
  void allow_only(std::span<const std::string_view> keys) const;
  void allow_only(std::initializer_list<std::string_view> keys) const {
    allow_only(std::span(keys.begin(), keys.size()));
  }
  /// The same, and of each key in `with_sigma` also its uncertainty, KEY_sigma: refuses one without its key.
  void allow_only(std::span<const std::string_view> keys, std::span<const std::string_view> with_sigma) const;
  void allow_only(std::initializer_list<std::string_view> keys,
                  std::initializer_list<std::string_view> with_sigma) const {
    allow_only(std::span(keys.begin(), keys.size()), std::span(with_sigma.begin(), with_sigma.size()));
  }
  /// The one of these keys that is there; refuses none and two.
  std::string_view one_of(std::initializer_list<std::string_view> keys) const;

  std::string text(std::string_view key) const;
  /// A text that can name a file: neither empty nor with a U+0000, at which the system would cut it.
  std::string file_name(std::string_view key) const;
  std::optional<std::string> optional_text(std::string_view key) const;
  double number(std::string_view key) const;
  double positive_number(std::string_view key) const;
  std::vector<double> numbers(std::string_view key, std::size_t count) const;
  Vector3 vector3(std::string_view key) const;
  Matrix3 matrix3(std::string_view key) const;
  /// A list of as many lists of as many numbers.
  std::vector<std::vector<double>> square(std::string_view key, std::size_t size) const;
  std::vector<std::string> texts(std::string_view key) const;
  TomlTable table(std::string_view key) const;
  /// The elements of an array of tables; none if the key is absent.
  std::vector<TomlTable> tables(std::string_view key) const;

  /// Where a key stands, or the table if it is absent.
  SourceLocation where(std::string_view key) const;
  /// An error about a key's value.
  InputError error(std::string_view key, const std::string& message) const;
  /// Runs `work`, and gives an InputError of its own the place of this key.
  template <class Work>
  auto located(std::string_view key, const Work& work) const {
    try {
      return work();
    } catch (const InputError& problem) {
      throw error(key, problem.what());
    }
  }
  /// What `parse` makes of a text.
  template <class Parse>
  auto parsed(std::string_view key, const Parse& parse) const {
    const std::string value = text(key);
    return located(key, [&] { return parse(value); });
  }
  /// Runs `work`, which opens the file that this key names, and puts the key's place before a FileError of its own.
  template <class Work>
  auto opened(std::string_view key, const Work& work) const {
    try {
      return work();
    } catch (const FileError& problem) {
      throw FileError(error(key, problem.what()).what());
    }
  }

 private:
  struct Node;
  struct Element;
  explicit TomlTable(std::shared_ptr<const Node> node) : node_(std::move(node)) {}
  double finite_number(std::string_view key, const Element& element) const;

  std::shared_ptr<const Node> node_;
};

}  // namespace polhode
