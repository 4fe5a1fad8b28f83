#pragma once

// The torques that have series. Each kind is a class template over the vectors V and the number of orders:
//
//     Sums                          what it sums up for one coefficient
//     add(body, sums, j, n)         the terms of coefficients j and n - j, 0 < j < n
//     finish(body, sums, n, change) the terms with the newest coefficients, and its coefficient n over the moments of
//                                   inertia to `change`
//     vary(series, variation, varied, n, change)  the coefficient n of what a small change of the state, or several,
//                                   makes of it; Varied<W, n> are the series that this needs
//     take(lower, n)                its own series' coefficient n from one of other vectors, rounded

#include "polhode/motion/taylor/series.hpp"

namespace polhode::taylor {
inline namespace POLHODE_TARGET {

/// A point mass: torque = p x (I p) with p = sqrt(3 mu/r^5) r, whose components along `axes` fixed axes are given.
template <int axes>
struct Pull {
  template <class V, int orders>
  struct Kind {
    const Number<V>* along[axes] = {};  ///< coefficients
    V weights = {};                     ///< (I3 - I2)/I1, ...
    VectorSeries<V, orders> p;

    struct Sums {
      V p[axes] = {};
      PairProducts<V> products;
    };
    template <class Body>
    [[gnu::always_inline]] void add(const Body& body, Sums& sums, int j, int n) {
      for (int k = 0; k < axes; ++k) add_product(sums.p[k], body.axis[k].xyz[j], along[k][n - j]);
      sums.products.add(p, j, n);
    }
    template <class Body>
    [[gnu::always_inline]] void finish(const Body& body, Sums& sums, int n, V& change) {
      for (int k = 0; k < axes; ++k) {
        add_newest(
            [&](int j, int m)
                __attribute__((always_inline)) { add_product(sums.p[k], body.axis[k].xyz[j], along[k][m - j]); },
            n);
        if (k > 0) sums.p[0] = sums.p[0] + sums.p[k];
      }
      p.set(n, sums.p[0]);
      add_newest(
          [&](int j, int m) __attribute__((always_inline)) { sums.products.add(p, j, m); }, n);
      add_product(change, sums.products.xyz(), weights);
    }
    template <class W, int lower>
    using Varied = VectorSeries<W, lower>;  // the change of p
    template <class Series, class Variation, class W, int lower>
    [[gnu::always_inline]] void vary(const Series& /*series*/, const Variation& variation,
                                     VectorSeries<W, lower>& p_change, int n, W& change) const {
      CrossProduct<W> turned;
      for (int j = 0; j <= n; ++j) turned.add(p, variation.turn, j, n);
      p_change.set(n, turned.xyz());
      PairChange<W> products;
      for (int j = 0; j <= n; ++j) products.add(p, p_change, j, n);
      add_product(change, products.xyz(), weights);
    }
    template <class Lower>
    [[gnu::always_inline]] void take(const Lower& lower, int n) {
      p.set(n, rounded(lower.p.xyz[n]));
    }
  };
};

/// -D omega
template <class V, int orders>
struct Damping {
  V columns[3] = {};  ///< of -D, over the moments

  struct Sums {};
  template <class Body>
  [[gnu::always_inline]] void add(const Body& /*body*/, Sums& /*sums*/, int /*j*/, int /*n*/) {}
  template <class Body>
  [[gnu::always_inline]] void finish(const Body& body, Sums& /*sums*/, int n, V& change) {
    add_product(change, all_x(body.omega.xyz[n]), columns[0]);
    add_product(change, all_x(body.omega.yzx[n]), columns[1]);
    add_product(change, all_x(yzx(body.omega.yzx[n])), columns[2]);
  }
  template <class W, int lower>
  struct Varied {};
  template <class Series, class Variation, class Nothing, class W>
  [[gnu::always_inline]] void vary(const Series& /*series*/, const Variation& variation, Nothing& /*varied*/, int n,
                                   W& change) const {
    add_product(change, all_x(variation.omega.xyz[n]), columns[0]);
    add_product(change, all_x(variation.omega.yzx[n]), columns[1]);
    add_product(change, all_x(yzx(variation.omega.yzx[n])), columns[2]);
  }
  template <class Lower>
  [[gnu::always_inline]] void take(const Lower& /*lower*/, int /*n*/) {}
};

/// Point masses of any number, on any ways: with the tide T = sum of 3 mu r r^T/r^5 in body axes, T = sum of a_k n_k^T
/// for n_k = sum of G_kl a_l, where G is the tide along the fixed axes.
///
///     torque_1 = (I3 - I2) T_23, ...
template <class V, int orders>
struct Tide {
  const Number<V>* along[6] = {};  ///< G: 11, 22, 33, 23, 31, 12
  V weights = {};                  ///< (I3 - I2)/I1, ...
  VectorSeries<V, orders> n_[3];

  static constexpr int place[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  struct Sums {
    V n[3] = {}, products = {};
  };
  template <class Body>
  [[gnu::always_inline]] void add(const Body& body, Sums& sums, int j, int n) {
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < 3; ++l) add_product(sums.n[k], body.axis[l].xyz[j], along[place[k][l]][n - j]);
      add_product(sums.products, body.axis[k].xyz[j], n_[k].yzx[n - j]);
    }
  }
  template <class Body>
  [[gnu::always_inline]] void finish(const Body& body, Sums& sums, int n, V& change) {
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < 3; ++l) {
        add_newest(
            [&](int j, int m) __attribute__((always_inline)) {
              add_product(sums.n[k], body.axis[l].xyz[j], along[place[k][l]][m - j]);
            },
            n);
      }
      n_[k].set(n, sums.n[k]);
      add_newest(
          [&](int j, int m)
              __attribute__((always_inline)) { add_product(sums.products, body.axis[k].xyz[j], n_[k].yzx[m - j]); },
          n);
    }
    add_product(change, yzx(sums.products), weights);
  }
  template <class W, int lower>
  struct Varied {
    VectorSeries<W, lower> axis[3];
  };
  template <class Series, class Variation, class W, int lower>
  [[gnu::always_inline]] void vary(const Series& series, const Variation& variation, Varied<W, lower>& varied, int n,
                                   W& change) const {
    PairChange<W> products;
    for (int k = 0; k < 3; ++k) {
      CrossProduct<W> turned;
      for (int j = 0; j <= n; ++j) turned.add(series.body.axis[k], variation.turn, j, n);
      varied.axis[k].set(n, turned.xyz());
      for (int j = 0; j <= n; ++j) products.add(n_[k], varied.axis[k], j, n);
    }
    add_product(change, products.xyz(), weights);
  }
  template <class Lower>
  [[gnu::always_inline]] void take(const Lower& lower, int n) {
    for (int k = 0; k < 3; ++k) n_[k].set(n, rounded(lower.n_[k].xyz[n]));
  }
};

