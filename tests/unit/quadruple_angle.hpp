#pragma once

// Angles between attitudes in quadruple precision: what shows the errors of the rivals and of their reference.

#include <cmath>

#include "rivals/reference.hpp"

namespace polhode::test {

inline double as_double(rivals::Quadruple a) { return static_cast<double>(a); }

template <class Real>
double angle_between(const Real a[4], const Real b[4]) {
  Real d[4] = {a[0], -a[1], -a[2], -a[3]};
  rivals::multiply_quaternion(d, b[0], b[1], b[2], b[3]);
  return 2.0 * std::hypot(as_double(d[1]), as_double(d[2]), as_double(d[3]));
}

}  // namespace polhode::test
