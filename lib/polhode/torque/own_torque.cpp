#include "polhode/torque/own_torque.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"

namespace polhode {

OwnTorque::OwnTorque(std::shared_ptr<const TorqueFunction> function, std::optional<Trajectory> way)
    : trajectory(std::move(way)), function_(std::move(function)) {
  if (!function_) throw InputError("a torque of one's own without a function");
}

OwnTorque OwnTorque::turned(const Matrix3& to_from) const {
  OwnTorque other = *this;
  other.own_from_body_ = own_from_body_ * to_from.transpose();
  return other;
}

Vector3 OwnTorque::torque(double t_s, const Matrix3& inertial_from_body, const Vector3& omega_rad_s,
                          const Vector3& moments, const OrbitState<double>* orbit) const {
  const Matrix3 inertial_from_own = inertial_from_body * own_from_body_.transpose();
  const TorqueQuestion question{t_s, Quaternion(inertial_from_own), own_from_body_ * omega_rad_s,
                                own_from_body_ * moments.cwiseProduct(omega_rad_s), orbit};
  const Vector3 answer = function_->torque(question);
  if (!answer.allFinite()) {
    throw InputError(fmt::format("the function of a torque gave ({}, {}, {}) at {} s; finite numbers are wanted",
                                 answer[0], answer[1], answer[2], t_s));
  }
  return own_from_body_.transpose() * answer;
}

}  // namespace polhode
