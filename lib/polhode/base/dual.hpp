#pragma once

#include <Eigen/Core>
#include <cmath>

#include "polhode/base/double_double.hpp"

namespace polhode {
inline namespace POLHODE_TARGET {

/// A number with its partial derivatives by N others: what is computed with it is differentiated exactly.
template <int N>
struct Dual {
  using Partials = Eigen::Matrix<double, N, 1>;

  double value = 0.0;
  Partials partials = Partials::Zero();

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): exact, as for numbers
  Dual(double v, const Partials& p) : value(v), partials(p) {}
  static Dual variable(double v, int number) { return {v, Partials::Unit(number)}; }

  Dual operator-() const { return {-value, -partials}; }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.partials + b.partials}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.partials - b.partials}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.partials + b.value * a.partials};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double quotient = a.value / b.value;
    return {quotient, (a.partials - quotient * b.partials) / b.value};
  }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
};

template <int N>
Dual<N> sqrt(const Dual<N>& a) {
  const double root = std::sqrt(a.value);
  return {root, a.partials / (2.0 * root)};
}
template <int N>
Dual<N> exp(const Dual<N>& a) {
  const double power = std::exp(a.value);
  return {power, power * a.partials};
}
template <int N>
Dual<N> sin(const Dual<N>& a) {
  return {std::sin(a.value), std::cos(a.value) * a.partials};
}
template <int N>
Dual<N> cos(const Dual<N>& a) {
  return {std::cos(a.value), -std::sin(a.value) * a.partials};
}
template <int N>
Dual<N> abs(const Dual<N>& a) {
  return a.value < 0.0 ? -a : a;
}
template <int N>
Dual<N> hypot(const Dual<N>& a, const Dual<N>& b) {
  const double length = std::hypot(a.value, b.value);
  return {length, (a.value * a.partials + b.value * b.partials) / length};
}
template <int N>
Dual<N> pow(const Dual<N>& a, int exponent) {
  if (exponent == 0) return 1.0;
  const double below = std::pow(a.value, exponent - 1);
  return {below * a.value, exponent * below * a.partials};
}

template <int N>
struct RealTraits<Dual<N>> {
  /// Of the derivatives, which converge behind the value: one more step.
  static constexpr double epsilon = 0x1p-80;
  static double high(const Dual<N>& a) { return a.value; }
  static double pi() { return RealTraits<double>::pi(); }
};
}  // namespace POLHODE_TARGET

}  // namespace polhode
