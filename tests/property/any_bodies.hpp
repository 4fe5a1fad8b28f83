#pragma once

// Bodies of all kinds, and errors of their motions.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "polhode/motion/free_body.hpp"
#include "polhode/motion/motion.hpp"

namespace polhode::test {

inline constexpr double kEps = std::numeric_limits<double>::epsilon();

/// Bodies of all kinds, generic first, then those beside a border; seed fixed.
class Bodies {
 public:
  FreeBody next() {
    const int kind = count_++ % 8;
    Vector3 i(uniform(1, 10), uniform(1, 10), uniform(1, 10));
    std::sort(i.data(), i.data() + 3);
    Vector3 m(normal(), normal(), normal());
    const double small = std::pow(10.0, uniform(-15, -1));
    switch (kind) {
      case 1:
        i[0] = i[1] * small;
        break;  // needle
      case 2:
        i[1] = std::min(i[0] * (1 + small), i[2]);
        break;  // nearly symmetric
      case 3:
        i[1] = std::max(i[2] * (1 - small), i[0]);
        break;
      case 4:
        i[1] = i[0] * (1 + small), i[2] = i[1] * (1 + small);
        break;  // nearly a sphere
      case 5:
        m[0] *= small, m[1] *= small;
        break;  // beside an axis
      case 6:
        m[0] *= small, m[2] *= small;
        break;
      case 7:
        m[2] = m[0] * std::sqrt((i[1] - i[0]) * i[2] / (i[0] * (i[2] - i[1]))) * (1 + small);
        break;  // separatrix
      default:
        break;
    }
    return {i, Quaternion(normal(), normal(), normal(), normal()), m};
  }
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }
  double normal() { return std::normal_distribution<double>()(random_); }

 private:
  std::mt19937_64 random_{20260101};
  int count_ = 0;
};

inline double fastest(const FreeBody& b) { return b.momentum_body.cwiseQuotient(b.principal_moments).stableNorm(); }

/// Squares may underflow; a momentum of 0 stays so to the last digit.
inline double momentum_error(const Vector3& a, const Vector3& b) {
  const double off = (a - b).stableNorm();
  return off == 0.0 ? 0.0 : off / b.stableNorm();
}
inline double momentum_error(const State& a, const State& b) {
  return momentum_error(a.momentum_body, b.momentum_body);
}

}  // namespace polhode::test
