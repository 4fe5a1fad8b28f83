#pragma once

// The torques that have series. Each kind is a class template over the vectors V and the number of orders:
//
//     Sums                          what it sums up for one coefficient
//     add(body, sums, j, n)         the terms of coefficients j and n - j, 0 < j < n
//     finish(body, sums, n, change) the terms with the newest coefficients, and its coefficient n over the moments of
//                                   inertia to `change`
//     vary(variation, varied, n, change)  the coefficient n of what a small change of the state makes of it; Varied<n>
//                                   are the series that this needs
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
    V weights = {};          ///< (I3 - I2)/I1, ...
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
        add_newest([&](int j, int m) __attribute__((always_inline)) { add_product(sums.p[k], body.axis[k].xyz[j], along[k][m - j]); }, n);
        if (k > 0) sums.p[0] = sums.p[0] + sums.p[k];
      }
      p.set(n, sums.p[0]);
      add_newest([&](int j, int m) __attribute__((always_inline)) { sums.products.add(p, j, m); }, n);
      add_product(change, sums.products.xyz(), weights);
    }
    template <int lower>
    using Varied = VectorSeries<Vector, lower>;  // the change of p
    template <class Variation, int lower>
    [[gnu::always_inline]] void vary(const Variation& variation, VectorSeries<Vector, lower>& p_change, int n,
                                     Vector& change) const {
      CrossProduct<Vector> turned;
      for (int j = 0; j <= n; ++j) turned.add(p, variation.turn, j, n);
      p_change.set(n, turned.xyz());
      PairChange<Vector> products;
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
  template <int lower>
  struct Varied {};
  template <class Variation, class Nothing>
  [[gnu::always_inline]] void vary(const Variation& variation, Nothing& /*varied*/, int n, Vector& change) const {
    add_product(change, all_x(variation.omega.xyz[n]), columns[0]);
    add_product(change, all_x(variation.omega.yzx[n]), columns[1]);
    add_product(change, all_x(yzx(variation.omega.yzx[n])), columns[2]);
  }
  template <class Lower>
  [[gnu::always_inline]] void take(const Lower& /*lower*/, int /*n*/) {}
};

}  // namespace POLHODE_TARGET
}  // namespace polhode::taylor
