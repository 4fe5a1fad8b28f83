#pragma once

// Double-double numbers side by side in the lanes of registers, and the same names for plain lanes, so that one text
// serves both. As base/double_double.hpp, with the cheaper sum: its error is 2^-104 of the larger term, also where the
// terms cancel.

#include "polhode/motion/theta/lanes.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

struct LanePairs {
  Lanes high, low;
};

[[gnu::always_inline]] inline LanePairs lanes_fast_two_sum(Lanes a, Lanes b) {
  const Lanes s = a + b;
  return {s, b - (s - a)};
}
[[gnu::always_inline]] inline LanePairs lanes_two_sum(Lanes a, Lanes b) {
  const Lanes s = a + b;
  const Lanes bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}

[[gnu::always_inline]] inline LanePairs operator-(LanePairs a) { return {-a.high, -a.low}; }
[[gnu::always_inline]] inline LanePairs operator+(LanePairs a, LanePairs b) {
  const LanePairs s = lanes_two_sum(a.high, b.high);
  return lanes_fast_two_sum(s.high, s.low + (a.low + b.low));
}
[[gnu::always_inline]] inline LanePairs operator-(LanePairs a, LanePairs b) { return a + (-b); }
[[gnu::always_inline]] inline LanePairs operator+(LanePairs a, Lanes b) {
  const LanePairs s = lanes_two_sum(a.high, b);
  return lanes_fast_two_sum(s.high, s.low + a.low);
}
[[gnu::always_inline]] inline LanePairs operator+(LanePairs a, double b) { return a + all<Lanes>(b); }
[[gnu::always_inline]] inline LanePairs operator*(LanePairs a, LanePairs b) {
  const Lanes p = a.high * b.high;
  const Lanes cross = multiply_add(a.low, b.high, a.high * b.low);
  return lanes_fast_two_sum(p, product_error(a.high, b.high, p) + cross);
}
[[gnu::always_inline]] inline LanePairs operator*(LanePairs a, Lanes b) {
  const Lanes p = a.high * b;
  return lanes_fast_two_sum(p, multiply_add(a.low, b, product_error(a.high, b, p)));
}

/// What the text below needs of a kind of number besides + - *.
template <class Real>
struct LaneNumbers;

template <>
struct LaneNumbers<Lanes> {
  static constexpr bool kTwoParts = false;
  [[gnu::always_inline]] static inline Lanes of(Lanes a) { return a; }
  [[gnu::always_inline]] static inline Lanes constant(double high, double /*low*/) { return all<Lanes>(high); }
  [[gnu::always_inline]] static inline Lanes product(Lanes a, Lanes b) { return a * b; }
  [[gnu::always_inline]] static inline Lanes sum(Lanes a, Lanes b) { return a + b; }
  [[gnu::always_inline]] static inline Lanes quotient(Lanes a, Lanes b) { return a / b; }
  [[gnu::always_inline]] static inline Lanes root(Lanes a) { return square_root(a); }
  [[gnu::always_inline]] static inline Lanes scaled(Lanes a, Lanes power_of_two) { return a * power_of_two; }
  [[gnu::always_inline]] static inline Lanes with_small(Lanes a, Lanes small) { return a + small; }
  [[gnu::always_inline]] static inline Lanes high(Lanes a) { return a; }
  [[gnu::always_inline]] static inline Lanes low(Lanes) { return Lanes{}; }
};

template <>
struct LaneNumbers<LanePairs> {
  static constexpr bool kTwoParts = true;
  [[gnu::always_inline]] static inline LanePairs of(Lanes a) { return {a, Lanes{}}; }
  [[gnu::always_inline]] static inline LanePairs constant(double high, double low) {
    return {all<Lanes>(high), all<Lanes>(low)};
  }
  [[gnu::always_inline]] static inline LanePairs product(Lanes a, Lanes b) {
    const Lanes p = a * b;
    return {p, product_error(a, b, p)};
  }
  [[gnu::always_inline]] static inline LanePairs sum(Lanes a, Lanes b) { return lanes_two_sum(a, b); }
  [[gnu::always_inline]] static inline LanePairs quotient(LanePairs a, LanePairs b) {
    const Lanes reciprocal = 1.0 / b.high;
    const Lanes q = a.high * reciprocal;
    const Lanes rest = multiply_add(-q, b.low, a.low) - product_minus(q, b.high, a.high);
    return lanes_fast_two_sum(q, rest * reciprocal);
  }
  /// Of a positive number.
  [[gnu::always_inline]] static inline LanePairs root(LanePairs a) {
    const Lanes s = square_root(a.high);
    return lanes_fast_two_sum(s, (a.low - product_minus(s, s, a.high)) / (s + s));
  }
  [[gnu::always_inline]] static inline LanePairs scaled(LanePairs a, Lanes power_of_two) {
    return {a.high * power_of_two, a.low * power_of_two};
  }
  /// A correction of no more than some last places of the high part.
  [[gnu::always_inline]] static inline LanePairs with_small(LanePairs a, Lanes small) {
    return lanes_fast_two_sum(a.high, a.low + small);
  }
  [[gnu::always_inline]] static inline Lanes high(LanePairs a) { return a.high; }
  [[gnu::always_inline]] static inline Lanes low(LanePairs a) { return a.low; }
};

/// b where the mask (a comparison's) is set, else a.
[[gnu::always_inline]] inline Lanes where(LaneBits mask, Lanes b, Lanes a) {
  return value<Lanes>((bits(b) & mask) | (bits(a) & ~mask));
}
[[gnu::always_inline]] inline LanePairs where(LaneBits mask, LanePairs b, LanePairs a) {
  return {where(mask, b.high, a.high), where(mask, b.low, a.low)};
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
