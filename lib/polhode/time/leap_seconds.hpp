#pragma once

#include <vector>

namespace polhode {

/// TAI - UTC in whole seconds from 0h UTC of the first day of a month on.
struct LeapSecond {
  int year = 0;
  int month = 0;
  double tai_minus_utc_s = 0.0;
};

/// The table in use from 1972 on: ERFA's own until set_leap_seconds.
std::vector<LeapSecond> leap_seconds();

/// Replaces the table from 1972 on, for the whole process (ERFA keeps it). The entries ascend, start with 1972-01 = 10
/// s and go on by 1 s at a time, up or down, else InputError. Call it before anything is converted; it is not safe
/// beside other threads.
void set_leap_seconds(const std::vector<LeapSecond>& table);

}  // namespace polhode
