#pragma once

// Steps of the series: included by each target_*.cpp.

#include "polhode/motion/taylor/kinds.hpp"
#include "polhode/motion/taylor/orbit.hpp"

namespace polhode::taylor {
inline namespace POLHODE_TARGET {

inline constexpr int kStepsBetweenExactOrbits = 16;
inline constexpr double kRounding = 1e-16, kRoundingWhenPrecise = 1e-19, kRoundingOfOrbit = 2e-16;
inline constexpr double kMostTurn_rad = 2.5;  ///< of a step: the sign of a quaternion stays certain

template <class Around, template <class, int> class... Kinds>
struct Engine {
  using Plain = Series<Vector, kMostOrder, Around::axes, Kinds...>;
  using Precise = Series<PreciseVector, kPreciseOrders, Around::axes, Kinds...>;
  static constexpr int vectors = Plain::vectors;

  const Equations& equations;
  Around around;
  Plain plain;

  explicit Engine(const Equations& p) : equations(p), around(p) { set(plain); }

  template <class Any>
  void set(Any& series) {
    for (int i = 0; i < 3; ++i) {
      set_lane(series.euler_weights, i, equations.euler_weights[i]);
      set_lane(series.constant, i, equations.constant[i]);
    }
    [&]<std::size_t... k>(std::index_sequence<k...>) __attribute__((always_inline)) {
      (set_kind<std::remove_cvref_t<decltype(series.euler_weights)>>(std::get<k>(series.torques)), ...);
    }
    (std::index_sequence_for<Kinds<Vector, 1>...>{});
  }
  static void set_lane(Vector& v, int i, long double value) { v[i] = static_cast<double>(value); }
  static void set_lane(PreciseVector& v, int i, long double value) {
    v.high[i] = static_cast<double>(value);
    v.low[i] = static_cast<double>(value - v.high[i]);
  }
  static void set_number(double& number, long double value) { number = static_cast<double>(value); }
  static void set_number(TwoParts& number, long double value) {
    number.high = static_cast<double>(value);
    number.low = static_cast<double>(value - number.high);
  }
  template <class V, class Kind>
  void set_kind(Kind& kind) {
    const auto set_all = [&](auto& vector, const long double(&values)[3]) {
      for (int i = 0; i < 3; ++i) set_lane(vector, i, values[i]);
    };
    const long double(&w)[3] = equations.euler_weights;
    if constexpr (requires { kind.weights; }) set_all(kind.weights, {-w[0], -w[1], -w[2]});
    if constexpr (requires { kind.inverse_moments; }) set_all(kind.inverse_moments, equations.inverse_moments);
    if constexpr (requires { kind.rate; }) {
      const long double(&m)[3] = equations.moments;
      set_all(kind.weights,
              {equations.slip * (m[1] - m[2]), equations.slip * (m[2] - m[0]), equations.slip * (m[0] - m[1])});
      set_all(kind.moments, m);
    }
    if constexpr (requires { kind.components; }) {
      for (int k = 0; k < 3; ++k) set_number(kind.components[k], equations.outside[k]);
    }
    if constexpr (requires { kind.columns; }) {
      for (int k = 0; k < 3; ++k) {
        if constexpr (requires { kind.field; }) {
          for (int i = 0; i < 3; ++i) set_lane(kind.columns[k], i, equations.magnetic_tensor[k][i]);
        } else {
          set_all(kind.columns[k], equations.damping[k]);
        }
      }
    }
    if constexpr (requires { around.of(Number<V>{}); }) {
      const auto& series = around.of(Number<V>{});
      if constexpr (requires { kind.along; }) {
        for (int k = 0; k < 6; ++k) kind.along[k] = series.tide[k];
      }
      if constexpr (requires { kind.field; }) {
        for (int k = 0; k < 3; ++k) kind.field[k] = series.field[k], kind.change[k] = series.change[k];
      }
    } else if constexpr (requires { kind.along; }) {
      for (auto& series : kind.along) series = around.along(static_cast<int>(&series - kind.along), Number<V>{});
    } else if constexpr (requires { kind.field; }) {
      for (int k = 0; k < 3; ++k) {
        kind.field[k] = around.field(k, Number<V>{});
        kind.change[k] = around.change(k, Number<V>{});
      }
    }
  }

  /// The orders from `from` on.
  [[gnu::always_inline]] void go_on(int from, int order) {
    for (int n = from; n < order; ++n) {
      around.next(n + 1);
      plain.next(n);
    }
  }
};

inline double larger(double a, double b) { return a > b ? a : b; }
inline double smaller(double a, double b) { return a < b ? a : b; }

[[gnu::always_inline]] inline double largest_component(Vector v) {
  const double x = __builtin_fabs(v[0]), y = __builtin_fabs(v[1]), z = __builtin_fabs(v[2]);
  return larger(x, larger(y, z));
}

[[gnu::always_inline]] inline Vector cross(Vector a, Vector b) { return yzx(a * yzx(b) - yzx(a) * b); }

/// The polynomial with these coefficients; the even and the odd ones by themselves, which takes half the time.
[[gnu::always_inline]] inline Vector sum_of(const Vector* coefficients, int order, double t) {
  const Vector t2 = all(t * t);
  Vector even = coefficients[order - order % 2], odd = coefficients[order - 1 + order % 2];
  for (int n = order - order % 2 - 2; n >= 0; n -= 2) {
    Vector next = coefficients[n];
    add_product(next, even, t2);
    even = next;
  }
  for (int n = order - 3 + order % 2; n > 0; n -= 2) {
    Vector next = coefficients[n];
    add_product(next, odd, t2);
    odd = next;
  }
  add_product(even, odd, all(t));
  return even;
}

/// A number between -1 and 1 in each lane (Marsaglia's xorshift).
[[gnu::always_inline]] inline Vector random_signs(unsigned long long& state) {
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  const auto part = [&](int shift) {
    return static_cast<double>(static_cast<int>((state >> shift) & 0xffff) - 0x8000) * 0x1p-15;
  };
  return Vector{part(0), part(16), part(32), part(48)};
}

/// Orders in which the difference is carried along: by a seventh or eighth order a swing of up to 1.7 rad in a step
/// does not grow, which by a fifth or sixth it would.
inline constexpr int kVariationOrders = 8;

template <bool precise, class Around, template <class, int> class... Kinds>
int advance_with(const Equations& equations, const Stepping& stepping, int most, Front& front, StepStart* starts) {
  using E = Engine<Around, Kinds...>;
  constexpr int vectors = E::vectors;
  E engine(equations);
  typename E::Precise low;
  if constexpr (precise) engine.set(low);
  Variation<kVariationOrders, typename E::Plain> variation;
  Vector high[vectors], rest[vectors], rate_error, turn_error;
  __builtin_memcpy(high, front.high, sizeof high);
  __builtin_memcpy(rest, front.low, sizeof rest);
  __builtin_memcpy(&rate_error, front.rate_error, sizeof rate_error);
  __builtin_memcpy(&turn_error, front.turn_error_rad, sizeof turn_error);
  const int order = stepping.order;
  const double direction = stepping.end > front.t_high ? 1.0 : -1.0;
  int taken = 0;
  while (taken < most && front.t_high != stepping.end) {
    if (equations.orbit.orbit != nullptr && --front.until_exact_orbit <= 0) {
      exact_orbit(equations, front.t_high, front.t_low, front.orbit);
      front.until_exact_orbit = kStepsBetweenExactOrbits;
    }
    StepStart& start = starts[taken++];
    start.t_high = front.t_high, start.t_low = front.t_low, start.order = order;
    start.direction = direction > 0.0 ? 1 : -1;
    for (int i = 0; i < vectors; ++i) __builtin_memcpy(start.state[i], &high[i], sizeof start.state[i]);
    for (int i = 0; i < 3; ++i) start.orbit[i] = static_cast<double>(front.orbit[i]);

    engine.around.begin(start, order, front.longest);
    if constexpr (precise) {
      for (int n = 1; n <= kPreciseOrders; ++n) engine.around.next(n);
      engine.around.find_precise(front.orbit);
    }
    auto& plain = engine.plain;
    int known = 0;
    if constexpr (precise) {
      for (int i = 0; i < vectors; ++i) low.state(i).set(0, {high[i], rest[i]});
      for (; known < kPreciseOrders; ++known) low.next(known);
      for (int i = 0; i < vectors; ++i) {
        for (int n = 0; n <= kPreciseOrders; ++n) plain.state(i).set(n, low.state(i).xyz[n].high);
      }
      [&]<std::size_t... k>(std::index_sequence<k...>) __attribute__((always_inline)) {
        for (int n = 0; n < kPreciseOrders; ++n) (std::get<k>(plain.torques).take(std::get<k>(low.torques), n), ...);
      }
      (std::index_sequence_for<Kinds<Vector, 1>...>{});
    } else {
      for (int i = 0; i < vectors; ++i) plain.state(i).set(0, high[i]);
    }
    variation.omega.set(0, rate_error);
    variation.turn.set(0, turn_error);
    // Both chains side by side: each waits for its own last order.
    for (int n = 0; n < known; ++n) variation.next(plain, n);
    for (int n = known; n < kVariationOrders; ++n) {
      engine.around.next(n + 1);
      plain.next(n);
      variation.next(plain, n);
    }
    engine.go_on(kVariationOrders, order);

    double size[3] = {};  // of the last coefficients
    for (int n = 0; n < 3; ++n) {
      for (int i = 0; i < vectors; ++i) {
        size[n] = larger(size[n], largest_component(plain.state(i).xyz[order - n]));
      }
    }
    double h = smaller(__builtin_pow(stepping.local_error / size[0], 1.0 / order),
                       __builtin_pow(stepping.local_error / size[1], 1.0 / (order - 1)));
    const Vector omega = high[0];
    const double rate = __builtin_sqrt(omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2]);
    h = smaller(smaller(h, kMostTurn_rad / rate), smaller(front.longest, engine.around.longest()));
    front.longest = 2.0 * h;
    const double remaining = (stepping.end - front.t_high) - front.t_low;
    const bool ends = h >= __builtin_fabs(remaining) * 0.999;
    h = ends ? remaining : direction * smaller(h, 0.5 * __builtin_fabs(remaining));  // no sliver at the end

    // What the series leaves out is about (h/radius)^2 of its last two terms. (Of both: one of the two may be of the
    // kind that changes the phase alone, and the other change the energy, which counts for more.)
    const double ratio2 = size[2] > 0.0 ? smaller(0.81, size[0] / size[2] * h * h) : 0.0;
    const double shrink = ratio2 / (1.0 - __builtin_sqrt(ratio2));
    const double power = __builtin_powi(h, order - 1);
    const Vector noise = random_signs(front.random) * all(precise ? kRoundingWhenPrecise : kRounding);
    // The rate feels the rounding of the orbit, too.
    const double pull = engine.around.strength();
    rate_error = sum_of(variation.omega.xyz, kVariationOrders, h) + noise +
                 random_signs(front.random) * all(kRoundingOfOrbit * (precise ? 1e-3 : 1.0) * pull * pull * h);
    turn_error = sum_of(variation.turn.xyz, kVariationOrders, h) + yzx(noise);
    for (int i = 0; i < vectors; ++i) {
      const auto& s = plain.state(i);
      const Vector left_out = (s.xyz[order - 1] + s.xyz[order] * all(h)) * all(power * shrink);
      if constexpr (precise) {
        Vector sum = s.xyz[order];
        for (int n = order - 1; n > kPreciseOrders; --n) sum = s.xyz[n] + sum * all(h);
        PreciseVector next{sum, Vector{}};
        for (int n = kPreciseOrders; n >= 0; --n) next = low.state(i).xyz[n] + next * h;
        high[i] = next.high, rest[i] = next.low;
      } else {
        const PreciseVector next = two_sum(high[i], sum_of(s.xyz + 1, order - 1, h) * all(h) + rest[i]);
        high[i] = next.high, rest[i] = next.low;
      }
      if (i == 0) {
        rate_error += left_out;
      } else {
        turn_error += cross(left_out, high[i]);  // (of two directions alone: what turns about the third, twice)
      }
    }
    const double turned2 =
        turn_error[0] * turn_error[0] + turn_error[1] * turn_error[1] + turn_error[2] * turn_error[2];
    front.worst_rad = larger(front.worst_rad, __builtin_sqrt(turned2));
    engine.around.template move<precise>(h, order, front.orbit);
    if (ends) {
      front.t_high = stepping.end, front.t_low = 0.0;
    } else {
      const double t = front.t_high + h;
      const double back = t - front.t_high;
      front.t_low += (front.t_high - (t - back)) + (h - back);
      front.t_high = t;
    }
  }
  __builtin_memcpy(front.high, high, sizeof high);
  __builtin_memcpy(front.low, rest, sizeof rest);
  __builtin_memcpy(front.rate_error, &rate_error, sizeof rate_error);
  __builtin_memcpy(front.turn_error_rad, &turn_error, sizeof turn_error);
  return taken;
}

template <class Around, template <class, int> class... Kinds>
int advance(const Equations& equations, const Stepping& stepping, int most, Front& front, StepStart* starts) {
  return stepping.precise ? advance_with<true, Around, Kinds...>(equations, stepping, most, front, starts)
                          : advance_with<false, Around, Kinds...>(equations, stepping, most, front, starts);
}

template <class Around, template <class, int> class... Kinds>
void coefficients_of(const Equations& equations, const StepStart& start, int order, double length,
                     double (*out)[kMostVectors][4]) {
  using E = Engine<Around, Kinds...>;
  E engine(equations);
  engine.around.begin(start, order, length);
  for (int i = 0; i < E::vectors; ++i) {
    engine.plain.state(i).set(0, Vector{start.state[i][0], start.state[i][1], start.state[i][2], 0.0});
  }
  engine.go_on(0, order);
  for (int n = 0; n <= order; ++n) {
    for (int i = 0; i < E::vectors; ++i) __builtin_memcpy(out[n][i], &engine.plain.state(i).xyz[n], sizeof(Vector));
  }
}

/// The rate and two fixed axes at the time t of a step: Horner's rule for even and for odd powers, all side by side.
inline void evaluate(const double (*coefficients)[kMostVectors][4], int order, double t, double (*state)[4]) {
  constexpr int kVectors = 3;
  Vector sums[2][kVectors] = {};
  const Vector t1 = all(t), t2 = t1 * t1;
  for (int n = order | 1; n > 0; n -= 2) {
    for (int i = 0; i < kVectors; ++i) {
      Vector even, odd = {};
      __builtin_memcpy(&even, coefficients[n - 1][i], sizeof even);
      if (n <= order) __builtin_memcpy(&odd, coefficients[n][i], sizeof odd);
      sums[0][i] = even + sums[0][i] * t2;
      sums[1][i] = odd + sums[1][i] * t2;
    }
  }
  for (int i = 0; i < kVectors; ++i) {
    const Vector sum = sums[0][i] + sums[1][i] * t1;
    __builtin_memcpy(state[i], &sum, sizeof sum);
  }
}

/// The sets of torques that are compiled; the first that has all of a body's torques serves.
struct Entry {
  int (*advance)(const Equations&, const Stepping&, int, Front&, StepStart*);
  void (*coefficients)(const Equations&, const StepStart&, int, double, double (*)[kMostVectors][4]);
};
template <class Around, template <class, int> class... Kinds>
inline constexpr Entry kEntry = {advance<Around, Kinds...>, coefficients_of<Around, Kinds...>};
inline constexpr Entry kEntries[] = {
    kEntry<NoSurroundings<2>>,                                    // a torque that keeps its components
    kEntry<NoSurroundings<2>, Damping>,                           //
    kEntry<PlanarOrbit<false>, Pull<2>::Kind>,                    // and one point mass
    kEntry<PlanarOrbit<false>, Pull<2>::Kind, Damping>,           //
    kEntry<NoSurroundings<3>, Damping, Outside, Slip>,            // all that needs no surroundings
    kEntry<AnySurroundings, Tide>,                                // point masses on any ways
    kEntry<AnySurroundings, Tide, Damping, Outside, Eddy, Slip>,  // everything
    kEntry<PlanarOrbit<true>, Pull<2>::Kind, Damping, Eddy>,      // a dipole at the only point mass
};

inline int advance_entry(const Equations& equations, const Stepping& stepping, int most, Front& front,
                         StepStart* starts) {
  return kEntries[equations.kinds].advance(equations, stepping, most, front, starts);
}
inline void coefficients_entry(const Equations& equations, const StepStart& start, int order, double length,
                               double (*out)[kMostVectors][4]) {
  kEntries[equations.kinds].coefficients(equations, start, order, length, out);
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::taylor
