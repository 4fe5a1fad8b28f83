#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/body/uncertainty.hpp"
#include "polhode/read/toml_table.hpp"

namespace polhode {

/// The numbers of a body file that may have an uncertainty, gathered while it is read: with what a change of each does
/// to the body at its epoch.
class UncertainNumbers {
 public:
  /// The numbers of a key, one or several; `parts` are their names behind the key's ("x", "y", "z"; empty for a single
  /// number), and `changes` what each does, per unit of the file's number. KEY_sigma may stand beside.
  void add(const TomlTable& table, std::string_view key, std::initializer_list<std::string_view> parts,
           std::vector<EpochChange> changes);
  /// The elements of a symmetric matrix, each of which stands in two places: xx, xy, xz, yy, yz, zz.
  void add_symmetric(const TomlTable& table, std::string_view key, std::vector<EpochChange> changes);
  /// A number that is published beside others from which it follows: it may have a sigma, which changes nothing.
  static double sigma_beside(const TomlTable& table, std::string_view key);

  /// Lets what is known later act on the changes of all numbers that are there.
  void follow(const std::function<void(EpochChange&)>& effect);

  /// What is uncertain: numbers with a sigma, and those of the table [uncertainty] of `root`, if it has one. Null: all
  /// are exact. `read` reads the body of the same file with other numbers.
  std::shared_ptr<const Uncertainty> uncertainty(const TomlTable& root,
                                                 std::function<Body(const TomlTable& root)> read) const;

 private:
  struct Number {
    PublishedNumber published;
    std::vector<TomlTable::Place> places;
    double sigma = 0.0;
  };
  std::vector<Number> numbers_;
};

}  // namespace polhode
