#include "polhode/write/date_text.hpp"

#include <chrono>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace polhode {
namespace {

constexpr std::size_t date_length = 10;  // "YYYY-MM-DD"

int number(std::string_view text, std::size_t at, std::size_t digits) {
  int value = 0;
  for (const char c : text.substr(at, digits)) value = 10 * value + (c - '0');
  return value;
}

std::string next_day(std::string_view date) {
  using namespace std::chrono;
  const sys_days today = year(number(date, 0, 4)) / number(date, 5, 2) / number(date, 8, 2);
  const year_month_day next{today + days(1)};
  return fmt::format("{:04}-{:02}-{:02}", int(next.year()), unsigned(next.month()), unsigned(next.day()));
}

/// The last `digits` decimal digits of a number, at `to`; the place behind them.
char* put_digits(char* to, std::uint64_t value, int digits) {
  for (char* at = to + digits; at-- > to; value /= 10) *at = static_cast<char>('0' + value % 10);
  return to + digits;
}

}  // namespace

DateText::DateText(const TimeGrid& grid, int decimals) : grid_(grid), decimals_(decimals) {
  for (int i = 0; i < decimals_; ++i) ticks_per_s_ *= 10.0;
}

void DateText::begin_day(std::int64_t second) {
  const std::string now =
      format_date(grid_.instant({static_cast<double>(second) + 0.5, 0.0}), grid_.scale(), 0);  // safe from rounding
  const std::string date = now.substr(0, date_length);
  const auto from_reference = [&](const std::string& midnight) {
    return (since_j2000(parse_date(midnight, grid_.scale()), grid_.scale()) -
            since_j2000(grid_.reference(), grid_.scale()))
        .high;
  };
  const double begin = from_reference(date);
  const double end = from_reference(next_day(date));
  constexpr double whole_seconds_tolerance = 1e-7;
  const bool whole = std::abs(begin - std::nearbyint(begin)) < whole_seconds_tolerance &&
                     std::abs(end - std::nearbyint(end)) < whole_seconds_tolerance;
  day_ = date + "T";
  day_begin_s_ = std::llround(begin);
  day_end_s_ = whole ? std::llround(end) : day_begin_s_;  // an empty day: the calendar is asked each time
}

void DateText::append(std::string& out, Seconds time) {
  auto second = static_cast<std::int64_t>(time.high);  // whole seconds, downwards
  if (static_cast<double>(second) > time.high) --second;
  double ticks = std::nearbyint(((time.high - static_cast<double>(second)) + time.low) * ticks_per_s_);
  if (ticks < 0.0) {
    second -= 1;
    ticks += ticks_per_s_;
  } else if (ticks >= ticks_per_s_) {
    second += 1;
    ticks -= ticks_per_s_;
  }
  if (second < day_begin_s_ || second >= day_end_s_) {
    begin_day(second);
    if (second < day_begin_s_ || second >= day_end_s_) {
      out += format_date(grid_.instant(time), grid_.scale(), decimals_);
      return;
    }
  }
  constexpr std::int64_t last_second_of_a_plain_day = 86399;
  const std::int64_t of_day = second - day_begin_s_;
  const std::int64_t leap = of_day > last_second_of_a_plain_day ? of_day - last_second_of_a_plain_day : 0;
  const auto plain = static_cast<std::uint64_t>(of_day - leap);
  char text[32];
  char* at = put_digits(text, plain / 3600, 2);
  *at++ = ':';
  at = put_digits(at, plain / 60 % 60, 2);
  *at++ = ':';
  at = put_digits(at, plain % 60 + static_cast<std::uint64_t>(leap), 2);
  if (decimals_ > 0) {
    *at++ = '.';
    at = put_digits(at, static_cast<std::uint64_t>(ticks), decimals_);
  }
  out.append(day_).append(text, at);
}

}  // namespace polhode
