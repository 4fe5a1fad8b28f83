#pragma once

#include <cmath>

#include "polhode/base/error.hpp"

namespace polhode {

/// A span of time in SI seconds (as TT counts them), as an unevaluated sum of two doubles.
struct Seconds {
  double high = 0.0;
  double low = 0.0;
};

/// a + b exactly, as high + low (Knuth's two-sum).
inline Seconds exact_sum(double a, double b) {
  const double s = a + b;
  const double bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}

/// a b exactly, as high + low.
inline Seconds exact_product(double a, double b) {
  const double p = a * b;
  return {p, std::fma(a, b, -p)};
}

inline Seconds operator-(Seconds a) { return {-a.high, -a.low}; }

/// Sum to about 32 digits.
inline Seconds operator+(Seconds a, Seconds b) {
  const Seconds s = exact_sum(a.high, b.high);
  const Seconds t = exact_sum(a.low, b.low);
  const Seconds u = exact_sum(s.high, s.low + t.high);
  return exact_sum(u.high, u.low + t.low);
}

inline Seconds operator-(Seconds a, Seconds b) { return a + -b; }

/// One instant, without a time scale: internally TT seconds from J2000 (2000-01-01T12:00:00 TT) in two parts, good to
/// far less than a nanosecond over all of history. Scales appear only where text or numbers come in or go out
/// (time/scale.hpp). Always finite: InputError for what would not be.
class Instant {
 public:
  Instant() = default;

  /// TT seconds from 2000-01-01T12:00:00 TT; the two parts may overlap.
  static Instant from_tt_j2000(Seconds since) { return Instant(exact_sum(since.high, since.low)); }

  Seconds tt_since_j2000() const { return since_; }

  friend Instant operator+(const Instant& a, Seconds b) { return Instant(a.since_ + b); }
  friend Seconds operator-(const Instant& a, const Instant& b) { return a.since_ - b.since_; }
  friend bool operator<(const Instant& a, const Instant& b) { return (a - b).high < 0.0; }
  friend bool operator==(const Instant& a, const Instant& b) {
    return a.since_.high == b.since_.high && a.since_.low == b.since_.low;
  }

 private:
  explicit Instant(Seconds since) : since_(since) {
    if (!std::isfinite(since.high) || !std::isfinite(since.low)) {
      throw InputError("a time that is not finite is no instant");
    }
  }

  Seconds since_;
};

}  // namespace polhode
