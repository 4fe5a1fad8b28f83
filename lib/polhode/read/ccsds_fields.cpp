#include "polhode/read/ccsds_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/read/units.hpp"

namespace polhode {
namespace {

bool is_digits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// YYYY-MM-DDThh:mm:ss[.d…][Z] or YYYY-DDDThh:mm:ss[.d…][Z] (504.0-B-2, 6.8.9), by its shape alone.
bool is_date(std::string_view text) {
  if (text.ends_with('Z')) text.remove_suffix(1);
  const std::size_t t = text.find('T');
  if (t != 8 && t != 10) return false;
  const std::string_view day = text.substr(0, t);
  const std::string_view time = text.substr(t + 1);
  if (!is_digits(day.substr(0, 4)) || day[4] != '-') return false;
  if (t == 8 ? !is_digits(day.substr(5))
             : !(is_digits(day.substr(5, 2)) && day[7] == '-' && is_digits(day.substr(8)))) {
    return false;
  }
  if (time.size() < 8 || !is_digits(time.substr(0, 2)) || time[2] != ':' || !is_digits(time.substr(3, 2)) ||
      time[5] != ':' || !is_digits(time.substr(6, 2))) {
    return false;
  }
  return time.size() == 8 || (time[8] == '.' && (time.size() == 9 || is_digits(time.substr(9))));
}

bool is_sequence(std::string_view text) {
  constexpr std::string_view axes = "XYZxyz123";
  if (text.size() != 3 || text.find_first_not_of(axes) != std::string_view::npos) return false;
  const auto axis = [&](std::size_t k) { return axes.find(text[k]) % 3; };
  return axis(0) != axis(1) && axis(1) != axis(2);
}

}  // namespace

std::string ccsds_text(std::string_view text) {
  std::string out;
  for (const char c : upper_case(trimmed(text))) {
    const bool blank = c == ' ' || c == '_' || c == '\t';
    if (!blank) out += c;
    if (blank && !out.ends_with('_')) out += '_';
  }
  return out;
}

double ccsds_number(std::string_view text, const SourceLocation& where) {
  const std::optional<double> value = parse_number(text);
  if (!value) throw InputError(where, fmt::format("'{:.60}' is not a number", text));
  return *value;
}

Quaternion ccsds_quaternion(const Eigen::Vector4d& vector_then_scalar, const SourceLocation& where) {
  const Eigen::Vector4d& q = vector_then_scalar;
  const double norm = q.norm();
  if (!(std::abs(norm - 1.0) <= ccsds_norm_tolerance)) {
    throw InputError(
        where, fmt::format("the quaternion has length {:.6g}; it must be 1 within {}", norm, ccsds_norm_tolerance));
  }
  return Quaternion(q[3], q[0], q[1], q[2]).normalized();
}

Instant CcsdsClock::date(std::string_view text, const SourceLocation& where) const {
  if (!is_date(text)) {
    throw InputError(
        where, fmt::format("'{:.60}' is no date: YYYY-MM-DDThh:mm:ss[.d] or YYYY-DDDThh:mm:ss[.d] is wanted", text));
  }
  return located(where, [&] {
    if (!text.ends_with('Z')) return parse_date(text, scale);
    return parse_date(text.substr(0, text.size() - 1), known ? TimeScale::utc : scale);
  });
}

CcsdsClock ccsds_clock(const CcsdsEntry& entry, const std::string& file) {
  constexpr std::array<std::string_view, 6> known{"UTC", "TAI", "TT", "TDB", "GPS", "TDT"};
  constexpr std::array<std::string_view, 7> unknown{"UT1", "TCB", "TCG", "GMST", "MET", "MRT", "SCLK"};
  CcsdsClock clock;
  clock.name = ccsds_text(entry.value);
  clock.known = std::find(known.begin(), known.end(), clock.name) != known.end();
  if (clock.known) {
    clock.scale = time_scale(clock.name);
    return clock;
  }
  if (std::find(unknown.begin(), unknown.end(), clock.name) != unknown.end()) return clock;
  throw InputError(
      {file, entry.line},
      fmt::format("TIME_SYSTEM {} is unknown; allowed are UTC, TAI, TT, TDB, GPS, UT1, TCB, TCG, GMST, MET, MRT, SCLK",
                  entry.value));
}

bool CcsdsRule::names(std::string_view keyword) const {
  return contains_word(keywords, keyword) || (keywords.ends_with('_') && keyword.starts_with(keywords));
}

CcsdsFields::CcsdsFields(const CcsdsBlock& block, std::span<const CcsdsRule> rules, std::string what, std::string file,
                         int version)
    : what_(std::move(what)), file_(std::move(file)), line_(block.line) {
  for (const CcsdsEntry& e : block.entries) {
    const auto rule = std::find_if(rules.begin(), rules.end(),
                                   [&](const CcsdsRule& r) { return r.may(version) && r.names(e.keyword); });
    if (rule == rules.end())
      throw InputError({file_, e.line}, fmt::format("the keyword {} is not allowed in {}", e.keyword, what_));
    const auto [place, added] = fields_.try_emplace(e.keyword, Field{&e, &*rule});
    if (!added) {
      throw InputError({file_, e.line}, fmt::format("{} is repeated in {} (first on line {})", e.keyword, what_,
                                                    place->second.entry->line));
    }
    if (e.value.empty()) throw InputError({file_, e.line}, fmt::format("{} has no value", e.keyword));
    check(place->second);
  }
  for (const CcsdsRule& r : rules) {
    if (!r.must(version)) continue;
    for (const std::string_view keyword : split_words(r.keywords)) {
      if (!has(keyword)) missing(keyword);
    }
  }
}

void CcsdsFields::missing(std::string_view keyword) const {
  throw InputError(start(), fmt::format("{} is missing in {}", keyword, what_));
}

void CcsdsFields::check(const Field& field) const {
  const CcsdsEntry& entry = *field.entry;
  const CcsdsRule& rule = *field.rule;
  const SourceLocation at{file_, entry.line};
  const auto fail = [&](std::string_view wanted) {
    throw InputError(at, fmt::format("{} = {}: {} is wanted", entry.keyword, entry.value, wanted));
  };
  if (!rule.choices.empty() && !contains_word(rule.choices, ccsds_text(entry.value)))
    throw InputError(at, fmt::format("{} = {} is not one of: {}", entry.keyword, entry.value, rule.choices));
  if (!entry.unit.empty()) {
    if (rule.unit.empty() && entry.unit != "n/a" && rule.keywords != "USER_DEFINED_")
      throw InputError(at, fmt::format("{} has no unit, found [{}]", entry.keyword, entry.unit));
    if (!rule.unit.empty() && !unit_factor(entry.unit, rule.unit)) {
      throw InputError(
          at, fmt::format("{}: the unit [{}] is unknown or no kind of {}", entry.keyword, entry.unit, rule.unit));
    }
  }
  const auto as_numbers = [&](std::size_t count) {
    const std::vector<std::string_view> words = split_words(entry.value);
    if (count != 0 && words.size() != count)
      throw InputError(at, fmt::format("{} has {} numbers, {} are wanted", entry.keyword, words.size(), count));
    std::vector<double> list;
    list.reserve(words.size());
    for (const std::string_view word : words) list.push_back(ccsds_number(word, at));
    return list;
  };
  switch (rule.value) {
    case CcsdsValue::text:
      return;
    case CcsdsValue::number:
      as_numbers(1);
      return;
    case CcsdsValue::not_negative:
      if (as_numbers(1)[0] < 0.0) fail("a number that is not negative");
      return;
    case CcsdsValue::positive:
      if (as_numbers(1)[0] <= 0.0) fail("a positive number");
      return;
    case CcsdsValue::not_positive:
      if (as_numbers(1)[0] > 0.0) fail("0 or a negative number");
      return;
    case CcsdsValue::not_zero:
      if (as_numbers(1)[0] == 0.0) fail("a number other than 0");
      return;
    case CcsdsValue::angle:
      if (std::abs(as_numbers(1)[0] * field.factor()) > 360.0) fail("an angle from -360 to 360 deg");
      return;
    case CcsdsValue::integer: {
      const std::optional<long long> value = parse_integer(entry.value);
      if (!value || *value < 1 || *value > 2147483647) fail("a whole number above 0");
      return;
    }
    case CcsdsValue::epoch:
      if (!is_date(entry.value)) fail("a date YYYY-MM-DDThh:mm:ss[.d] or YYYY-DDDThh:mm:ss[.d]");
      return;
    case CcsdsValue::time:
      if (!is_date(entry.value) && !parse_number(entry.value)) fail("a date or a number of seconds");
      return;
    case CcsdsValue::vector:
      as_numbers(3);
      return;
    case CcsdsValue::quaternion: {
      const std::vector<double> q = as_numbers(4);
      ccsds_quaternion({q[0], q[1], q[2], q[3]}, at);
      return;
    }
    case CcsdsValue::numbers:
      for (const double value : as_numbers(0)) {
        if (value < 0.0) fail("numbers that are not negative");
      }
      return;
    case CcsdsValue::sequence:
      if (!is_sequence(entry.value)) fail("three of X, Y, Z (or 1, 2, 3), no two neighbours alike,");
      return;
  }
}

double CcsdsFields::Field::factor() const {
  if (entry->unit.empty() || rule->unit.empty()) return 1.0;
  return unit_factor(entry->unit, rule->unit).value_or(1.0);
}

const CcsdsFields::Field& CcsdsFields::field(std::string_view keyword) const {
  const auto found = fields_.find(keyword);
  if (found == fields_.end()) missing(keyword);
  return found->second;
}

std::string CcsdsFields::text(std::string_view keyword) const {
  return has(keyword) ? entry(keyword).value : std::string{};
}

std::string CcsdsFields::normal(std::string_view keyword) const { return ccsds_text(text(keyword)); }

double CcsdsFields::number(std::string_view keyword) const {
  const Field& f = field(keyword);
  return ccsds_number(f.entry->value, where(keyword)) * f.factor();
}

std::vector<double> CcsdsFields::numbers(std::string_view keyword) const {
  const Field& f = field(keyword);
  std::vector<double> list;
  for (const std::string_view word : split_words(f.entry->value))
    list.push_back(ccsds_number(word, where(keyword)) * f.factor());
  return list;
}

bool CcsdsFields::all_or_none(std::initializer_list<std::string_view> keywords) const {
  std::string_view first;
  std::string_view absent;
  for (const std::string_view k : keywords) {
    if (has(k) && first.empty()) first = k;
    if (!has(k) && absent.empty()) absent = k;
  }
  if (first.empty()) return false;
  if (!absent.empty())
    throw InputError(where(first), fmt::format("{} is given without {} in {}", first, absent, what_));
  return true;
}

bool CcsdsFields::append(std::initializer_list<std::string_view> keywords, std::vector<double>& list) const {
  if (!all_or_none(keywords)) return false;
  for (const std::string_view k : keywords) list.push_back(number(k));
  return true;
}

}  // namespace polhode
