#include "polhode/time/clock.hpp"

#include <cmath>
#include <numbers>

#include "polhode/time/scale_detail.hpp"

namespace polhode {

double ScaleClock::tdb_minus_tt_s(double tt_s) {
  const double piece_s = piece_days * 86400.0;
  const double index = std::floor(tt_s / piece_s);
  const auto key = static_cast<std::int64_t>(index);
  auto found = pieces_.find(key);
  if (found == pieces_.end()) {
    std::array<double, piece_terms> value{};
    for (int j = 0; j < piece_terms; ++j) {
      const double x = std::cos(std::numbers::pi * (j + 0.5) / piece_terms);
      value[static_cast<std::size_t>(j)] = detail::tdb_minus_tt_s((index + 0.5 + 0.5 * x) * piece_s);
    }
    std::array<double, piece_terms> coefficient{};
    for (int k = 0; k < piece_terms; ++k) {
      double sum = 0.0;
      for (int j = 0; j < piece_terms; ++j) {
        sum += value[static_cast<std::size_t>(j)] * std::cos(std::numbers::pi * k * (j + 0.5) / piece_terms);
      }
      coefficient[static_cast<std::size_t>(k)] = sum * (k == 0 ? 1.0 : 2.0) / piece_terms;
    }
    found = pieces_.emplace(key, coefficient).first;
  }
  const double x = 2.0 * (tt_s / piece_s - index) - 1.0;
  double b1 = 0.0, b2 = 0.0;  // Clenshaw
  for (std::size_t k = piece_terms - 1; k > 0; --k) {
    const double b0 = 2.0 * x * b1 - b2 + found->second[k];
    b2 = b1;
    b1 = b0;
  }
  return x * b1 - b2 + found->second[0];
}

Seconds ScaleClock::since_j2000(Instant instant) {
  if (scale_ != TimeScale::tdb) return polhode::since_j2000(instant, scale_);
  const Seconds tt = instant.tt_since_j2000();
  return tt + Seconds{tdb_minus_tt_s(tt.high), 0.0};
}

Instant ScaleClock::instant_from_j2000(Seconds since) {
  if (scale_ != TimeScale::tdb) return polhode::instant_from_j2000(since, scale_);
  // Two steps, as there.
  const double first_tt_s = since.high - tdb_minus_tt_s(since.high);
  return Instant::from_tt_j2000(since - Seconds{tdb_minus_tt_s(first_tt_s), 0.0});
}

Instant ScaleClock::parse_date(std::string_view text) {
  if (scale_ != TimeScale::tdb) return polhode::parse_date(text, scale_);
  return instant_from_j2000(detail::parse_uniform(text, scale_));
}

std::string ScaleClock::format_date(Instant instant, int decimals) {
  if (scale_ != TimeScale::tdb) return polhode::format_date(instant, scale_, decimals);
  return detail::format_uniform(since_j2000(instant), decimals);
}

}  // namespace polhode
