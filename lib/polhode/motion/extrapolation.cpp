#include "polhode/motion/extrapolation.hpp"

#include <cmath>

namespace polhode {
namespace {

// Bulirsch's numbers of substeps: the weights of the last column add up to 9 in absolute value, those of 2, 4, 6, … to
// 119, and with them the rounding.
constexpr int kSubsteps[] = {2, 4, 6, 8, 12, 16, 24, 32};
constexpr int kColumns = 8;

}  // namespace

Extrapolation::Values Extrapolation::rate(long double t_s, const Values& y) {
  ++evaluations_;
  const Eigen::Quaternion<long double> q(y[0], y[1], y[2], y[3]);
  const Vector3Of<long double> m = y.tail<3>();
  const Vector3Of<long double> omega = m.cwiseQuotient(moments_);
  // q leaves unit length by rounding and by the error of a substep; the torque must not feel that.
  const TorqueTerms<long double> terms = torques_.at(t_s, q.normalized(), moments_);
  const Vector3Of<long double> turning = m.cross(omega);
  const Vector3Of<long double> turn = omega + terms.relaxation * turning;
  const Eigen::Quaternion<long double> dq = q * Eigen::Quaternion<long double>(0.0L, turn[0], turn[1], turn[2]);
  Values result;
  result << dq.w() / 2, dq.x() / 2, dq.y() / 2, dq.z() / 2,
      turning + terms.torque(omega) + terms.relaxation * m.cross(turning);
  return result;
}

Extrapolation::Step Extrapolation::step(long double t_s, const ExtendedState& state, long double length_s) {
  const auto& q = state.q_inertial_from_body;
  Values start;
  start << q.w(), q.x(), q.y(), q.z(), state.momentum_body;
  const Values start_rate = rate(t_s, start);

  // Increments are extrapolated, not states: they carry less rounding.
  Values row[kColumns];
  Values previous_best = Values::Zero();
  for (int k = 0; k < kColumns; ++k) {
    const int substeps = kSubsteps[k];
    const long double h = length_s / substeps;
    Values before = Values::Zero(), now = h * start_rate;
    for (int i = 1; i < substeps; ++i) {
      const Values next = before + 2 * h * rate(t_s + i * h, start + now);
      before = now;
      now = next;
    }
    if (k > 0) previous_best = row[k - 1];
    for (int j = 1; j <= k; ++j) {  // Aitken and Neville; row[j - 1] still belongs to the step number before
      const long double ratio = static_cast<long double>(substeps) / kSubsteps[k - j];
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
  result.state.momentum_body = end.tail<3>();
  const long double scale = end.tail<3>().norm() + start.tail<3>().norm();
  const long double momentum_error = difference.tail<3>().norm();
  result.error =
      static_cast<double>(2 * difference.head<4>().norm() + (scale > 0 ? 2 * momentum_error / scale : momentum_error));
  return result;
}

}  // namespace polhode
