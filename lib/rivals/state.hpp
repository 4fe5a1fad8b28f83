#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace polhode::rivals {

/// Quadruple precision where the compiler has it: the reference answers and the measured orders of high-order methods
/// need more digits than a double. A long double elsewhere (quadruple on AArch64).
#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 Quadruple;
inline constexpr double quadruple_epsilon = 0x1p-112;
#else
using Quadruple = long double;
inline constexpr double quadruple_epsilon = static_cast<double>(__LDBL_EPSILON__);
#endif

/// What every integrator advances: attitude (body to inertial, scalar first) and angular momentum in the principal
/// axes. The driver (integrated_motion.hpp) scales momentum and time so that |m| = 1 and I2 = 1.
template <class Real>
struct ScaledState {
  Real q[4];
  Real m[3];
};

/// 1 / principal moments.
template <class Real>
struct InverseMoments {
  Real x[3];
};

inline double square_root(double a) { return std::sqrt(a); }
inline Quadruple square_root(Quadruple a) {
  if (!(a > Quadruple(0))) return a == Quadruple(0) ? a : Quadruple(std::nan(""));
  Quadruple r = Quadruple(std::sqrt(static_cast<double>(a)));
  for (int i = 0; i < 3; ++i) r = (r + a / r) / Quadruple(2);  // 53, 106, 113 bits
  return r;
}

template <class Real>
struct SineCosine {
  Real sine, cosine;
};

/// Sine and cosine. Steps turn by less than half a radian, where two short polynomials (Taylor's; remainder below
/// 2^-54 relative) are several times faster than the library's general functions and can be inlined.
inline SineCosine<double> sine_cosine(double a) {
  if (!(std::abs(a) < 0.5)) return {std::sin(a), std::cos(a)};
  const double z = a * a;
  const double s =
      -1.0 / 6 + z * (1.0 / 120 + z * (-1.0 / 5040 + z * (1.0 / 362880 + z * (-1.0 / 39916800 + z / 6227020800.0))));
  const double c =
      1.0 / 24 +
      z * (-1.0 / 720 + z * (1.0 / 40320 + z * (-1.0 / 3628800 + z * (1.0 / 479001600 - z / 87178291200.0))));
  return {a + a * z * s, 1.0 - 0.5 * z + z * z * c};
}

/// The same for |a| below about 1e9: reduced by 2 pi, halved four times, Taylor series, doubled back.
inline SineCosine<Quadruple> sine_cosine(Quadruple a) {
  // pi in three doubles (OEIS A000796).
  const Quadruple two_pi = Quadruple(2) * (Quadruple(3.141592653589793116) + Quadruple(1.2246467991473532e-16) -
                                           Quadruple(2.9947698097183397e-33));
  a -= two_pi * Quadruple(std::nearbyint(static_cast<double>(a / two_pi)));
  const Quadruple b = a / Quadruple(16);
  const Quadruple z = b * b;
  Quadruple s = 0, v = 0;  // v = 1 - cosine keeps the small part through the doublings
  for (int n = 14; n >= 1; --n) {
    s = -(Quadruple(1) + s) * z / Quadruple((2 * n) * (2 * n + 1));
    v = Quadruple(1) / Quadruple((2 * n - 1) * (2 * n)) * (Quadruple(1) - v * z);
  }
  v *= z;
  s = b + b * s;
  for (int i = 0; i < 4; ++i) {
    const Quadruple c = Quadruple(1) - v;
    v = Quadruple(2) * s * s;
    s = Quadruple(2) * s * c;
  }
  return {s, Quadruple(1) - v};
}

/// q (cosine, sine * axis K): the attitude after a turn about body axis K, 0 to 2, by twice the angle.
template <int K, class Real>
inline void turn_about_axis(ScaledState<Real>& y, Real half_angle) {
  constexpr int i = (K + 1) % 3, j = (K + 2) % 3;
  const auto [s, c] = sine_cosine(half_angle);
  const Real q0 = y.q[0], qk = y.q[K + 1], qi = y.q[i + 1], qj = y.q[j + 1];
  y.q[0] = c * q0 - s * qk;
  y.q[K + 1] = c * qk + s * q0;
  y.q[i + 1] = c * qi + s * qj;
  y.q[j + 1] = c * qj - s * qi;
  const Real s2 = Real(2) * s * c, c2 = Real(1) - Real(2) * s * s;
  const Real mi = y.m[i], mj = y.m[j];
  y.m[i] = c2 * mi + s2 * mj;
  y.m[j] = c2 * mj - s2 * mi;
}

/// q becomes q (scalar, v).
template <class Real>
inline void multiply_quaternion(Real q[4], Real scalar, Real vx, Real vy, Real vz) {
  const Real q0 = q[0], q1 = q[1], q2 = q[2], q3 = q[3];
  q[0] = q0 * scalar - (q1 * vx + q2 * vy + q3 * vz);
  q[1] = q1 * scalar + (q0 * vx + q2 * vz - q3 * vy);
  q[2] = q2 * scalar + (q0 * vy + q3 * vx - q1 * vz);
  q[3] = q3 * scalar + (q0 * vz + q1 * vy - q2 * vx);
}

/// The momentum that a body turned by the quaternion (scalar, v), of length 1, sees: m becomes conj(p) m p.
template <class Real>
inline void turn_momentum(Real m[3], Real scalar, Real vx, Real vy, Real vz) {
  const Real two(2);
  const Real tx = two * (m[1] * vz - m[2] * vy);  // 2 m x v
  const Real ty = two * (m[2] * vx - m[0] * vz);
  const Real tz = two * (m[0] * vy - m[1] * vx);
  m[0] += scalar * tx + (ty * vz - tz * vy);
  m[1] += scalar * ty + (tz * vx - tx * vz);
  m[2] += scalar * tz + (tx * vy - ty * vx);
}

/// Turns the body by the Cayley transform of g: the quaternion (1, g), made unit.
template <class Real>
inline void turn_by_cayley(ScaledState<Real>& y, const Real g[3]) {
  const Real c = Real(1) / square_root(Real(1) + g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  multiply_quaternion(y.q, c, c * g[0], c * g[1], c * g[2]);
  turn_momentum(y.m, c, c * g[0], c * g[1], c * g[2]);
}

template <class Real>
inline bool is_finite(const ScaledState<Real>& y) {
  double sum = 0.0;
  for (const Real& a : y.q) sum += static_cast<double>(a);
  for (const Real& a : y.m) sum += static_cast<double>(a);
  return std::isfinite(sum);
}

/// From instant `from` on, a method has no answer.
inline void no_answer(ScaledState<double>* out, std::size_t from, std::size_t count) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = from; i < count; ++i) out[i] = {{nan, nan, nan, nan}, {nan, nan, nan}};
}

}  // namespace polhode::rivals
