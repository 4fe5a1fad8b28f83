#include "polhode/read/ccsds_kinematics.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "polhode/base/units.hpp"
#include "polhode/body/spinner.hpp"
#include "polhode/read/ccsds_fields.hpp"
#include "polhode/read/ccsds_frames.hpp"

namespace polhode {
namespace {

Vector3 in_radians(std::span<const double> degrees) { return degree * Vector3(degrees[0], degrees[1], degrees[2]); }

/// Half a unit of the last decimal that any of the numbers has, as printed.
double rounding_of(std::span<const double> numbers) {
  constexpr double finest = 1e-17, nearly = 1e-3;
  double unit = 1.0;
  for (const double number : numbers) {
    while (unit > finest && std::abs(std::remainder(number, unit)) > nearly * unit) unit /= 10.0;
  }
  return 0.5 * unit;
}

/// From q' = q omega / 2 in the vector part; the scalar part is that of q' along q, which only rounding has.
Quaternion half_rate(const Quaternion& q, std::span<const double> derivative) {
  return q.conjugate() * Quaternion(derivative[3], derivative[0], derivative[1], derivative[2]);
}

/// What rounding leaves of the derivative of a quaternion along the quaternion.
double rounding_along(const Quaternion& half_rate, std::span<const double> derivative) {
  return ccsds_norm_tolerance * half_rate.norm() + 2.0 * rounding_of(derivative);  // |q1| + ... + |qc| <= 2
}

/// X_B = M X_A.
Quaternion from_columns(std::span<const double> n, const SourceLocation& where) {
  Matrix3 m;
  for (Eigen::Index i = 0; i < 9; ++i) m(i % 3, i / 3) = n[static_cast<std::size_t>(i)];
  const double fault = (m * m.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff();
  if (!(fault <= 2.0 * ccsds_norm_tolerance) || !(m.determinant() > 0.0)) {
    throw InputError(where,
                     fmt::format("the matrix is no rotation (determinant {:.4g}, columns not orthonormal by {:.2g})",
                                 m.determinant(), fault));
  }
  return Quaternion(Matrix3(m.transpose())).normalized();
}

}  // namespace

std::size_t CcsdsKinematics::attitude_numbers() const {
  return attitude == Attitude::matrix ? 9 : attitude == Attitude::euler_angles ? 3 : 4;
}

std::size_t CcsdsKinematics::rate_numbers() const { return rate == Rate::none ? 0 : rate == Rate::quaternion ? 4 : 3; }

StatedAttitude CcsdsKinematics::stated(std::span<const double> numbers, std::string_view block,
                                       const SourceLocation& where) const {
  const std::span<const double> n = numbers, of_rate = numbers.subspan(attitude_numbers());
  switch (attitude) {
    case Attitude::quaternion:
      return stated(ccsds_quaternion({n[0], n[1], n[2], n[3]}, where), of_rate, block, where);
    case Attitude::matrix:
      return stated(from_columns(n, where), of_rate, block, where);
    case Attitude::euler_angles: {
      const Quaternion q = q_frame_from_body(*axes, in_radians(n));
      if (rate != Rate::euler_angles) return stated(q, of_rate, block, where);
      return stated(q, omega_body_rad_s(*axes, in_radians(n), in_radians(of_rate)), block, where);
    }
    case Attitude::spin:
      break;
  }
  Spinner spinner{n[0], n[1], n[2], n[3], {}};
  if (rate == Rate::nutation) spinner.turns = Spinner::Nutation{of_rate[0], of_rate[1], of_rate[2]};
  if (rate == Rate::nutation && of_rate[1] == 0.0) throw InputError(where, "NUTATION_PER is 0");
  if (rate == Rate::momentum) spinner.turns = Spinner::Momentum{of_rate[0], of_rate[1], of_rate[2]};
  const auto [q, omega] = attitude_and_rate(spinner);
  return stated(q, std::optional(omega), block, where);
}

StatedAttitude CcsdsKinematics::stated(const Quaternion& q, std::span<const double> rate_numbers,
                                       std::string_view block, const SourceLocation& where) const {
  std::optional<Vector3> omega;
  if (rate == Rate::quaternion) {
    const Quaternion half = half_rate(q, rate_numbers);
    const double most = rounding_along(half, rate_numbers);
    if (tell && !(std::abs(half.w()) <= most)) {
      tell(fmt::format(
          "line {}: the derivative of the quaternion has a part of {:.3g} 1/s along the quaternion, which is "
          "no rotation (rounding explains {:.2g} 1/s); the rest is taken as the rate",
          where.line, half.w(), most));
    }
    omega = 2.0 * half.vec();
  }
  if (rate == Rate::euler_angles) omega = omega_body_rad_s(*axes, euler_angles_rad(*axes, q), in_radians(rate_numbers));
  if (rate == Rate::angular_velocity_in_end) omega = in_radians(rate_numbers);
  if (rate == Rate::angular_velocity_in_start) omega = q.conjugate() * in_radians(rate_numbers);
  return stated(q, omega, block, where);
}

StatedAttitude CcsdsKinematics::stated(const Quaternion& q, const std::optional<Vector3>& omega, std::string_view block,
                                       const SourceLocation& where) const {
  if (omega && !omega->allFinite()) throw InputError(where, "the rates give no finite angular velocity");
  const bool reversed = is_local_frame(start) && !is_local_frame(end);
  StatedAttitude s;
  s.block = block;
  s.frame = reversed ? end : start;
  s.body = reversed ? start : end;
  s.known_frame = known_inertial_frame(s.frame);
  s.q_frame_from_body = reversed ? q.conjugate() : q;
  if (omega) s.omega_body_rad_s = reversed ? Vector3(-(q * *omega)) : *omega;
  return s;
}

}  // namespace polhode
