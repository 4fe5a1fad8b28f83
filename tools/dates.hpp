#pragma once

#include <optional>
#include <string>
#include <vector>

#include "polhode/time/scale.hpp"
#include "utc.hpp"

namespace polhode::tools {

/// How the command line gives dates.
struct DateRule {
  TimeScale rows;                   ///< in whose seconds spans count
  std::optional<TimeScale> unsaid;  ///< of dates that name no scale; absent: these are refused
};

/// A date as parse_date_with_scale has it, or "now", the second that the system's clock shows.
Date date_or_now(const std::string& text, std::optional<TimeScale> unsaid);

/// A date ("2029-04-13T21:46:00 UTC"), "now", or a span from `from` ("+60 d", "-60 d").
Instant wanted_date(const std::string& text, Instant from, const DateRule& rule, UtcDoubts& doubts);

/// The dates of --times: "now", or what read_time_list takes; in order and each one once, which is said where the list
/// is not so.
std::vector<Instant> wanted_dates(const std::string& list, const DateRule& rule, UtcDoubts& doubts);

}  // namespace polhode::tools
