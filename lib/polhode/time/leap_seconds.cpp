#include "polhode/time/leap_seconds.hpp"

#include <erfa.h>
#include <erfaextra.h>
#include <fmt/format.h>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

std::vector<eraLEAPSECOND> erfa_table() {
  eraLEAPSECOND* table = nullptr;
  const int count = eraGetLeapSeconds(&table);
  return {table, table + count};
}

}  // namespace

std::vector<LeapSecond> leap_seconds() {
  std::vector<LeapSecond> out;
  for (const eraLEAPSECOND& entry : erfa_table()) {
    if (entry.iyear >= 1972) out.push_back({entry.iyear, entry.month, entry.delat});
  }
  return out;
}

void set_leap_seconds(const std::vector<LeapSecond>& table) {
  if (table.empty() || table[0].year != 1972 || table[0].month != 1 || table[0].tai_minus_utc_s != 10.0) {
    throw InputError("a table of leap seconds must start with 10 s at 1972-01");
  }
  // ERFA keeps the pointer: the table lives as long as the program. The drifting offsets before 1972 stay ERFA's.
  static std::vector<eraLEAPSECOND> kept;
  std::vector<eraLEAPSECOND> next;
  for (const eraLEAPSECOND& entry : erfa_table()) {
    if (entry.iyear < 1972) next.push_back(entry);
  }
  for (const LeapSecond& entry : table) {
    const eraLEAPSECOND& last = next.back();
    if (entry.month < 1 || entry.month > 12 || entry.year * 12 + entry.month <= last.iyear * 12 + last.month) {
      throw InputError(fmt::format("leap seconds must ascend, one a month at most: found {}-{:02} after {}-{:02}",
                                   entry.year, entry.month, last.iyear, last.month));
    }
    const double step_s = entry.tai_minus_utc_s - last.delat;
    if (&entry != table.data() && step_s != 1.0 && step_s != -1.0) {
      throw InputError(fmt::format("a leap second changes TAI - UTC by 1 s: found {} s at {}-{:02} after {} s",
                                   entry.tai_minus_utc_s, entry.year, entry.month, last.delat));
    }
    next.push_back({entry.year, entry.month, entry.tai_minus_utc_s});
  }
  kept = std::move(next);
  eraSetLeapSeconds(kept.data(), static_cast<int>(kept.size()));
}

}  // namespace polhode
