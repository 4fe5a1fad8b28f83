#pragma once

#include "rivals/state.hpp"

namespace polhode::rivals {

/// Runge-Kutta methods on the rotation group. Since the inertial momentum is constant, the momentum of a stage is the
/// one at the start of the step seen from the turned body; only turns are combined.
namespace lie {

template <class Real>
struct Vector {
  Real x, y, z;
};
template <class Real>
inline Vector<Real> operator+(const Vector<Real>& a, const Vector<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
inline Vector<Real> operator*(const Real& s, const Vector<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
inline Vector<Real> cross(const Vector<Real>& a, const Vector<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The quaternion of a turn by the rotation vector a.
template <class Real>
struct Turn {
  Real scalar;
  Vector<Real> v;

  explicit Turn(const Vector<Real>& a) {
    const Vector<Real> h = (Real(1) / Real(2)) * a;
    const Real square = h.x * h.x + h.y * h.y + h.z * h.z;
    if (square == Real(0)) {
      scalar = Real(1);
      v = h;
      return;
    }
    const Real angle = square_root(square);
    const auto [s, c] = sine_cosine(angle);
    scalar = c;
    v = (s / angle) * h;
  }

  void turn(Real m[3]) const { turn_momentum(m, scalar, v.x, v.y, v.z); }
  void turn(ScaledState<Real>& y) const {
    multiply_quaternion(y.q, scalar, v.x, v.y, v.z);
    turn(y.m);
  }
};

}  // namespace lie

/// Runge-Kutta-Munthe-Kaas, the classical tableau with two commutators. Munthe-Kaas, Appl. Numer. Math. 29, 115 (1999);
/// Iserles, Munthe-Kaas, Norsett & Zanna, Acta Numerica 9, 215 (2000), with the commutators' signs turned since our
/// turns multiply from the right. Order 4. Keeps |m| and the inertial momentum.
template <class Real>
class RungeKuttaMuntheKaas4 {
 public:
  static constexpr int order = 4;

  RungeKuttaMuntheKaas4(const InverseMoments<Real>& body, const ScaledState<Real>&, Real step) {
    for (int i = 0; i < 3; ++i) rate_[i] = body.x[i] * step;
  }

  void advance(ScaledState<Real>& y, std::int64_t steps) {
    using lie::cross;
    const Real half = Real(1) / Real(2), eighth = Real(1) / Real(8), sixth = Real(1) / Real(6);
    for (std::int64_t n = 0; n < steps; ++n) {
      const V k1 = rotation(y.m);
      const V k2 = stage(y, half * k1);
      const V k3 = stage(y, half * k2 + eighth * cross(k1, k2));
      const V k4 = stage(y, k3);
      lie::Turn<Real>(sixth * (k1 + k4 + Real(2) * (k2 + k3) + half * cross(k1, k4))).turn(y);
    }
    evaluations += 4 * steps;
  }

  std::int64_t evaluations = 0;

 private:
  using V = lie::Vector<Real>;
  V rotation(const Real m[3]) const { return {rate_[0] * m[0], rate_[1] * m[1], rate_[2] * m[2]}; }
  V stage(const ScaledState<Real>& y, const V& turn) const {
    Real m[3] = {y.m[0], y.m[1], y.m[2]};
    lie::Turn<Real>(turn).turn(m);
    return rotation(m);
  }
  Real rate_[3];
};

/// The commutator-free method of order 4. Celledoni, Marthinsen & Owren, Future Gener. Comput. Syst. 19, 341 (2003).
/// Keeps |m| and the inertial momentum.
template <class Real>
class CommutatorFree4 {
 public:
  static constexpr int order = 4;

  CommutatorFree4(const InverseMoments<Real>& body, const ScaledState<Real>&, Real step) {
    for (int i = 0; i < 3; ++i) rate_[i] = body.x[i] * step;
  }

  void advance(ScaledState<Real>& y, std::int64_t steps) {
    const Real half = Real(1) / Real(2), twelfth = Real(1) / Real(12);
    for (std::int64_t n = 0; n < steps; ++n) {
      const V k1 = rotation(y.m);
      Real m2[3] = {y.m[0], y.m[1], y.m[2]}, m3[3] = {y.m[0], y.m[1], y.m[2]};
      lie::Turn<Real>(half * k1).turn(m2);
      const V k2 = rotation(m2);
      lie::Turn<Real>(half * k2).turn(m3);
      const V k3 = rotation(m3);
      lie::Turn<Real>(k3 + (-half) * k1).turn(m2);  // from the second stage on
      const V k4 = rotation(m2);
      const V middle = Real(2) * (k2 + k3);
      lie::Turn<Real>(twelfth * (Real(3) * k1 + middle + Real(-1) * k4)).turn(y);
      lie::Turn<Real>(twelfth * (Real(-1) * k1 + middle + Real(3) * k4)).turn(y);
    }
    evaluations += 4 * steps;
  }

  std::int64_t evaluations = 0;

 private:
  using V = lie::Vector<Real>;
  V rotation(const Real m[3]) const { return {rate_[0] * m[0], rate_[1] * m[1], rate_[2] * m[2]}; }
  Real rate_[3];
};

}  // namespace polhode::rivals
