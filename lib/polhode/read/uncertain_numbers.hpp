#pragma once

#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/body/uncertainty.hpp"
#include "polhode/read/toml_table.hpp"

namespace polhode {

/// The covariance of these numbers of a file, of which each has a sigma, or 0: they are independent, but for those that
/// the table [uncertainty] of `root` lists. Throws InputError where it lists what is not among them (they are `which`),
/// or its covariance is none or gives one of them another sigma.
Eigen::MatrixXd covariance_in_file(const TomlTable& root, std::span<const PublishedNumber> numbers,
                                   std::span<const double> sigmas, std::string_view which);

/// Makes a part of a body of the numbers of its file, or of others in their place: all else that the file says of this
/// part is in it. Throws InputError where no body has them.
using BodyPart = std::function<void(std::span<const double> numbers, Body& body)>;

/// The numbers of a body file that may have an uncertainty, gathered while it is read: what a change of each does to
/// the body at its epoch, and how the body is made of them, so that clones are made as the body is.
class UncertainNumbers {
 public:
  /// The numbers of a key, one or several; `parts` are their names behind the key's ("x", "y", "z"; empty for a single
  /// number). KEY_sigma may stand beside. Returns the place of the first among all numbers.
  std::size_t add(const TomlTable& table, std::string_view key, std::initializer_list<std::string_view> parts = {});
  /// The elements of a symmetric matrix: xx, xy, xz, yy, yz, zz.
  std::size_t add_symmetric(const TomlTable& table, std::string_view key);
  /// What the numbers from this place on do, per unit of the file's number.
  void set_changes(std::size_t place, std::vector<EpochChange> changes);

  std::span<const double> values() const { return values_; }

  /// Makes a part of the body of the numbers that are there, here and now, and later of those of clones.
  void make(Body& body, BodyPart part);
  /// A number that is published beside others from which it follows: it may have a sigma, which changes nothing.
  static double sigma_beside(const TomlTable& table, std::string_view key);

  /// Lets what is known later act on the changes of all numbers that are there.
  void follow(const std::function<void(EpochChange&)>& effect);

  /// What is uncertain: numbers with a sigma, and those of the table [uncertainty] of `root`, if it has one. Null: all
  /// are exact. `blank` is the body before any of its parts is made.
  std::shared_ptr<const Uncertainty> uncertainty(const TomlTable& root, Body blank) const;

 private:
  std::vector<PublishedNumber> numbers_;
  std::vector<double> sigmas_;  // of the numbers
  std::vector<double> values_;  // of the numbers
  std::vector<BodyPart> parts_;
};

}  // namespace polhode
