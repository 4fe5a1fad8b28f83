#pragma once

// Steps of the series: included by each target_*.cpp.

#include "polhode/motion/taylor/kinds.hpp"
#include "polhode/motion/taylor/orbit.hpp"

namespace polhode::taylor {
inline namespace POLHODE_TARGET {

inline constexpr int kStepsBetweenExactOrbits = 16;
inline constexpr double kRounding = 1e-16, kRoundingWhenPrecise = 1e-19, kRoundingOfOrbit = 2e-16;
inline constexpr double kMostTurn_rad = 2.5;  ///< of a step: the sign of a quaternion stays certain

/// By three parameters.
struct NumberChanges {
  const BodyNumbers* by[3] = {};
};

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
    set(series, equations, around);
  }
  template <class Any, class Source>
  static void set(Any& series, const BodyNumbers& numbers, const Source& source, const NumberChanges& changes = {}) {
    using V = std::remove_cvref_t<decltype(series.euler_weights)>;
    const auto set_all = [&](V& vector, const auto& of) {
      const Three values = of(numbers);
      for (int i = 0; i < 3; ++i) set_lane(vector, i, values[i]);
      if constexpr (std::is_same_v<V, VaryingVector>) {
        for (int c = 0; c < 3; ++c) {
          const Three change = of(*changes.by[c]);
          for (int i = 0; i < 3; ++i) vector.change.of[c][i] = static_cast<double>(change[i]);
        }
      }
    };
    set_all(series.euler_weights, [](const BodyNumbers& p) { return three(p.euler_weights); });
    set_all(series.constant, [](const BodyNumbers& p) { return three(p.constant); });
    [&]<std::size_t... k>(std::index_sequence<k...>) __attribute__((always_inline)) {
      (set_kind<V>(std::get<k>(series.torques), numbers, changes, source, set_all), ...);
    }
    (std::index_sequence_for<Kinds<Vector, 1>...>{});
  }
  struct Three {
    long double xyz[3];
    long double operator[](int i) const { return xyz[i]; }
  };
  static Three three(const long double (&values)[3]) { return {values[0], values[1], values[2]}; }
  static void set_lane(Vector& v, int i, long double value) { v[i] = static_cast<double>(value); }
  static void set_lane(PreciseVector& v, int i, long double value) {
    v.high[i] = static_cast<double>(value);
    v.low[i] = static_cast<double>(value - v.high[i]);
  }
  static void set_lane(VaryingVector& v, int i, long double value) { set_lane(v.value, i, value); }
  static void set_number(double& number, long double value) { number = static_cast<double>(value); }
  static void set_number(TwoParts& number, long double value) {
    number.high = static_cast<double>(value);
    number.low = static_cast<double>(value - number.high);
  }
  static void set_number(Varying& number, long double value) { number.value = static_cast<double>(value); }
  template <class V, class Kind, class Source, class SetAll>
  static void set_kind(Kind& kind, const BodyNumbers& numbers, const NumberChanges& changes, const Source& source,
                       const SetAll& set_all) {
    const Number<V> like{};
    if constexpr (requires { kind.rate; }) {
      set_all(kind.weights, [](const BodyNumbers& p) { return three(p.slip_weights); });
      set_all(kind.moments, [](const BodyNumbers& p) { return three(p.moments); });
    } else if constexpr (requires { kind.weights; }) {
      set_all(kind.weights, [](const BodyNumbers& p) {
        return Three{-p.euler_weights[0], -p.euler_weights[1], -p.euler_weights[2]};
      });
    }
    if constexpr (requires { kind.inverse_moments; }) {
      set_all(kind.inverse_moments, [](const BodyNumbers& p) { return three(p.inverse_moments); });
    }
    if constexpr (requires { kind.components; }) {
      for (int k = 0; k < 3; ++k) {
        set_number(kind.components[k], numbers.outside[k]);
        if constexpr (std::is_same_v<V, VaryingVector>) {
          for (int c = 0; c < 3; ++c) kind.components[k].change[c] = static_cast<double>(changes.by[c]->outside[k]);
        }
      }
    }
    if constexpr (requires { kind.columns; }) {
      for (int k = 0; k < 3; ++k) {
        set_all(kind.columns[k], [k](const BodyNumbers& p) {
          if constexpr (requires { kind.field; }) {
            return three(p.magnetic_tensor[k]);
          } else {
            return three(p.damping[k]);
          }
        });
      }
    }
    if constexpr (requires { kind.along; }) {
      for (auto& series : kind.along) series = source.along(static_cast<int>(&series - kind.along), like);
    }
    if constexpr (requires { kind.field; }) {
      for (int k = 0; k < 3; ++k) kind.field[k] = source.field(k, like), kind.change[k] = source.change(k, like);
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

/// The surroundings of an engine with their derivatives by three parameters.
template <class Around>
class VaryingAround {
 public:
  const Varying* along(int k, const Varying& /*like*/) const { return along_[k]; }
  const Varying* field(int k, const Varying& /*like*/) const { return field_[k]; }
  const Varying* change(int k, const Varying& /*like*/) const { return change_[k]; }

  /// The parameter `c` of three.
  void find(int c, const Equations& equations, const Around& around, const ParameterChange& by, const StepStart& start,
            int order, double length) {
    const auto fill = [&]([[maybe_unused]] const auto& changing) {
      const double since = (start.t_high - by.from) + start.t_low;
      const auto set = [&](Varying* out, const double* values, const double* from, double share, int known) {
        for (int n = 0; n < order; ++n) {
          const double next = n < known ? from[n + 1] : 0.0;
          out[n].value = values[n];
          out[n].change[c] = (share + by.haste * n) * from[n] + by.haste * since * (n + 1) * next;
        }
      };
      if constexpr (Around::pulls > 0) {
        for (int k = 0; k < Around::pulls; ++k) {
          // (Along two axes not the tide, but its root.)
          set(along_[k], around.along(k, 0.0), changing.along(k, 0.0), Around::pulls == 2 ? 0.5 * by.tide : by.tide,
              order);
        }
      }
      if constexpr (Around::has_field) {
        for (int k = 0; k < 3; ++k) {
          set(field_[k], around.field(k, 0.0), changing.field(k, 0.0), by.field, order);
          set(change_[k], around.change(k, 0.0), changing.change(k, 0.0), by.own_change, order - 1);
        }
      }
    };
    if constexpr (std::is_same_v<Around, AnySurroundings>) {
      if (by.torques != nullptr) {
        Equations others = equations;
        others.torques = by.torques;
        Around changing(others);
        changing.begin(start, order, length);
        fill(changing);
        return;
      }
    }
    fill(around);
  }

 private:
  Varying along_[Around::pulls + 1][kMostOrder + 1];
  Varying field_[3][Around::has_field ? kMostOrder + 1 : 1], change_[3][Around::has_field ? kMostOrder + 1 : 1];
};

/// Columns of the partial derivatives. Those by the state have the equations of Variation; those by a parameter are the
/// motion's own, in values with their derivatives.
template <class Around, template <class, int> class... Kinds>
void vary_columns(const Equations& equations, const StepStart& start, double length,
                  std::span<const ParameterChange> parameters, const StateChange* starts, std::span<const double> times,
                  StateChange* out) {
  using E = Engine<Around, Kinds...>;
  const int order = start.order;
  const std::size_t columns = kStateColumns + parameters.size();
  E engine(equations);
  engine.around.begin(start, order, length);
  for (int i = 0; i < E::vectors; ++i) {
    engine.plain.state(i).set(0, Vector{start.state[i][0], start.state[i][1], start.state[i][2], 0.0});
  }
  engine.go_on(0, order);
  const auto put = [&](std::size_t time, std::size_t column, const Vector& rate, const Vector& turn) {
    StateChange& to = out[time * columns + column];
    __builtin_memcpy(to.rate, &rate, sizeof rate);
    __builtin_memcpy(to.turn_rad, &turn, sizeof turn);
  };
  const auto vector = [](const double(&from)[4]) { return Vector{from[0], from[1], from[2], 0.0}; };
  const auto triple = [&](std::size_t first, double(StateChange::*of)[4]) {
    return each_of([&](int k) {
      const std::size_t c = first + static_cast<std::size_t>(k);
      return c < columns ? vector(starts[c].*of) : Vector{};
    });
  };
  Variation<kMostOrder, typename E::Plain, Triple> variation[2];
  for (std::size_t i = 0; i < 2; ++i) {
    variation[i].omega.set(0, triple(3 * i, &StateChange::rate));
    variation[i].turn.set(0, triple(3 * i, &StateChange::turn_rad));
  }
  for (int n = 0; n < order; ++n) {
    for (auto& one : variation) one.next(engine.plain, n);
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    for (std::size_t c = 0; c < kStateColumns; ++c) {
      const auto sum = [&](const auto& of) {
        return sum_at([&](int n) { return of.xyz[n].of[c % 3]; }, order, times[i]);
      };
      put(i, c, sum(variation[c / 3].omega), sum(variation[c / 3].turn));
    }
  }
  if (parameters.empty()) return;
  static const ParameterChange nothing;
  VaryingAround<Around> around;
  Series<VaryingVector, kMostOrder, Around::axes, Kinds...> series;
  for (std::size_t first = 0; first < parameters.size(); first += 3) {
    const std::size_t c = kStateColumns + first;
    NumberChanges changes;
    for (std::size_t k = 0; k < 3; ++k) {
      const ParameterChange& one = first + k < parameters.size() ? parameters[first + k] : nothing;
      changes.by[k] = &one.numbers;
      around.find(static_cast<int>(k), equations, engine.around, one, start, order, length);
    }
    E::set(series, equations, around, changes);
    series.body.omega.set(0, {engine.plain.body.omega.xyz[0], triple(c, &StateChange::rate)});
    const Triple turn0 = triple(c, &StateChange::turn_rad);
    for (int k = 0; k < Around::axes; ++k) {
      const Vector axis = engine.plain.body.axis[k].xyz[0];
      series.body.axis[k].set(0, {axis, each_of([&](int i) { return cross(axis, turn0.of[i]); })});
    }
    for (int n = 0; n < order; ++n) series.next(n);
    for (std::size_t i = 0; i < times.size(); ++i) {
      Vector axis[3];
      for (int k = 0; k < Around::axes; ++k) axis[k] = sum_of(engine.plain.body.axis[k].xyz, order, times[i]);
      if constexpr (Around::axes == 2) axis[2] = cross(axis[0], axis[1]);
      for (std::size_t k = 0; k < 3 && first + k < parameters.size(); ++k) {
        const auto change = [&](const auto& of) {
          return sum_at([&](int n) { return of.xyz[n].change.of[k]; }, order, times[i]);
        };
        Vector axis_change[3], turn = {};
        for (int a = 0; a < Around::axes; ++a) axis_change[a] = change(series.body.axis[a]);
        if constexpr (Around::axes == 2) {
          axis_change[2] = cross(axis_change[0], axis[1]) + cross(axis[0], axis_change[1]);
        }
        for (int a = 0; a < 3; ++a) turn -= all(0.5) * cross(axis[a], axis_change[a]);
        put(i, c + k, change(series.body.omega), turn);
      }
    }
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
  void (*vary)(const Equations&, const StepStart&, double, std::span<const ParameterChange>, const StateChange*,
               std::span<const double>, StateChange*);
};
template <class Around, template <class, int> class... Kinds>
inline constexpr Entry kEntry = {advance<Around, Kinds...>, coefficients_of<Around, Kinds...>,
                                 vary_columns<Around, Kinds...>};
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

inline void vary_entry(const Equations& equations, const StepStart& start, double length,
                       std::span<const ParameterChange> parameters, const StateChange* starts,
                       std::span<const double> times, StateChange* out) {
  kEntries[equations.kinds].vary(equations, start, length, parameters, starts, times, out);
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::taylor
