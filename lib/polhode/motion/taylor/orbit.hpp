#pragma once

#include "polhode/motion/taylor/equations.hpp"
#include "polhode/motion/taylor/series.hpp"

namespace polhode::taylor {

inline namespace POLHODE_TARGET {

/// Orders that are computed in twice as many digits, where doubles do not hold the tolerance: what the next ones lose
/// is less by the ratio of their terms to the state.
inline constexpr int kPreciseOrders = 5;

template <int fixed_axes>
struct NoSurroundings {
  static constexpr int axes = fixed_axes, pulls = 0;
  static constexpr bool has_field = false;
  explicit NoSurroundings(const Equations& /*equations*/) {}
  void begin(const StepStart& /*start*/, int /*order*/, double /*longest*/) {}
  void next(int /*n*/) {}
  void find_precise(const long double (&/*state*/)[3]) {}
  double strength() const { return 0.0; }
  double longest() const { return 1e300; }
  template <bool precise>
  void move(double /*h*/, int /*order*/, long double (&/*state*/)[3]) const {}
};

/// Any others, as series that find_surroundings() gives.
class AnySurroundings {
 public:
  static constexpr int axes = 3, pulls = 6;
  static constexpr bool has_field = true;
  explicit AnySurroundings(const Equations& equations) : equations_(equations) {}
  void begin(const StepStart& start, int order, double longest) {
    find_surroundings(equations_, start, order, longest, now_);
  }
  void next(int /*n*/) {}
  void find_precise(const long double (&/*state*/)[3]) {
    for (int n = 0; n <= kPreciseOrders; ++n) {
      for (int i = 0; i < 6; ++i) low_.tide[i][n] = {now_.tide[i][n], 0.0};
      for (int i = 0; i < 3; ++i) low_.field[i][n] = {now_.field[i][n], 0.0};
      for (int i = 0; i < 3; ++i) low_.change[i][n] = {now_.change[i][n], 0.0};
    }
  }
  double strength() const {
    return __builtin_sqrt(__builtin_fabs(now_.tide[0][0]) + __builtin_fabs(now_.tide[1][0]) +
                          __builtin_fabs(now_.tide[2][0]));
  }
  double longest() const { return now_.longest; }
  template <bool precise>
  void move(double /*h*/, int /*order*/, long double (&/*state*/)[3]) const {}

  const double* along(int k, double /*like*/) const { return now_.tide[k]; }
  const TwoParts* along(int k, TwoParts /*like*/) const { return low_.tide[k]; }
  const double* field(int k, double /*like*/) const { return now_.field[k]; }
  const TwoParts* field(int k, TwoParts /*like*/) const { return low_.field[k]; }
  const double* change(int k, double /*like*/) const { return now_.change[k]; }
  const TwoParts* change(int k, TwoParts /*like*/) const { return low_.change[k]; }

 private:
  struct Low {
    TwoParts tide[6][kPreciseOrders + 1], field[3][kPreciseOrders + 1], change[3][kPreciseOrders + 1];
  };
  const Equations& equations_;
  Surroundings now_;
  Low low_;
};

/// p = sqrt(3 mu/r^5) r on a Kepler orbit, as series. With the true anomaly's cosine c and sine s, v^2 = 1 + e c and
/// the rate n = sqrt(mu/parameter^3),
///
///     c' = -n v^4 s,   s' = n v^4 c,   v' = -(e/2) n v^3 s,       p = sqrt(3) n v^3 (c, s)
///
/// so that every product is one of pairs, for any eccentricity.
///
/// And with_field the field of a dipole at the point mass, along three fixed axes: with the dipole's direction a,
/// field = k v^6 (3 (a . r) r - a) for a unit vector r = (c, s, 0).
template <bool with_field>
class PlanarOrbit {
 public:
  static constexpr int axes = with_field ? 3 : 2, pulls = 2;
  static constexpr bool has_field = with_field;
  const double* along(int k, double /*like*/) const { return p_[k]; }
  const TwoParts* along(int k, TwoParts /*like*/) const { return low_p_[k]; }
  const double* field(int k, double /*like*/) const { return field_[k]; }
  const TwoParts* field(int k, TwoParts /*like*/) const { return low_field_[k]; }
  const double* change(int k, double /*like*/) const { return change_[k]; }
  const TwoParts* change(int k, TwoParts /*like*/) const { return low_change_[k]; }

  explicit PlanarOrbit(const Equations& equations)
      : eccentricity_(equations.orbit.eccentricity),
        rate_(static_cast<double>(equations.orbit.rate)),
        strength_(kSqrt3 * rate_),
        exact_rate_(equations.orbit.rate),
        dipole_{equations.orbit.dipole[0], equations.orbit.dipole[1], equations.orbit.dipole[2]} {}

  /// The first coefficient; those after it come one by one, as far as they count within `longest`.
  void begin(const StepStart& start, int /*order*/, double longest) {
    c_[0] = start.orbit[0], s_[0] = start.orbit[1], v_[0] = start.orbit[2];
    longest_ = longest, power_ = 1.0, orders_ = kMostOrder;
    next(0);
  }
  /// The coefficient n of p, n + 1 of the orbit.
  [[gnu::always_inline]] void next(int n) {
    if (n > orders_) {
      p_[0][n] = p_[1][n] = 0.0;
      if constexpr (with_field) set_field(n, 0.0, 0.0, 0.0);
      return;
    }
    Vector squares = {}, last = {}, fields = {};
    for (int j = 1; j < n; ++j) {
      add_product(squares, left_[j], right_[n - j]);
      add_product(last, powers_[j], sines_[n - j]);
      if constexpr (with_field) add_product(fields, sixths_[j], places_[n - j]);
    }
    const double v2_0 = n > 0 ? left_[0][1] : v_[0] * v_[0];
    const double v2 = n > 0 ? squares[0] + 2.0 * v_[0] * v_[n] : v2_0;
    const double v3 = n > 0 ? squares[1] + (v2_0 * v_[n] + v2 * v_[0]) : v2 * v_[0];
    const double v4 = n > 0 ? squares[2] + 2.0 * v2_0 * v2 : v2 * v2;
    left_[n] = Vector{v_[n], v2, v2, v2};
    right_[n] = Vector{v_[n], v_[n], v2, v4};
    if constexpr (with_field) {
      const double v6 = n > 0 ? squares[3] + (v2_0 * v4 + v2 * right_[0][3]) : v2 * v4;
      const double along = dipole_[0] * c_[n] + dipole_[1] * s_[n];
      const double along_0 = n > 0 ? places_[0][0] : along, v6_0 = n > 0 ? sixths_[0][0] : v6;
      const double y = n > 0 ? fields[0] + (v6_0 * along + v6 * along_0) : v6 * along;
      sixths_[n] = Vector{v6, y, y, 0.0};
      places_[n] = Vector{along, c_[n], s_[n], 0.0};
      add_newest(
          [&](int j, int m) __attribute__((always_inline)) { add_product(fields, sixths_[j], places_[m - j]); }, n);
      set_field(n, fields[1], fields[2], v6);
    }
    powers_[n] = Vector{v3, v3, v4, v4};
    sines_[n] = Vector{c_[n], s_[n], c_[n], s_[n]};
    add_newest(
        [&](int j, int m) __attribute__((always_inline)) { add_product(last, powers_[j], sines_[m - j]); }, n);
    p_[0][n] = strength_ * last[0];
    p_[1][n] = strength_ * last[1];
    const double share = rate_ / (n + 1);
    c_[n + 1] = -share * last[3];
    s_[n + 1] = share * last[2];
    v_[n + 1] = -0.5 * eccentricity_ * share * last[1];
    power_ *= longest_;
    const double left_out = __builtin_fabs(c_[n + 1]) + __builtin_fabs(s_[n + 1]) + __builtin_fabs(v_[n + 1]) +
                            __builtin_fabs(last[0]) + __builtin_fabs(last[1]);
    if (n > 2 && left_out * power_ < kCounts) orders_ = n;
  }
  /// A share of r/|v|: an encounter is never stepped over, however weak its torque still is.
  double longest() const {
    const double v2 = v_[0] * v_[0];
    const double speed2 = 1.0 + eccentricity_ * (2.0 * c_[0] + eccentricity_);  // times mu/parameter
    return kShareOfTimeScale / (v2 * rate_ * __builtin_sqrt(speed2));
  }
  /// The low orders in long double; of a field, in double, when they are known.
  void find_precise(const long double (&state)[3]) {
    if constexpr (with_field) {
      for (int k = 0; k < 3; ++k) {
        for (int n = 0; n <= kPreciseOrders; ++n) {
          low_field_[k][n] = {field_[k][n], 0.0};
          low_change_[k][n] = {change_[k][n], 0.0};
        }
      }
    }
    const long double rate = exact_rate_, strength = 1.7320508075688772935274463L * rate;
    long double v2[kPreciseOrders + 1], v3[kPreciseOrders + 1], v4[kPreciseOrders + 1];
    long double(&c)[kPreciseOrders + 1] = low_[0], (&s)[kPreciseOrders + 1] = low_[1],
                                     (&v)[kPreciseOrders + 1] = low_[2];
    c[0] = state[0], s[0] = state[1], v[0] = state[2];
    for (int n = 0;; ++n) {
      const auto product = [n](const long double* a, const long double* b) {
        long double sum = 0;
        for (int j = 0; j <= n; ++j) sum += a[j] * b[n - j];
        return sum;
      };
      v2[n] = product(v, v);
      v3[n] = product(v2, v);
      v4[n] = product(v2, v2);
      const long double x = product(v3, c), y = product(v3, s);
      const long double p[2] = {strength * x, strength * y};
      for (int k = 0; k < 2; ++k) {
        low_p_[k][n].high = static_cast<double>(p[k]);
        low_p_[k][n].low = static_cast<double>(p[k] - low_p_[k][n].high);
      }
      if (n == kPreciseOrders) break;
      const long double share = rate / (n + 1);
      c[n + 1] = -share * product(v4, s);
      s[n + 1] = share * product(v4, c);
      v[n + 1] = -static_cast<long double>(eccentricity_) / 2 * share * y;
    }
  }
  /// Size of p.
  double strength() const { return strength_ * v_[0] * v_[0] * v_[0]; }

  /// From the coefficients up to `order`.
  template <bool precise>
  void move(double h, int order, long double (&state)[3]) const {
    const double* const series[3] = {c_, s_, v_};
    for (int i = 0; i < 3; ++i) {
      double sum = 0.0;
      for (int n = order < orders_ ? order : orders_; n > (precise ? kPreciseOrders : 0); --n)
        sum = (sum + series[i][n]) * h;
      if constexpr (precise) {
        long double all_orders = sum / h;
        for (int n = kPreciseOrders; n >= 0; --n) all_orders = all_orders * h + low_[i][n];
        state[i] = all_orders;
      } else {
        state[i] += sum;
      }
    }
  }

 private:
  [[gnu::always_inline]] void set_field(int n, double yc, double ys, double v6) {
    const double field[3] = {3.0 * yc - dipole_[0] * v6, 3.0 * ys - dipole_[1] * v6, -dipole_[2] * v6};
    for (int k = 0; k < 3; ++k) {
      field_[k][n] = field[k];
      if (n > 0) change_[k][n - 1] = n * field[k];
    }
  }

  static constexpr double kSqrt3 = 1.7320508075688772935;
  static constexpr double kCounts = 1e-18;
  static constexpr double kShareOfTimeScale = 0.7;

  double eccentricity_, rate_, strength_;
  long double exact_rate_;
  double dipole_[3];
  double longest_ = 0.0, power_ = 1.0;
  int orders_ = 0;
  Vector left_[kMostOrder + 1], right_[kMostOrder + 1];  // (v, v^2, v^2, v^2), (v, v, v^2, v^4)
  Vector powers_[kMostOrder + 1], sines_[kMostOrder + 1];
  double c_[kMostOrder + 2], s_[kMostOrder + 2], v_[kMostOrder + 2];
  double p_[2][kMostOrder + 1];
  long double low_[3][kPreciseOrders + 1];
  TwoParts low_p_[2][kPreciseOrders + 1];
  Vector sixths_[with_field ? kMostOrder + 1 : 1], places_[with_field ? kMostOrder + 1 : 1];
  double field_[3][with_field ? kMostOrder + 1 : 1], change_[3][with_field ? kMostOrder + 1 : 1];
  TwoParts low_field_[3][kPreciseOrders + 1], low_change_[3][kPreciseOrders + 1];
};

}  // namespace POLHODE_TARGET
}  // namespace polhode::taylor
