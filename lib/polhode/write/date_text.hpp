#pragma once

#include <cstdint>
#include <string>

#include "polhode/ephemeris/time_grid.hpp"

namespace polhode {

/// Row times as calendar dates, "YYYY-MM-DDThh:mm:ss.fff" in the grid's scale, fast: the calendar is asked once a day
/// (UTC days with a leap second are longer by it; days of before 1972, whose length is no whole number of seconds, are
/// asked for each row).
class DateText {
 public:
  /// `decimals` of the second, 0 to 15; times must be multiples of them, as TimeGrid::time gives.
  DateText(const TimeGrid& grid, int decimals);

  /// The date of `time`, which counts from the grid's reference, to the end of `out`.
  void append(std::string& out, Seconds time);

 private:
  void begin_day(std::int64_t second);

  const TimeGrid& grid_;
  int decimals_;
  double ticks_per_s_ = 1.0;
  std::int64_t day_begin_s_ = 0;  // from the reference; the day holds day_begin_s_ <= second < day_end_s_
  std::int64_t day_end_s_ = 0;
  std::string day_;  // "YYYY-MM-DDT"
};

}  // namespace polhode
