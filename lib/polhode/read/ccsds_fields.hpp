#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/geometry.hpp"
#include "polhode/read/ccsds_tree.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

/// What a keyword's value must be.
enum class CcsdsValue {
  text,
  number,
  not_negative,
  positive,
  not_positive,
  not_zero,
  angle,       ///< -360 to 360 deg
  integer,     ///< above 0
  epoch,       ///< a calendar date
  time,        ///< a calendar date, or seconds from EPOCH_TZERO
  vector,      ///< three numbers
  quaternion,  ///< four numbers, scalar last, of unit length
  numbers,     ///< one or more, not negative
  sequence,    ///< three axes, no two neighbours alike
};

/// Whether a keyword may or must stand in version 1 (bits 1 and 2) and in version 2 of the standard (bits 4 and 8).
enum class CcsdsUse {
  optional_v1 = 1,
  required_v1 = 3,
  optional_v2 = 4,
  required_v2 = 12,
  optional = 5,
  required = 15,
  required_v2_optional_v1 = 13,
};

/// A row of the standard's tables of keywords.
struct CcsdsRule {
  std::string_view keywords;  ///< between blanks; one that ends in _ stands for all that begin so
  CcsdsUse use = CcsdsUse::optional;
  CcsdsValue value = CcsdsValue::text;
  std::string_view unit = {};     ///< of numbers; empty: none may be given
  std::string_view choices = {};  ///< allowed texts, between blanks; empty: any

  bool names(std::string_view keyword) const;
  bool may(int version) const { return (static_cast<int>(use) & (version == 1 ? 1 : 4)) != 0; }
  bool must(int version) const { return (static_cast<int>(use) & (version == 1 ? 2 : 8)) != 0; }
};

/// How a message counts time.
struct CcsdsClock {
  std::string name;  ///< of TIME_SYSTEM
  TimeScale scale = TimeScale::tt;
  bool known = false;           ///< false: a clock of the spacecraft, read as a uniform one
  std::optional<Instant> zero;  ///< EPOCH_TZERO

  /// A date of the message. Throws InputError.
  Instant date(std::string_view text, const SourceLocation& where) const;
};

/// TIME_SYSTEM. Throws InputError for one that CCSDS does not know.
CcsdsClock ccsds_clock(const CcsdsEntry& entry, const std::string& file);

/// Two texts are equal to CCSDS: any case, _ is a blank, several blanks are one.
std::string ccsds_text(std::string_view text);

/// The number in `text`. Throws InputError.
double ccsds_number(std::string_view text, const SourceLocation& where);

/// |q| may differ from 1 by this: rounding to two decimals and more.
inline constexpr double ccsds_norm_tolerance = 0.01;

/// A quaternion of Q1, Q2, Q3, QC, made a unit one. Throws InputError if its length differs from 1 by more than
/// ccsds_norm_tolerance.
Quaternion ccsds_quaternion(const Eigen::Vector4d& vector_then_scalar, const SourceLocation& where);

/// The entries of a block, held against the rules: only these keywords, each once, the mandatory ones present, values
/// and units as the rules say. Order is not checked: real messages differ.
class CcsdsFields {
 public:
  /// Throws InputError. `what` names the block in messages: "the QUAT block of an APM 2.0"; the rules are those of the
  /// version, 1 or 2.
  CcsdsFields(const CcsdsBlock& block, std::span<const CcsdsRule> rules, std::string what, std::string file,
              int version = 2);

  bool has(std::string_view keyword) const { return fields_.contains(keyword); }
  const CcsdsEntry& entry(std::string_view keyword) const { return *field(keyword).entry; }
  /// As in the file; empty if absent.
  std::string text(std::string_view keyword) const;
  /// By ccsds_text(); empty if absent.
  std::string normal(std::string_view keyword) const;
  /// In the rule's unit.
  double number(std::string_view keyword) const;
  std::vector<double> numbers(std::string_view keyword) const;
  SourceLocation where(std::string_view keyword) const { return {file_, entry(keyword).line}; }
  InputError error(std::string_view keyword, const std::string& message) const { return {where(keyword), message}; }
  SourceLocation start() const { return {file_, line_}; }
  const std::string& what() const { return what_; }

  /// Either all or none. Throws InputError naming the first that is missing.
  bool all_or_none(std::initializer_list<std::string_view> keywords) const;
  /// The same, and appends their numbers.
  bool append(std::initializer_list<std::string_view> keywords, std::vector<double>& list) const;
  [[noreturn]] void missing(std::string_view keyword) const;

 private:
  struct Field {
    const CcsdsEntry* entry;
    const CcsdsRule* rule;

    /// Of the entry's unit, to that of the rule.
    double factor() const;
  };

  void check(const Field& field) const;
  const Field& field(std::string_view keyword) const;

  std::map<std::string_view, Field, std::less<>> fields_;
  std::string what_;
  std::string file_;
  std::size_t line_;
};

}  // namespace polhode
