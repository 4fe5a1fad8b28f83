#include "polhode/motion/state_rates.hpp"

namespace polhode {

StateRates state_rates(const Vector3& principal_moments, const State& state) {
  const Vector3& i = principal_moments;
  StateRates k;
  k.omega_body_rad_s = state.momentum_body.cwiseQuotient(i);
  const Vector3& w = k.omega_body_rad_s;
  k.omega_rate_body_rad_s2 = {(i[1] - i[2]) / i[0] * w[1] * w[2], (i[2] - i[0]) / i[1] * w[2] * w[0],
                              (i[0] - i[1]) / i[2] * w[0] * w[1]};
  const Quaternion rate = state.q_inertial_from_body * Quaternion(0.0, w[0], w[1], w[2]);
  k.q_rate_scalar_first_s = 0.5 * scalar_first(rate);
  return k;
}

}  // namespace polhode
