#include "dates.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "output.hpp"
#include "polhode/base/error.hpp"
#include "polhode/read/quantity.hpp"
#include "polhode/read/time_list.hpp"

namespace polhode::tools {
namespace {

bool is_span(const std::string& text) {
  try {
    parse_duration(text);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

Date date_or_now(const std::string& text, std::optional<TimeScale> unsaid) {
  if (text != "now") return parse_date_with_scale(text, unsaid);
  const std::string clock = fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(std::time(nullptr)));
  return {parse_date(clock, TimeScale::utc), TimeScale::utc};
}

Instant wanted_date(const std::string& text, Instant from, const DateRule& rule, UtcDoubts& doubts) {
  Instant out;
  bool is_utc = rule.rows == TimeScale::utc;
  if (text.starts_with('+') || text.starts_with('-')) {
    out = instant_from_j2000(since_j2000(from, rule.rows) + parse_duration(text), rule.rows);
    try {
      format_date(out, rule.rows, 0);
    } catch (const InputError&) {
      throw InputError(
          fmt::format("'{:.60}' leads from {} {} out of the years 0000 to 9999, in which dates are allowed", text,
                      format_date(from, rule.rows, 0), name(rule.rows)));
    }
  } else if (is_span(text)) {
    throw InputError(
        fmt::format("'{0}' is a span of time, not a date; '+{0}' counts from the epoch or the start", text));
  } else {
    const Date date = date_or_now(text, rule.unsaid);
    out = date.instant;
    is_utc = is_utc || date.scale == TimeScale::utc;
  }
  if (is_utc) doubts.look_at(out);
  return out;
}

std::vector<Instant> wanted_dates(const std::string& list, const DateRule& rule, UtcDoubts& doubts) {
  std::vector<Instant> dates =
      list == "now" ? std::vector{date_or_now(list, {}).instant} : read_time_list(list, rule.unsaid);
  if (!std::is_sorted(dates.begin(), dates.end())) {
    std::stable_sort(dates.begin(), dates.end());
    say(fmt::format("the times of {} are not in order; the rows are", list));
  }
  const std::size_t all = dates.size();
  dates.erase(std::unique(dates.begin(), dates.end()), dates.end());
  if (dates.size() != all) {
    say(fmt::format("{} times of {} are there more than once; each has one row", all - dates.size(), list));
  }
  if (rule.rows == TimeScale::utc) {
    for (const Instant date : dates) doubts.look_at(date);
  }
  return dates;
}

}  // namespace polhode::tools