/// A torque that keeps its components along the fixed axes.
template <class V, int orders>
struct Outside {
  Number<V> components[3] = {};
  V inverse_moments = {};
  VectorSeries<V, orders> torque;

  struct Sums {};
  template <class Body>
  [[gnu::always_inline]] void add(const Body& /*body*/, Sums& /*sums*/, int /*j*/, int /*n*/) {}
  template <class Body>
  [[gnu::always_inline]] void finish(const Body& body, Sums& /*sums*/, int n, V& change) {
    V sum = {};
    for (int k = 0; k < 3; ++k) add_product(sum, body.axis[k].xyz[n], components[k]);
    torque.set(n, sum);
    add_product(change, sum, inverse_moments);
  }
  template <class W, int lower>
  struct Varied {};
  template <class Series, class Variation, class Nothing, class W>
  [[gnu::always_inline]] void vary(const Series& /*series*/, const Variation& variation, Nothing& /*varied*/, int n,
                                   W& change) const {
    CrossProduct<W> turned;
    for (int j = 0; j <= n; ++j) turned.add(torque, variation.turn, j, n);
    add_product(change, turned.xyz(), inverse_moments);
  }
  template <class Lower>
  [[gnu::always_inline]] void take(const Lower& lower, int n) {
    torque.set(n, rounded(lower.torque.xyz[n]));
  }
};

template <class V, class W>
[[gnu::always_inline]] inline W transformed(const V (&columns)[3], const W& a) {
  W sum = {};
  add_product(sum, all_x(a), columns[0]);
  add_product(sum, all_x(yzx(a)), columns[1]);
  add_product(sum, all_x(yzx(yzx(a))), columns[2]);
  return sum;
}

/// Eddy currents: torque = B x (M C) with C = B x omega + (the field's own change).
template <class V, int orders>
struct Eddy {
  const Number<V>* field[3] = {};   ///< along the fixed axes
  const Number<V>* change[3] = {};  ///< its rate
  V columns[3] = {};                ///< of M
  V inverse_moments = {};
  VectorSeries<V, orders> B, D, induced;  // D: the field's own change, M C

