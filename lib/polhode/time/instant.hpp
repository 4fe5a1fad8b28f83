#pragma once

namespace polhode {

/// A span of time in SI seconds (as TT counts them), as an unevaluated sum of two doubles.
struct Seconds {
  double high = 0.0;
  double low = 0.0;
};

/// One instant, without a time scale: internally TT seconds from J2000 (2000-01-01T12:00:00 TT) in two parts, good to
/// far less than a nanosecond over all of history. Scales appear only where text or numbers come in or go out
/// (time/scale.hpp).
class Instant {
 public:
  Instant() = default;

  /// TT seconds from 2000-01-01T12:00:00 TT; the two parts may overlap.
  static Instant from_tt_j2000(Seconds since) { return Instant(sum(since.high, since.low)); }

  Seconds tt_since_j2000() const { return since_; }

  friend Instant operator+(const Instant& a, Seconds b) { return Instant(add(a.since_, b)); }
  friend Seconds operator-(const Instant& a, const Instant& b) {
    return add(a.since_, Seconds{-b.since_.high, -b.since_.low});
  }
  friend bool operator<(const Instant& a, const Instant& b) { return (a - b).high < 0.0; }
  friend bool operator==(const Instant& a, const Instant& b) {
    return a.since_.high == b.since_.high && a.since_.low == b.since_.low;
  }

 private:
  explicit Instant(Seconds since) : since_(since) {}

  static Seconds sum(double a, double b) {  // Knuth's two-sum
    const double s = a + b;
    const double bb = s - a;
    return {s, (a - (s - bb)) + (b - bb)};
  }
  static Seconds add(Seconds a, Seconds b) {
    const Seconds s = sum(a.high, b.high);
    const Seconds t = sum(a.low, b.low);
    const Seconds u = sum(s.high, s.low + t.high);
    return sum(u.high, u.low + t.low);
  }

  Seconds since_;
};

}  // namespace polhode
