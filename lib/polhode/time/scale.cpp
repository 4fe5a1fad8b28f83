#include "polhode/time/scale.hpp"

#include <erfa.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/time/scale_detail.hpp"

namespace polhode {
namespace {

constexpr double day_s = 86400.0;
constexpr double mjd_zero = 2400000.5;                         // as a Julian date
constexpr double mjd_j2000_day = 51544;                        // 2000-01-01; J2000 is its noon
constexpr double first_mjd = -678941.0, last_mjd = 2973483.0;  // 0000-01-01, 9999-12-31
constexpr Seconds tt_minus_tai{32.184, 2.5011104298755525e-15};
constexpr Seconds tt_minus_gps{51.184, 2.5011104298755525e-15};

struct NamedScale {
  std::string_view name;
  TimeScale scale;
};
constexpr std::array<NamedScale, 7> scale_names{{{"TT", TimeScale::tt},
                                                 {"TAI", TimeScale::tai},
                                                 {"UTC", TimeScale::utc},
                                                 {"TDB", TimeScale::tdb},
                                                 {"GPS", TimeScale::gps},
                                                 {"ET", TimeScale::et},
                                                 {"TDT", TimeScale::tt}}};

constexpr std::string_view scales_allowed = "TT, TAI, UTC, TDB, GPS, ET";

std::optional<TimeScale> find_scale(std::string_view name) {
  for (const NamedScale& entry : scale_names) {
    if (entry.name == upper_case(name)) return entry.scale;
  }
  return std::nullopt;
}

// ET - TT, s: SPICE's DELTET formula with the constants of NAIF's leap-second kernels (time required reading, "The
// relationship between TDT and TDB"); the anomaly's argument may count TT or ET, 1e-12 s apart in the result.
double et_minus_tt_s(double tt_s) {
  const double mean_anomaly = 6.239996 + 1.99096871e-7 * tt_s;
  return 1.657e-3 * std::sin(mean_anomaly + 1.671e-2 * std::sin(mean_anomaly));
}

// --- days -------------------------------------------------------------------------------------------------------

struct CalendarDate {
  int year = 0, month = 0, day = 0;
};

// Whole days and the seconds of the day of a uniform reading from J2000, 0 <= seconds < 86400.
struct DayAndSeconds {
  double mjd = 0.0;
  Seconds seconds;
};

DayAndSeconds split_uniform(Seconds reading) {
  const Seconds from_midnight = reading + Seconds{0.5 * day_s, 0.0};
  DayAndSeconds out;
  out.mjd = std::floor(from_midnight.high / day_s);
  out.seconds = from_midnight - exact_product(out.mjd, day_s);
  if (out.seconds.high < 0.0) {
    out.seconds = out.seconds + Seconds{day_s, 0.0};
    out.mjd -= 1.0;
  }
  out.mjd += mjd_j2000_day;
  return out;
}

Seconds join_uniform(const DayAndSeconds& day) {
  return exact_product(day.mjd - mjd_j2000_day, day_s) + (day.seconds - Seconds{0.5 * day_s, 0.0});
}

/// `beyond` days before and after the years that can be written are days, too.
CalendarDate calendar(double mjd, double beyond = 0.0) {
  CalendarDate date;
  double fraction = 0.0;
  if (!(first_mjd - beyond <= mjd && mjd < last_mjd + 1.0 + beyond) ||
      eraJd2cal(mjd_zero, mjd, &date.year, &date.month, &date.day, &fraction) != 0) {
    throw InputError("a date outside the years 0000 to 9999 cannot be written as a calendar date");
  }
  return date;
}

double mjd_of(const CalendarDate& date) {
  double zero = 0.0, mjd = 0.0;
  if (date.year < 0 || date.year > 9999 || eraCal2jd(date.year, date.month, date.day, &zero, &mjd) != 0) {
    throw InputError(fmt::format("no such date: {:04d}-{:02d}-{:02d}", date.year, date.month, date.day));
  }
  return mjd;
}

// One day of UTC, by ERFA's model (eraUtctai, eraDtf2d): TAI - UTC at 0h, its drift before 1972, the day's length.
struct UtcDay {
  double mjd = 0.0;
  double tai_minus_utc_0h_s = 0.0;
  double drift = 0.0;  // seconds of TAI - UTC per second of UTC
  double length_s = day_s;
  bool dubious = false;
};

UtcDay utc_day(double mjd) {
  const CalendarDate today = calendar(mjd, 2.0);  // UTC is within a day of scales that can be written
  const CalendarDate tomorrow = calendar(mjd + 1.0, 2.0);
  double at_0h = 0.0, at_12h = 0.0, at_24h = 0.0;
  const int status = eraDat(today.year, today.month, today.day, 0.0, &at_0h);
  eraDat(today.year, today.month, today.day, 0.5, &at_12h);
  eraDat(tomorrow.year, tomorrow.month, tomorrow.day, 0.0, &at_24h);
  const double drift_per_day = 2.0 * (at_12h - at_0h);
  UtcDay day;
  day.mjd = mjd;
  day.tai_minus_utc_0h_s = at_0h;
  day.drift = drift_per_day / day_s;
  day.length_s = day_s + (at_24h - (at_0h + drift_per_day));
  day.dubious = status == 1;
  return day;
}

Instant instant_of_utc(const UtcDay& day, Seconds second_of_day) {
  const Seconds drifted = second_of_day + Seconds{day.drift * second_of_day.high, 0.0};
  const Seconds tai = join_uniform({day.mjd, drifted + Seconds{day.tai_minus_utc_0h_s, 0.0}});
  return Instant::from_tt_j2000(tai + tt_minus_tai);
}

struct UtcReading {
  UtcDay day;
  Seconds second_of_day;  // 0 <= second_of_day < day.length_s
};

UtcReading read_utc(Instant instant) {
  const DayAndSeconds tai = split_uniform(instant.tt_since_j2000() - tt_minus_tai);
  for (const double back : {0.0, 1.0}) {  // UTC is behind TAI by less than a day
    const UtcDay day = utc_day(tai.mjd - back);
    const Seconds elapsed = tai.seconds + Seconds{back * day_s, 0.0} - Seconds{day.tai_minus_utc_0h_s, 0.0};
    const double drifted = elapsed.high / (1.0 + day.drift);
    const Seconds second =
        day.drift == 0.0 ? elapsed : elapsed - Seconds{day.drift * drifted, 0.0};  // drift <= 3e-8: one step is exact
    if (second.high >= 0.0) return {day, second};
    if (second.high > -1e-15) return {day, {}};  // midnight, but for the rounding of TT - TAI
  }
  throw InputError("no UTC day at this instant");
}

// --- text -------------------------------------------------------------------------------------------------------

bool is_digit(char c) { return c >= '0' && c <= '9'; }

[[noreturn]] void refuse(std::string_view text) {
  throw InputError(
      fmt::format("'{:.60}' is not a date; allowed: 2029-04-13T21:46:00.5, 2029-103T21:46:00, JD 2462240.5, "
                  "MJD 62240.0, or a JD or MJD as two numbers whose sum counts",
                  text));
}

// Takes characters from the front of a text; every failure refuses the whole text.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : whole_(text), rest_(text) {}

