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

void append_two(std::string& out, std::int64_t value) {
  out.push_back(static_cast<char>('0' + value / 10));
  out.push_back(static_cast<char>('0' + value % 10));
}

}  // namespace

DateText::DateText(const TimeGrid& grid, int decimals) : grid_(grid), decimals_(decimals) {}

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
  double unit = 1.0;
  for (int i = 0; i < decimals_; ++i) unit *= 10.0;
  double whole = std::floor(time.high);
  double ticks = std::nearbyint(((time.high - whole) + time.low) * unit);
  if (ticks < 0.0) {
    whole -= 1.0;
    ticks += unit;
  } else if (ticks >= unit) {
    whole += 1.0;
    ticks -= unit;
  }
  const auto second = static_cast<std::int64_t>(whole);
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
  const std::int64_t plain = of_day - leap;
  out += day_;
  append_two(out, plain / 3600);
  out.push_back(':');
  append_two(out, plain / 60 % 60);
  out.push_back(':');
  append_two(out, plain % 60 + leap);
  if (decimals_ > 0) {
    out.push_back('.');
    const std::size_t begin = out.size();
    out.append(static_cast<std::size_t>(decimals_), '0');
    auto rest = static_cast<std::int64_t>(ticks);
    for (std::size_t at = out.size(); at-- > begin; rest /= 10) out[at] = static_cast<char>('0' + rest % 10);
  }
}

}  // namespace polhode
