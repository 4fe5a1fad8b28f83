#include "polhode/body/spinner.hpp"

#include <cmath>
#include <numbers>

#include "polhode/base/units.hpp"
#include "polhode/body/euler.hpp"

namespace polhode {

std::pair<Quaternion, Vector3> attitude_and_rate(const Spinner& s) {
  const Quaternion q =
      q_frame_from_body(EulerSequence("ZXZ"), degree * Vector3(s.alpha_deg + 90.0, 90.0 - s.delta_deg, s.angle_deg));
  Vector3 omega(0.0, 0.0, degree * s.rate_deg_s);
  if (const auto* nutation = std::get_if<Spinner::Nutation>(&s.turns)) {
    const double angle = degree * nutation->angle_deg;
    const double phase = degree * nutation->phase_deg;
    const Vector3 momentum(std::sin(angle) * std::cos(phase), -std::sin(angle) * std::sin(phase), std::cos(angle));
    omega += 2.0 * std::numbers::pi / nutation->period_s * momentum;
  } else if (const auto* about = std::get_if<Spinner::Momentum>(&s.turns)) {
    const double alpha = degree * about->alpha_deg;
    const double delta = degree * about->delta_deg;
    const Vector3 momentum(std::cos(delta) * std::cos(alpha), std::cos(delta) * std::sin(alpha), std::sin(delta));
    omega += degree * about->rate_deg_s * (q.conjugate() * momentum);
  }
  return {q, omega};
}

}  // namespace polhode
