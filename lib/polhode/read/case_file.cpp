#include "polhode/read/case_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"
#include "polhode/base/text.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

constexpr std::string_view kLayout = "`I I1 I2 I3`, `q q0 q1 q2 q3`, `m m1 m2 m3`, `t T`, `T TORQUE`";

/// A finite number, decimal or C99 hexadecimal, the whole word.
double case_number(std::string_view word, const SourceLocation& where) {
  std::string_view digits = word;
  const bool negative = digits.starts_with('-');
  if (negative || digits.starts_with('+')) digits.remove_prefix(1);
  const bool hexadecimal = digits.starts_with("0x") || digits.starts_with("0X");
  if (hexadecimal) digits.remove_prefix(2);
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value,
                                            hexadecimal ? std::chars_format::hex : std::chars_format::general);
  const bool whole = error != std::errc::invalid_argument && end == digits.data() + digits.size();
  if (!whole || digits.starts_with('-')) {
    throw InputError(where, fmt::format("found '{:.40}', a number is wanted (decimal or hexadecimal)", word));
  }
  if (error == std::errc::result_out_of_range || !std::isfinite(value)) {
    throw InputError(where, fmt::format("found '{:.40}', a finite number in the range of a double is wanted", word));
  }
  return negative ? -value : value;
}

/// The numbers after the key of a line, as many as the key wants.
template <std::size_t count>
std::array<double, count> case_numbers(const std::vector<std::string_view>& words, const SourceLocation& where) {
  if (words.size() != count + 1) {
    throw InputError(where,
                     fmt::format("found {} value(s) after '{:.60}', {} wanted", words.size() - 1, words[0], count));
  }
  std::array<double, count> values{};
  for (std::size_t i = 0; i < count; ++i) values[i] = case_number(words[i + 1], where);
  return values;
}

template <class Value>
void set_once(std::optional<Value>& slot, const Value& value, std::string_view key, const SourceLocation& where) {
  if (slot.has_value()) throw InputError(where, fmt::format("found a second '{:.60}' line, one is allowed", key));
  slot = value;
}

Vector3 principal_moments(const std::array<double, 3>& I, const SourceLocation& where) {
  if (!(0.0 < I[0] && I[0] <= I[1] && I[1] <= I[2])) {
    throw InputError(
        where, fmt::format("found I = {} {} {}, positive moments in ascending order are wanted", I[0], I[1], I[2]));
  }
  const Vector3 moments(I[0], I[1], I[2]);
  located(where, [&] { check_principal_moments(moments); });
  return moments;
}

Vector3 angular_momentum(const std::array<double, 3>& m, const SourceLocation& where) {
  const Vector3 momentum(m[0], m[1], m[2]);
  located(where, [&] { check_angular_momentum(momentum); });
  return momentum;
}

/// The torque of a `T` line, from the words behind the T.
Torque torque(const std::vector<std::string_view>& words, const SourceLocation& where) {
  constexpr std::string_view kinds = "gravity-gradient, constant-body, linear-body";
  if (words.empty()) throw InputError(where, fmt::format("found 'T' alone, a torque is wanted: {}", kinds));
  const std::string_view kind = words[0];
  if (kind == "gravity-gradient") {
    const auto v = case_numbers<10>(words, where);
    return located(where, [&] {
      return GravityGradient(v[0], KeplerElements{v[0], v[1], v[2], v[3], {v[4], v[5], v[6]}, {v[7], v[8], v[9]}});
    });
  }
  if (kind == "constant-body") {
    const auto v = case_numbers<3>(words, where);
    return ConstantTorque{{v[0], v[1], v[2]}, ConstantTorque::Axes::body};
  }
  if (kind == "linear-body") {
    const auto v = case_numbers<3>(words, where);
    return LinearDamping{{v[0], v[1], v[2]}};
  }
  throw InputError(where, fmt::format("found unknown torque '{:.40}', allowed are {}", kind, kinds));
}

Torque checked_torque(const std::vector<std::string_view>& words, const SourceLocation& where) {
  const Torque one = torque(words, where);
  located(where, [&] { Torques({one}); });
  return one;
}

Quaternion attitude(const std::array<double, 4>& q, const SourceLocation& where) {
  if (q == std::array<double, 4>{}) throw InputError(where, "found q = 0 0 0 0, any other quaternion is allowed");
  return from_scalar_first({q[0], q[1], q[2], q[3]});
}

}  // namespace

CaseFile read_case_file(const std::string& path) { return parse_case_file(read_text_file(path), path); }

CaseFile parse_case_file(std::string_view text, const std::string& path) {
  std::optional<Vector3> moments, momentum;
  std::optional<Quaternion> q;
  std::vector<Torque> torques;
  CaseFile result;

  SourceLocation where{path, 0};
  for (std::string_view rest = text; !rest.empty();) {
    ++where.line;
    const std::size_t end = rest.find('\n');
    const std::vector<std::string_view> words = split_words(rest.substr(0, std::min(end, rest.find('#'))));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (words.empty()) continue;
    const std::string_view key = words[0];
    if (key == "I") {
      set_once(moments, principal_moments(case_numbers<3>(words, where), where), key, where);
    } else if (key == "q") {
      set_once(q, attitude(case_numbers<4>(words, where), where), key, where);
    } else if (key == "m") {
      set_once(momentum, angular_momentum(case_numbers<3>(words, where), where), key, where);
    } else if (key == "t") {
      result.times_s.push_back(case_numbers<1>(words, where)[0]);
    } else if (key == "T") {
      torques.push_back(checked_torque({words.begin() + 1, words.end()}, where));
    } else {
      throw InputError(where, fmt::format("found unknown key '{:.40}', allowed lines are {}", key, kLayout));
    }
  }

  const auto require = [&](bool present, std::string_view key) {
    if (!present) throw InputError({path, 0}, fmt::format("no '{:.60}' line found, wanted are {}", key, kLayout));
  };
  require(moments.has_value(), "I");
  require(q.has_value(), "q");
  require(momentum.has_value(), "m");
  require(!result.times_s.empty(), "t");
  result.body = {*moments, *q, *momentum};
  result.torques = Torques(std::move(torques));
  return result;
}

}  // namespace polhode