  bool done() const { return rest_.empty(); }
  bool next_is(char c) const { return !rest_.empty() && rest_.front() == c; }
  bool take(char c) {
    if (!next_is(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void need(char c) {
    if (!take(c)) refuse(whole_);
  }
  std::size_t digits_ahead() const {
    return static_cast<std::size_t>(std::find_if_not(rest_.begin(), rest_.end(), is_digit) - rest_.begin());
  }
  int number(std::size_t digits) {
    if (digits_ahead() != digits) refuse(whole_);
    int value = 0;
    for (std::size_t i = 0; i < digits; ++i) value = 10 * value + (rest_[i] - '0');
    rest_.remove_prefix(digits);
    return value;
  }
  // ".ddd" if it stands here, else 0.
  double fraction() {
    if (!take('.')) return 0.0;
    const std::string text = "0." + std::string(rest_.substr(0, digits_ahead()));
    rest_.remove_prefix(digits_ahead());
    double value = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
  }
  void skip_spaces() { rest_ = trimmed(rest_); }
  // "-ddd.ddd": whole part and fraction apart, so that no digit is lost.
  Seconds decimal() {
    const double sign = take('-') ? -1.0 : 1.0;
    const std::size_t digits = digits_ahead();
    if (digits > 9 || (digits == 0 && !next_is('.'))) refuse(whole_);
    const double whole = digits == 0 ? 0.0 : number(digits);
    return {sign * whole, sign * fraction()};
  }

 private:
  std::string_view whole_, rest_;
};

Instant from_day(double mjd, Seconds second_of_day, TimeScale scale) {
  if (scale == TimeScale::utc) return instant_of_utc(utc_day(mjd), second_of_day);
  return instant_from_j2000(join_uniform({mjd, second_of_day}), scale);
}

Instant parse_julian(std::string_view text, std::string_view numbers, double zero, TimeScale scale) {
  Scanner scan(numbers);
  scan.skip_spaces();
  Seconds days = scan.decimal();
  scan.skip_spaces();
  if (!scan.done()) days = days + scan.decimal();
  if (!scan.done()) refuse(text);
  const Seconds mjd = days - Seconds{zero, 0.0};
  double day = std::floor(mjd.high);
  Seconds fraction = mjd - Seconds{day, 0.0};
  if (fraction.high < 0.0) {
    fraction = fraction + Seconds{1.0, 0.0};
    day -= 1.0;
  }
  if (!(first_mjd <= day && day <= last_mjd)) {
    throw InputError(fmt::format("'{:.60}' lies outside of the years 0000 to 9999", text));
  }
  const double length = scale == TimeScale::utc ? utc_day(day).length_s : day_s;
  const Seconds second = exact_product(fraction.high, length) + Seconds{fraction.low * length, 0.0};
  return from_day(day, second, scale);
}

Instant parse_calendar(std::string_view text, TimeScale scale) {
  Scanner scan(text);
  CalendarDate date{scan.number(4), 1, 1};
  scan.need('-');
  double mjd = 0.0;
  if (scan.digits_ahead() == 3) {
    const int day_of_year = scan.number(3);
    mjd = mjd_of(date) + day_of_year - 1;
    if (day_of_year < 1 || mjd >= mjd_of({date.year, 12, 31}) + 1.0) {
      throw InputError(fmt::format("no such date: day {} of the year {}", day_of_year, date.year));
    }
  } else {
    date.month = scan.number(2);
    scan.need('-');
    date.day = scan.number(2);
    mjd = mjd_of(date);
  }
  if (scan.done()) return from_day(mjd, {}, scale);
  if (!scan.take('T') && !scan.take('t')) scan.need(' ');
  const int hour = scan.number(2);
  scan.need(':');
  const int minute = scan.number(2);
  int second = 0;
  double fraction = 0.0;
  if (scan.take(':')) {
    second = scan.number(2);
    fraction = scan.fraction();
  }
  if (!scan.done()) refuse(text);
  double minute_s = 60.0;
  if (scale == TimeScale::utc && hour == 23 && minute == 59) minute_s += utc_day(mjd).length_s - day_s;
  if (hour > 23 || minute > 59 || second + fraction >= minute_s) {
    throw InputError(
        fmt::format("'{:.60}' has no such time of day in {}: hours 00 to 23, minutes 00 to 59, seconds below "
                    "60 (below 61 only where UTC has a leap second)",
                    text, name(scale)));
  }
  const double whole = 3600.0 * hour + 60.0 * minute + second;
  return from_day(mjd, exact_sum(whole, fraction), scale);
}

// `day_length` is that of the day named by `mjd`.
std::string format_day(double mjd, Seconds second_of_day, double day_length, int decimals) {
  if (decimals < 0 || decimals > 15) throw InputError("a date takes 0 to 15 decimals of the second");
  double unit = 1.0;
  for (int i = 0; i < decimals; ++i) unit *= 10.0;
  double whole = std::floor(second_of_day.high);
  Seconds rest = second_of_day - Seconds{whole, 0.0};
  if (rest.high < 0.0) {
    rest = rest + Seconds{1.0, 0.0};
    whole -= 1.0;
  }
  const Seconds scaled = exact_product(rest.high, unit) + Seconds{rest.low * unit, 0.0};
  double count = std::floor(scaled.high);
  if ((scaled.high - count) + scaled.low >= 0.5) count += 1.0;
  if (count >= unit) {
    count -= unit;
    whole += 1.0;
  }
  if (whole + count / unit >= day_length) {
    whole = 0.0;
    count = 0.0;
    mjd += 1.0;
  }
  const CalendarDate date = calendar(mjd);
  const int second = static_cast<int>(whole);
  const int minute = std::min(second / 60, 24 * 60 - 1);  // second 60 belongs to the last minute
  std::string text = fmt::format("{:04d}-{:02d}-{:02d}T{:02d}:{:02d}:{:02d}", date.year, date.month, date.day,
                                 minute / 60, minute % 60, second - 60 * minute);
  if (decimals > 0) text += fmt::format(".{:0{}d}", static_cast<long long>(count), decimals);
  return text;
}

}  // namespace

std::string_view name(TimeScale scale) {
  return std::find_if(scale_names.begin(), scale_names.end(), [&](const auto& e) { return e.scale == scale; })->name;
}

TimeScale time_scale(std::string_view name) {
  if (const auto scale = find_scale(name)) return *scale;
  throw InputError(fmt::format("'{:.60}' is not a time scale; allowed: {}", name, scales_allowed));
}

Instant parse_date(std::string_view text, TimeScale scale) {
  const std::string_view date = trimmed(text);
  if (upper_case(date.substr(0, 3)) == "MJD") return parse_julian(text, date.substr(3), 0.0, scale);
  if (upper_case(date.substr(0, 2)) == "JD") return parse_julian(text, date.substr(2), mjd_zero, scale);
  return parse_calendar(date, scale);
}

Date parse_date_with_scale(std::string_view text, std::optional<TimeScale> missing) {
  const std::string_view date = trimmed(text);
  const auto space = date.find_last_of(" \t");
  if (space != std::string_view::npos) {
    const std::string_view word = date.substr(space + 1);
    if (!word.empty() && std::isalpha(static_cast<unsigned char>(word.front())) != 0) {
      const std::optional<TimeScale> scale = word == "Z" || word == "z" ? TimeScale::utc : find_scale(word);
      if (!scale) {
        throw InputError(fmt::format("'{:.60}' is not a date with its time scale: '{:.20}' is none; allowed: {}", text,
                                     word, scales_allowed));
      }
      return {parse_date(date.substr(0, space), *scale), *scale};
    }
  }
  if (!date.empty() && (date.back() == 'Z' || date.back() == 'z')) {
    return {parse_date(date.substr(0, date.size() - 1), TimeScale::utc), TimeScale::utc};
  }
  if (!missing) {
    parse_date(date, TimeScale::utc);  // what is no date is said first
    throw InputError(fmt::format(
        "'{:.60}' needs its time scale behind it, as in '2029-04-13T21:46:00 TDB'; allowed: {}, or Z for UTC", text,
        scales_allowed));
  }
  return {parse_date(date, *missing), *missing};
}

std::string format_date(Instant instant, TimeScale scale, int decimals) {
  if (scale != TimeScale::utc) {
    const DayAndSeconds day = split_uniform(since_j2000(instant, scale));
    return format_day(day.mjd, day.seconds, day_s, decimals);
  }
  const UtcReading utc = read_utc(instant);
  return format_day(utc.day.mjd, utc.second_of_day, utc.day.length_s, decimals);
}

Seconds since_j2000(Instant instant, TimeScale scale) {
  const Seconds tt = instant.tt_since_j2000();
  switch (scale) {
    case TimeScale::tt:
      return tt;
    case TimeScale::tai:
    case TimeScale::utc:
      return tt - tt_minus_tai;
    case TimeScale::gps:
      return tt - tt_minus_gps;
    case TimeScale::tdb:
      return tt + Seconds{detail::tdb_minus_tt_s(tt.high), 0.0};
    case TimeScale::et:
      return tt + Seconds{et_minus_tt_s(tt.high), 0.0};
  }
  throw std::logic_error("no such time scale");
}

Instant instant_from_j2000(Seconds since, TimeScale scale) {
  switch (scale) {
    case TimeScale::tt:
      return Instant::from_tt_j2000(since);
    case TimeScale::tai:
    case TimeScale::utc:
      return Instant::from_tt_j2000(since + tt_minus_tai);
    case TimeScale::gps:
      return Instant::from_tt_j2000(since + tt_minus_gps);
    case TimeScale::tdb:
    case TimeScale::et: {
      // TT - TDB changes by 3e-10 of a change in its argument: two steps leave less than 1e-16 s.
      const auto ahead_s = scale == TimeScale::tdb ? detail::tdb_minus_tt_s : et_minus_tt_s;
      const double first_tt_s = since.high - ahead_s(since.high);
      return Instant::from_tt_j2000(since - Seconds{ahead_s(first_tt_s), 0.0});
    }
  }
  throw std::logic_error("no such time scale");
}

ModifiedJulianDate modified_julian_date(Instant instant, TimeScale scale) {
  if (scale == TimeScale::utc) {
    const UtcReading utc = read_utc(instant);
    return {utc.day.mjd, utc.second_of_day.high / utc.day.length_s};
  }
  const DayAndSeconds day = split_uniform(since_j2000(instant, scale));
  return {day.mjd, day.seconds.high / day_s};
}

std::optional<std::string> utc_doubt(Instant instant) {
  const UtcDay day = read_utc(instant).day;
  if (!day.dubious) return std::nullopt;
  if (day.tai_minus_utc_0h_s == 0.0) return "UTC did not exist before 1960; TAI stands in for it";
  return fmt::format("leap seconds so far ahead are not known; TAI - UTC = {} s is assumed", day.tai_minus_utc_0h_s);
}

}  // namespace polhode
