#include "polhode/body/phase.hpp"

#include <fmt/format.h>

#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/time/duration_text.hpp"

namespace polhode {

double phase_horizon_s(const Vector3& omega_rad_s, double period_uncertainty, double angle_rad) {
  if (!omega_rad_s.allFinite() || !(period_uncertainty > 0.0 && angle_rad > 0.0)) {
    throw InputError(fmt::format(
        "the rate is {} rad/s, the periods are uncertain by {} of themselves, the angle is {} rad; a finite "
        "rate and positive numbers are wanted",
        omega_rad_s.norm(), period_uncertainty, angle_rad));
  }
  return angle_rad / (omega_rad_s.norm() * period_uncertainty);
}

std::optional<std::string> phase_warning(const Body& body, double farthest_s) {
  if (!body.period_uncertainty || !body.state || !body.state->omega_named_rad_s) return std::nullopt;
  const Vector3& omega_rad_s = *body.state->omega_named_rad_s;
  if (!(omega_rad_s.norm() > 0.0)) return std::nullopt;
  const auto after_s = [&](double angle_rad) {
    return phase_horizon_s(omega_rad_s, *body.period_uncertainty, angle_rad);
  };
  const double lost_s = after_s(std::numbers::pi);
  std::string text = fmt::format(
      "the periods are known to {:g} of themselves (one sigma): the phase of the rotation is uncertain by 1 deg {} "
      "from "
      "the epoch, and is lost (uncertain by 180 deg) {} from it",
      *body.period_uncertainty, duration_text(after_s(std::numbers::pi / 180.0)), duration_text(lost_s));
  if (farthest_s > lost_s) {
    text += fmt::format("; what is asked for lies beyond that, up to {} from the epoch", duration_text(farthest_s));
  }
  return text;
}

}  // namespace polhode
