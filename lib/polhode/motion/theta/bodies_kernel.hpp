#pragma once

// The answers of many bodies at one instant each, lanes are bodies: as FourierAt and attitude_and_momentum in
// kernel.hpp.

#include "polhode/motion/theta/bodies.hpp"
#include "polhode/motion/theta/kernel.hpp"
#include "polhode/motion/theta/lanes_double_double.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

[[gnu::always_inline]] inline void block_lanes_at(const BodyBlock& s, int first, Lanes t_high, Lanes t_low,
                                                  Lanes (&q)[4], Lanes (&m)[3]) {
  const auto lanes_of = [first](const double(&a)[kBlock]) { return load<Lanes>(a + first); };
  Lanes sin_v, cos_v, sine, cosine;
  sine_cosine(angle(lanes_of(s.v_quarters_per_s[0]), lanes_of(s.v_quarters_per_s[1]), t_high, t_low,
                    lanes_of(s.v_quarters_at_0), lanes_of(s.v_whole_quarters_at_0)),
              sin_v, cos_v);
  sine_cosine(
      angle(lanes_of(s.rho_quarters_per_s[0]), lanes_of(s.rho_quarters_per_s[1]), t_high, t_low, Lanes{}, Lanes{}),
      sine, cosine);
  const Lanes two_sin = sin_v + sin_v;
  const Lanes cos_2v = multiply_add(-two_sin, sin_v, all<Lanes>(1.0));
  Lanes p[4];
  for (int i = 0; i < 4; ++i) {
    p[i] = lanes_of(s.polynomial[kMaxDegree][i]);
    for (int n = kMaxDegree - 1; n >= 0; --n) p[i] = multiply_add(p[i], cos_2v, lanes_of(s.polynomial[n][i]));
  }
  const Lanes re_alpha = p[0], re_beta = sin_v * p[1], im_alpha = two_sin * cos_v * p[2], im_beta = cos_v * p[3];

  const Lanes alpha2 = multiply_add(re_alpha, re_alpha, im_alpha * im_alpha);
  const Lanes beta2 = multiply_add(re_beta, re_beta, im_beta * im_beta);
  const Lanes reciprocal = 1.0 / (alpha2 + beta2);
  const Lanes scale = square_root(reciprocal);
  const Lanes twice = 2.0 * reciprocal;
  const LaneBits longs = lanes_of(s.long_axis_mode) < 0.0;
  const Lanes m1 = multiply_add(im_alpha, re_beta, -re_alpha * im_beta) * twice * lanes_of(s.momentum_scale[0]);
  const Lanes m3 = (alpha2 - beta2) * reciprocal * lanes_of(s.momentum_scale[2]);
  m[0] = where(longs, m3, m1);
  m[1] = multiply_add(re_alpha, re_beta, im_alpha * im_beta) * twice * lanes_of(s.momentum_scale[1]);
  m[2] = where(longs, m1, m3);
  const Lanes e0 = multiply_add(re_alpha, cosine, -im_alpha * sine);
  const Lanes e1 = multiply_add(re_beta, cosine, -im_beta * sine) * lanes_of(s.sign[0]);
  const Lanes x2 = multiply_add(re_beta, sine, im_beta * cosine) * lanes_of(s.sign[1]);
  const Lanes e3 = multiply_add(re_alpha, sine, im_alpha * cosine) * lanes_of(s.sign[2]);
  const Lanes x1 = where(longs, e3, e1), x3 = where(longs, e1, e3);
  const Lanes f0 = lanes_of(s.frame[0]), f1 = lanes_of(s.frame[1]), f2 = lanes_of(s.frame[2]),
              f3 = lanes_of(s.frame[3]);
  q[0] = multiply_add(-f3, x3, multiply_add(-f2, x2, multiply_add(-f1, x1, f0 * e0))) * scale;
  q[1] = multiply_add(-f3, x2, multiply_add(f2, x3, multiply_add(f1, e0, f0 * x1))) * scale;
  q[2] = multiply_add(f3, x1, multiply_add(f2, e0, multiply_add(-f1, x3, f0 * x2))) * scale;
  q[3] = multiply_add(f3, e0, multiply_add(-f2, x1, multiply_add(f1, x2, f0 * x3))) * scale;
}

/// A whole block. `low` of the times may overlap `high`.
inline void block_at(const BodyBlock& s, const BlockTimes& times, BlockStates& states) {
  for (int first = 0; first < kBlock; first += kLanes) {
    const Pair<Lanes> t = pair_sum(load<Lanes>(times.high + first), load<Lanes>(times.low + first));
    Lanes q[4], m[3];
    block_lanes_at(s, first, t.high, t.low, q, m);
    for (int k = 0; k < 4; ++k) store(states.q[k] + first, q[k]);
    for (int k = 0; k < 3; ++k) store(states.m[k] + first, m[k]);
  }
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