  struct Sums {
    V B = {}, D = {};
    CrossProduct<V> C, torque;
  };
  template <class Body>
  [[gnu::always_inline]] void add(const Body& body, Sums& sums, int j, int n) {
    for (int k = 0; k < 3; ++k) {
      add_product(sums.B, body.axis[k].xyz[j], field[k][n - j]);
      add_product(sums.D, body.axis[k].xyz[j], change[k][n - j]);
    }
    sums.C.add(B, body.omega, j, n);
    sums.torque.add(B, induced, j, n);
  }
  template <class Body>
  [[gnu::always_inline]] void finish(const Body& body, Sums& sums, int n, V& out) {
    add_newest(
        [&](int j, int m) __attribute__((always_inline)) {
          for (int k = 0; k < 3; ++k) {
            add_product(sums.B, body.axis[k].xyz[j], field[k][m - j]);
            add_product(sums.D, body.axis[k].xyz[j], change[k][m - j]);
          }
        },
        n);
    B.set(n, sums.B);
    D.set(n, sums.D);
    add_newest(
        [&](int j, int m) __attribute__((always_inline)) { sums.C.add(B, body.omega, j, m); }, n);
    induced.set(n, transformed(columns, sums.C.xyz() + sums.D));
    add_newest(
        [&](int j, int m) __attribute__((always_inline)) { sums.torque.add(B, induced, j, m); }, n);
    add_product(out, sums.torque.xyz(), inverse_moments);
  }
  template <class W, int lower>
  struct Varied {
    VectorSeries<W, lower> B, induced;
  };
  template <class Series, class Variation, class W, int lower>
  [[gnu::always_inline]] void vary(const Series& series, const Variation& variation, Varied<W, lower>& varied, int n,
                                   W& out) const {
    CrossProduct<W> turned_B, turned_D, C, torque;
    for (int j = 0; j <= n; ++j) {
      turned_B.add(B, variation.turn, j, n);
      turned_D.add(D, variation.turn, j, n);
    }
    varied.B.set(n, turned_B.xyz());
    for (int j = 0; j <= n; ++j) {
      C.add(varied.B, series.body.omega, j, n);
      C.add(B, variation.omega, j, n);
    }
    varied.induced.set(n, transformed(columns, C.xyz() + turned_D.xyz()));
    for (int j = 0; j <= n; ++j) {
      torque.add(varied.B, induced, j, n);
      torque.add(B, varied.induced, j, n);
    }
    add_product(out, torque.xyz(), inverse_moments);
  }
  template <class Lower>
  [[gnu::always_inline]] void take(const Lower& lower, int n) {
    B.set(n, rounded(lower.B.xyz[n]));
    D.set(n, rounded(lower.D.xyz[n]));
    induced.set(n, rounded(lower.induced.xyz[n]));
  }
};

/// Internal dissipation: with l = m x omega, the axes turn with omega + k l, and m' = m x omega + k m x l.
template <class V, int orders>
struct Slip {
  V weights = {};  ///< of l from the pair products of omega: k (I2 - I3), ...
  V moments = {}, inverse_moments = {};
  VectorSeries<V, orders> m, kl, rate;  // k l; omega + k l

  struct Sums {
    CrossProduct<V> torque;
  };
  template <class Body>
  [[gnu::always_inline]] void add(const Body& /*body*/, Sums& sums, int j, int n) {
    sums.torque.add(m, kl, j, n);
  }
  /// Before the axes are turned.
  template <class Body>
  [[gnu::always_inline]] void slip(const Body& body, const V& products, int n) {
    V sum = {};
    add_product(sum, products, weights);
    kl.set(n, sum);
    rate.set(n, body.omega.xyz[n] + sum);
    V momentum = {};
    add_product(momentum, body.omega.xyz[n], moments);
    m.set(n, momentum);
  }
  template <class Body>
  [[gnu::always_inline]] void finish(const Body& /*body*/, Sums& sums, int n, V& change) {
    add_newest(
        [&](int j, int m_) __attribute__((always_inline)) { sums.torque.add(m, kl, j, m_); }, n);
    add_product(change, sums.torque.xyz(), inverse_moments);
  }
  template <class W, int lower>
  struct Varied {
    VectorSeries<W, lower> m, kl;
  };
  template <class Variation, class W, int lower>
  [[gnu::always_inline]] void slip_varied(const Variation& variation, Varied<W, lower>& varied, const W& products,
                                          int n) const {
    W kl_change = {}, m_change = {};
    add_product(kl_change, products, weights);
    add_product(m_change, variation.omega.xyz[n], moments);
    varied.kl.set(n, kl_change);
    varied.m.set(n, m_change);
  }
  template <class Series, class Variation, class W, int lower>
  [[gnu::always_inline]] void vary(const Series& /*series*/, const Variation& /*variation*/, Varied<W, lower>& varied,
                                   int n, W& change) const {
    CrossProduct<W> torque;
    for (int j = 0; j <= n; ++j) {
      torque.add(varied.m, kl, j, n);
      torque.add(m, varied.kl, j, n);
    }
    add_product(change, torque.xyz(), inverse_moments);
  }
  template <class Lower>
  [[gnu::always_inline]] void take(const Lower& lower, int n) {
    m.set(n, rounded(lower.m.xyz[n]));
    kl.set(n, rounded(lower.kl.xyz[n]));
    rate.set(n, rounded(lower.rate.xyz[n]));
  }
};

}  // namespace POLHODE_TARGET
}  // namespace polhode::taylor
