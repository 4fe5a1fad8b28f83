#include "polhode/body/euler.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

Quaternion turn(int axis, double angle_rad) {
  Quaternion q(std::cos(0.5 * angle_rad), 0.0, 0.0, 0.0);
  q.vec()[axis] = std::sin(0.5 * angle_rad);
  return q;
}

void check_angles(const Vector3& angles_rad) {
  if (!angles_rad.allFinite()) {
    throw InputError(fmt::format("the Euler angles are {}, {}, {} rad; finite ones are wanted", angles_rad[0],
                                 angles_rad[1], angles_rad[2]));
  }
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

}  // namespace

EulerSequence::EulerSequence(std::string_view name) : axes_{} {
  bool good = name.size() == 3;
  for (std::size_t i = 0; i < 3 && good; ++i) {
    const auto at = std::string_view("xyzXYZ123").find(name[i]);
    good = at != std::string_view::npos;
    axes_[i] = static_cast<int>(at % 3);
    if (i > 0) good = good && axes_[i] != axes_[i - 1];
  }
  if (!good) {
    throw InputError(fmt::format(
        "'{:.60}' is not an Euler sequence; allowed: three of X, Y, Z (or 1, 2, 3), no two neighbours alike, as in ZXZ",
        name));
  }
}

std::string EulerSequence::name() const {
  std::string text;
  for (const int axis : axes_) text += "XYZ"[axis];
  return text;
}

Quaternion q_frame_from_body(const EulerSequence& sequence, const Vector3& angles_rad) {
  check_angles(angles_rad);
  const auto& axes = sequence.axes();
  return (turn(axes[0], angles_rad[0]) * turn(axes[1], angles_rad[1]) * turn(axes[2], angles_rad[2])).normalized();
}

// With half angles a, b, c and axes i, j, i (k the third, sign = +1 if i, j, k is right-handed), q is
//   (cos b cos(a + c), cos b sin(a + c), sin b cos(a - c), sign sin b sin(a - c))  along  (1, i, j, k),
// so that sums and differences of the outer angles come from atan2 without loss (Bernardes & Viollet 2022, PLoS ONE 17,
// e0276302). A sequence i, j, k is i, j, i after a turn of the body by 90 deg about j and a change of the last axis'
// name.
Vector3 euler_angles_rad(const EulerSequence& sequence, const Quaternion& q) {
  if (!(q.coeffs().allFinite() && !q.coeffs().isZero(0.0))) {
    throw InputError(fmt::format("the quaternion {}, {}, {}, {} is no attitude", q.w(), q.x(), q.y(), q.z()));
  }
  const auto [i, j, last] = sequence.axes();
  const int k = 3 - i - j;
  const double sign = (j - i + 3) % 3 == 1 ? 1.0 : -1.0;
  const double qi = q.vec()[i], qj = q.vec()[j], qk = sign * q.vec()[k];
  double c0 = q.w(), ci = qi, cj = qj, ck = qk;
  if (!sequence.proper()) {  // q turned by +90 deg about j from the right, times sqrt(2)
    c0 = q.w() - qj;
    ci = qi - qk;
    cj = q.w() + qj;
    ck = qi + qk;
  }
  const double cosine = std::hypot(c0, ci), sine = std::hypot(cj, ck);
  const double second = 2.0 * std::atan2(sine, cosine);
  const double half_sum = std::atan2(ci, c0), half_difference = std::atan2(ck, cj);
  double first = 0.0, third = 0.0;
  if (sine == 0.0) {
    first = 2.0 * half_sum;
  } else if (cosine == 0.0) {
    first = 2.0 * half_difference;
  } else {
    first = half_sum + half_difference;
    third = half_sum - half_difference;
  }
  if (sequence.proper()) return {wrapped(first), second, wrapped(third)};
  return {wrapped(first), second - 0.5 * std::numbers::pi, wrapped(-sign * third)};
}

Vector3 omega_body_rad_s(const EulerSequence& sequence, const Vector3& angles_rad, const Vector3& rates_rad_s) {
  check_angles(angles_rad);
  if (!rates_rad_s.allFinite()) throw InputError("the rates of the Euler angles are not finite");
  const auto& axes = sequence.axes();
  const Quaternion third = turn(axes[2], angles_rad[2]);
  const Quaternion second = turn(axes[1], angles_rad[1]) * third;
  return rates_rad_s[0] * (second.conjugate() * Vector3::Unit(axes[0])) +
         rates_rad_s[1] * (third.conjugate() * Vector3::Unit(axes[1])) + rates_rad_s[2] * Vector3::Unit(axes[2]);
}

Vector3 euler_rates_rad_s(const EulerSequence& sequence, const Vector3& angles_rad, const Vector3& omega_body) {
  Matrix3 omega_of_rates;  // omega is linear in the rates
  for (int k = 0; k < 3; ++k) omega_of_rates.col(k) = omega_body_rad_s(sequence, angles_rad, Vector3::Unit(k));
  return omega_of_rates.inverse() * omega_body;
}

}  // namespace polhode
