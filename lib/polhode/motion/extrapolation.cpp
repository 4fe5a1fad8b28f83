#include "polhode/motion/extrapolation.hpp"

#include <array>
#include <cmath>
#include <optional>

namespace polhode {
namespace {

// Bulirsch's numbers of substeps: the weights of the last column add up to 9 in absolute value, those of 2, 4, 6, … to
// 119, and with them the rounding.
constexpr int kSubsteps[] = {2, 4, 6, 8, 12, 16, 24, 32};
constexpr int kColumns = 8;
constexpr int kParts = 96;  // of a step, of which all substeps are multiples

}  // namespace

template <class Real>
typename Extrapolation<Real>::Values Extrapolation<Real>::rate(const Torques::Surroundings<Real>& surroundings,
                                                               const Values& y) {
  ++evaluations_;
  const Eigen::Quaternion<Real> q(y[0], y[1], y[2], y[3]);
  const Vector3Of<Real> m = y.template tail<3>();
  const Vector3Of<Real> omega = m.cwiseQuotient(moments_);
  // q leaves unit length by rounding and by the error of a substep; the torque must not feel that.
  const TorqueTerms<Real> terms =
      torques_.at(surroundings, Matrix3Of<Real>(q.normalized().toRotationMatrix()), moments_);
  const Vector3Of<Real> turning = m.cross(omega);
  const Vector3Of<Real> turn = omega + terms.relaxation * turning;
  const Eigen::Quaternion<Real> dq = q * Eigen::Quaternion<Real>(0, turn[0], turn[1], turn[2]);
  Values result;
  result << dq.w() / 2, dq.x() / 2, dq.y() / 2, dq.z() / 2,
      turning + terms.torque(omega) + terms.relaxation * m.cross(turning);
  return result;
}

template <class Real>
typename Extrapolation<Real>::Step Extrapolation<Real>::step(long double t_s, const ExtendedState& state,
                                                             long double length_s) {
  const Eigen::Quaternion<Real> q = state.q_inertial_from_body.cast<Real>();
  Values start;
  start << q.w(), q.x(), q.y(), q.z(), state.momentum_body.cast<Real>();
  // Substeps of different length meet: each place is found once.
  std::array<std::optional<Torques::Surroundings<Real>>, kParts + 1> known;
  const auto surroundings = [&](int part) -> const Torques::Surroundings<Real>& {
    std::optional<Torques::Surroundings<Real>>& one = known[static_cast<std::size_t>(part)];
    if (!one) one = torques_.surroundings(static_cast<Real>(t_s + length_s * part / kParts));
    return *one;
  };
  const Values start_rate = rate(surroundings(0), start);

  // Increments are extrapolated, not states: they carry less rounding.
  Values row[kColumns];
  Values previous_best = Values::Zero();
  for (int k = 0; k < kColumns; ++k) {
    const int substeps = kSubsteps[k];
    const Real h = static_cast<Real>(length_s) / substeps;
    Values before = Values::Zero(), now = h * start_rate;
    for (int i = 1; i < substeps; ++i) {
      const Values next = before + 2 * h * rate(surroundings(i * (kParts / substeps)), start + now);
      before = now;
      now = next;
    }
    if (k > 0) previous_best = row[k - 1];
    for (int j = 1; j <= k; ++j) {  // Aitken and Neville; row[j - 1] still belongs to the step number before
      const Real ratio = static_cast<Real>(substeps) / kSubsteps[k - j];
      const Values better = now + (now - row[j - 1]) / (ratio * ratio - 1);
      row[j - 1] = now;
      now = better;
    }
    row[k] = now;
  }
  const Values difference = row[kColumns - 1] - previous_best;
  const Values end = start + row[kColumns - 1];
  Step result;
  result.state.q_inertial_from_body = Eigen::Quaternion<long double>(end[0], end[1], end[2], end[3]).normalized();
  result.state.momentum_body = end.template tail<3>().template cast<long double>();
  const Real scale = end.template tail<3>().norm() + start.template tail<3>().norm();
  const Real momentum_error = difference.template tail<3>().norm();
  result.error = static_cast<double>(2 * difference.template head<4>().norm() +
                                     (scale > 0 ? 2 * momentum_error / scale : momentum_error));
  return result;
}

template class Extrapolation<double>;
template class Extrapolation<long double>;

}  // namespace polhode
