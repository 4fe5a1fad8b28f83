#pragma once

// The equations of motion as power series in time. With the rate omega in the principal axes, and the directions a_k of
// fixed axes seen from there,
//
//     omega' = w * (omega_2 omega_3, ...) + torque over the moments,      a_k' = a_k x omega,      w = (I2 - I3)/I1,
//     ...
//
// and every torque here is made of products of such vectors, so that the coefficient n of each product is a sum over
// coefficients that are known (Moore 1966, Interval Analysis; Jorba & Zou 2005, Exper. Math. 14, 99). A vector is one
// register, and the sums of all products of an order run side by side.

#include <tuple>

#include "polhode/motion/taylor/equations.hpp"
#include "polhode/motion/taylor/vectors.hpp"

namespace polhode::taylor {

inline namespace POLHODE_TARGET {

/// A vector function of time by its coefficients, and the same with its components in the order y, z, x.
template <class V, int orders>
struct VectorSeries {
  V xyz[orders + 1], yzx[orders + 1];

  [[gnu::always_inline]] void set(int n, const V& value) {
    xyz[n] = value;
    yzx[n] = taylor::yzx(value);
  }
};

/// The coefficient of a x b: sum of a_j x b_(n - j).
template <class V>
struct CrossProduct {
  V more = {}, less = {};  // in the order z, x, y; two sums are two chains of additions
  template <class A, int orders, class B, int others>
  [[gnu::always_inline]] void add(const VectorSeries<A, orders>& a, const VectorSeries<B, others>& b, int j, int n) {
    add_product(more, a.xyz[j], b.yzx[n - j]);
    add_product(less, a.yzx[j], b.xyz[n - j]);
  }
  [[gnu::always_inline]] V xyz() const { return yzx(more - less); }
};

/// The coefficient of (a_2 a_3, a_3 a_1, a_1 a_2).
template <class V>
struct PairProducts {
  V sum = {};  // in the order z, x, y
  template <int orders>
  [[gnu::always_inline]] void add(const VectorSeries<V, orders>& a, int j, int n) {
    add_product(sum, a.xyz[j], a.yzx[n - j]);
  }
  [[gnu::always_inline]] V xyz() const { return yzx(sum); }
};

/// The coefficient of what a small change d of a makes of the pair products.
template <class V>
struct PairChange {
  V sum = {}, other = {};
  template <class A, int orders, int others>
  [[gnu::always_inline]] void add(const VectorSeries<A, orders>& a, const VectorSeries<V, others>& d, int j, int n) {
    add_product(sum, a.xyz[j], d.yzx[n - j]);
    add_product(other, a.yzx[j], d.xyz[n - j]);
  }
  [[gnu::always_inline]] V xyz() const { return yzx(sum + other); }
};

/// Calls add(j, n) for the terms that have the newest coefficient.
template <class Add>
[[gnu::always_inline]] inline void add_newest(const Add& add, int n) {
  add(0, n);
  if (n > 0) add(n, n);
}

template <class V, int orders, int axes>
struct BodySeries {
  VectorSeries<V, orders> omega, axis[axes];
};

/// The series of a body under torques of these kinds (kinds.hpp), in the vectors V.
template <class V, int orders, int axes, template <class, int> class... Kinds>
struct Series {
  static constexpr int vectors = 1 + axes;  // of the state
  V euler_weights = {};
  V constant = {};  ///< a torque that stays in body axes, over the moments
  BodySeries<V, orders, axes> body;
  std::tuple<Kinds<V, orders>...> torques;
  template <class W, int lower>
  using Varied = std::tuple<typename Kinds<V, orders>::template Varied<W, lower>...>;

  /// Whether the last torque makes the axes slip in the body (Slip in kinds.hpp).
  static constexpr bool slips = [] {
    if constexpr (sizeof...(Kinds) > 0) {
      using Last = std::tuple_element_t<sizeof...(Kinds) - 1, std::tuple<Kinds<V, orders>...>>;
      return requires(Last & last) { last.rate; };
    } else {
      return false;
    }
  }();
  /// What the axes turn with.
  [[gnu::always_inline]] const VectorSeries<V, orders>& turning_rate() const {
    if constexpr (slips) {
      return std::get<sizeof...(Kinds) - 1>(torques).rate;
    } else {
      return body.omega;
    }
  }

  VectorSeries<V, orders>& state(int i) { return i == 0 ? body.omega : body.axis[i - 1]; }

  /// From the coefficients up to n, those with n + 1.
  [[gnu::always_inline]] void next(int n) {
    PairProducts<V> products;
    CrossProduct<V> turn[axes];
    std::tuple<typename Kinds<V, orders>::Sums...> sums;
    const auto for_each_torque = [&](const auto& use) __attribute__((always_inline)) {
      [&]<std::size_t... i>(std::index_sequence<i...>) __attribute__((always_inline)) {
        (use(std::get<i>(torques), std::get<i>(sums)), ...);
      }
      (std::index_sequence_for<Kinds<V, orders>...>{});
    };
    for (int j = 1; j < n; ++j) {
      products.add(body.omega, j, n);
      for (int k = 0; k < axes; ++k) turn[k].add(body.axis[k], turning_rate(), j, n);
      for_each_torque([&](auto& torque, auto& sum) __attribute__((always_inline)) { torque.add(body, sum, j, n); });
    }
    add_newest(
        [&](int j, int m) __attribute__((always_inline)) { products.add(body.omega, j, m); }, n);
    if constexpr (slips) std::get<sizeof...(Kinds) - 1>(torques).slip(body, products.xyz(), n);
    for (int k = 0; k < axes; ++k) {
      add_newest(
          [&](int j, int m) __attribute__((always_inline)) { turn[k].add(body.axis[k], turning_rate(), j, m); }, n);
    }
    V change = {};
    if (n == 0) change = constant;
    add_product(change, products.xyz(), euler_weights);
    for_each_torque([&](auto& torque, auto& sum)
                        __attribute__((always_inline)) { torque.finish(body, sum, n, change); });
    const double share = 1.0 / (n + 1);
    body.omega.set(n + 1, over(change, n + 1, share));
    for (int k = 0; k < axes; ++k) body.axis[k].set(n + 1, over(turn[k].xyz(), n + 1, share));
  }
};

/// What a small change, or several in W, makes of a motion, to first order: of the rate, and a small turn of the body
/// in its axes,
///
///     turn' = turn x omega + change of omega,      change of a vector v that is fixed outside: v x turn
template <int orders, class Series, class W = Vector>
struct Variation {
  VectorSeries<W, orders> omega, turn;
  typename Series::template Varied<W, orders> varied;  ///< of each torque

  /// From the coefficients up to n, those with n + 1; `series` has them up to n.
  [[gnu::always_inline]] void next(const Series& series, int n) {
    PairChange<W> products;
    CrossProduct<W> turning;
    for (int j = 0; j <= n; ++j) {
      products.add(series.body.omega, omega, j, n);
      turning.add(turn, series.turning_rate(), j, n);
    }
    W turning_rate = omega.xyz[n];
    if constexpr (Series::slips) {
      constexpr std::size_t last = std::tuple_size_v<decltype(varied)> - 1;
      std::get<last>(series.torques).slip_varied(*this, std::get<last>(varied), products.xyz(), n);
      turning_rate = turning_rate + std::get<last>(varied).kl.xyz[n];
    }
    W change = {};
    add_product(change, products.xyz(), series.euler_weights);
    [&]<std::size_t... i>(std::index_sequence<i...>) __attribute__((always_inline)) {
      (std::get<i>(series.torques).vary(series, *this, std::get<i>(varied), n, change), ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(varied)>>{});
    const double share = 1.0 / (n + 1);
    turn.set(n + 1, over(turning.xyz() + turning_rate, n + 1, share));
    omega.set(n + 1, over(change, n + 1, share));
  }
};

}  // namespace POLHODE_TARGET
}  // namespace polhode::taylor
