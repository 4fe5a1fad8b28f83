#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "polhode/time/scale.hpp"

namespace polhode {

/// Reads one scale for very many instants. Like the functions of the same names, but TDB - TT, some ten microseconds of
/// work each time, is interpolated in pieces made when first needed and kept (within 1e-15 s of eraDtdb over 1900 to
/// 2100, tests/unit/time_test.cpp). Instants may come in any order; one object per thread.
class ScaleClock {
 public:
  explicit ScaleClock(TimeScale scale) : scale_(scale) {}

  TimeScale scale() const { return scale_; }
  Seconds since_j2000(Instant instant);
  Instant instant_from_j2000(Seconds since);
  Instant parse_date(std::string_view text);
  std::string format_date(Instant instant, int decimals);

 private:
  static constexpr int piece_terms = 14;
  static constexpr double piece_days = 8.0;

  double tdb_minus_tt_s(double tt_s);

  TimeScale scale_;
  std::unordered_map<std::int64_t, std::array<double, piece_terms>> pieces_;  ///< Chebyshev coefficients
};

}  // namespace polhode
