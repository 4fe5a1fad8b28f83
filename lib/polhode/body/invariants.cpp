#include "polhode/body/invariants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/body/series_rates.hpp"

namespace polhode {
namespace {

constexpr double pi = std::numbers::pi;

}  // namespace

std::string_view name(RotationMode mode) {
  switch (mode) {
    case RotationMode::rest:
      return "at rest";
    case RotationMode::sphere:
      return "sphere";
    case RotationMode::principal_axis:
      return "principal-axis rotation";
    case RotationMode::short_axis:
      return "short-axis mode";
    case RotationMode::long_axis:
      return "long-axis mode";
    case RotationMode::separatrix:
      break;
  }
  return "separatrix";
}

SpinInvariants spin_invariants(const Inertia& inertia, const Vector3& momentum_principal) {
  check(inertia);
  check_angular_momentum(momentum_principal);
  SpinInvariants out;
  out.momentum = momentum_principal.stableNorm();
  if (out.momentum == 0.0) return out;
  const Vector3 m = momentum_principal / out.momentum;                      // a unit vector from here on
  const double unit = std::exp2(std::ilogb(inertia.principal_moments[2]));  // exact; keeps products in range
  const Vector3 i = inertia.principal_moments / unit;
  const double rate_unit_rad_s = out.momentum / unit;
  const Vector3 omega_rad_s = momentum_principal.cwiseQuotient(inertia.principal_moments);
  out.twice_energy = momentum_principal.dot(omega_rad_s);
  if (!(out.twice_energy > 0.0 && std::isfinite(out.twice_energy) && omega_rad_s.allFinite())) {
    throw InputError(
        fmt::format("twice the energy is {}: doubles do not hold that of a momentum of {} and moments of {} to {}",
                    out.twice_energy, out.momentum, inertia.principal_moments[0], inertia.principal_moments[2]));
  }
  const double i21 = i[1] - i[0], i31 = i[2] - i[0], i32 = i[2] - i[1];
  const Vector3 part = m.cwiseProduct(m).cwiseQuotient(i);
  const double delta1 = part[1] * i21 + part[2] * i31;
  const double delta2 = part[2] * i32 - part[0] * i21;
  const double delta3 = -(part[0] * i31 + part[1] * i32);
  out.energy_above_ground = -delta3;
  out.separatrix_offset = delta2;

  const auto both = [&](int a, int b, double difference) { return m[a] != 0.0 && m[b] != 0.0 && difference != 0.0; };
  if (!both(0, 1, i21) && !both(0, 2, i31) && !both(1, 2, i32)) {
    out.mode = i31 == 0.0 ? RotationMode::sphere : RotationMode::principal_axis;
    out.rotation_period_s = 2.0 * pi / omega_rad_s.stableNorm();
    if (i31 != 0.0) m.cwiseAbs().maxCoeff(&out.rotation_axis);
    return out;
  }

  const bool short_mode = delta2 >= 0.0;
  using Canonical = CanonicalBody<double>;
  const Canonical c = short_mode ? Canonical{i[0], i[1], i[2], i21, i31, i32, delta1, delta2, delta3}
                                 : Canonical{i[2], i[1], i[0], -i32, -i31, -i21, delta3, delta2, delta1};
  const double m_c = std::min(1.0, c.delta2 * c.i31 / (c.delta1 * c.i32));
  const bool on_separatrix = m_c <= 8.0 * std::numeric_limits<double>::epsilon();
  out.mode = on_separatrix ? RotationMode::separatrix : short_mode ? RotationMode::short_axis : RotationMode::long_axis;
  out.separatrix_distance = on_separatrix ? 0.0 : m_c;
  const SeriesRates<double> rates = series_rates(c, *out.separatrix_distance);
  out.polhode_period_s = 2.0 * pi / (std::abs(rates.nu) * rate_unit_rad_s);

  // The polhode crosses two planes between axes: (1, 3), and (2, 3) or (1, 2). The axis of the mode is farthest from L
  // in the one and nearest in the other; the opposite axis swings as far to either side of the normal to L.
  const double in_13_along_1 = std::sqrt(-i[0] * delta3 / i31), in_13_along_3 = std::sqrt(i[2] * delta1 / i31);
  const double crossed = short_mode ? std::atan2(std::sqrt(-i[1] * delta3), std::sqrt(i[2] * delta2))
                                    : std::atan2(std::sqrt(i[1] * delta1), std::sqrt(-i[0] * delta2));
  const double of_mode_in_13 =
      short_mode ? std::atan2(in_13_along_1, in_13_along_3) : std::atan2(in_13_along_3, in_13_along_1);
  const double opposite = 0.5 * pi - of_mode_in_13;
  const AxisMotion mode_axis{2.0 * pi / ((2.0 * rates.rho + rates.nu) * rate_unit_rad_s),
                             std::min(of_mode_in_13, crossed), std::max(of_mode_in_13, crossed)};
  const AxisMotion other_axis{2.0 * pi / (2.0 * rates.rho * rate_unit_rad_s), opposite, pi - opposite};
  out.short_axis = short_mode ? mode_axis : other_axis;
  out.long_axis = short_mode ? other_axis : mode_axis;
  return out;
}

std::vector<LightCurveFrequency> light_curve_frequencies(const SpinInvariants& spin) {
  if (!spin.polhode_period_s || !spin.long_axis || !std::isfinite(*spin.polhode_period_s)) return {};
  const double phi = 1.0 / spin.long_axis->precession_period_s, psi = 1.0 / *spin.polhode_period_s;
  return {{"1/P_phi", phi},
          {"2/P_phi", 2.0 * phi},
          {"2/P_psi", 2.0 * psi},
          {"2/P_phi - 2/P_psi", 2.0 * (phi - psi)},
          {"2/P_phi + 2/P_psi", 2.0 * (phi + psi)}};
}

Vector3 momentum_principal(const Body& body) {
  if (!body.inertia) throw InputError("body '" + body.name + "' has no inertia: an angular momentum needs it");
  if (!body.state || !body.state->omega_named_rad_s) {
    throw InputError("body '" + body.name + "' has no angular velocity or momentum");
  }
  const Inertia& inertia = *body.inertia;
  check(inertia);
  if (!body.state->omega_named_rad_s->allFinite()) {
    throw InputError("body '" + body.name + "' has an angular velocity that is not finite");
  }
  const Vector3 omega_rad_s = inertia.named_from_principal.transpose() * *body.state->omega_named_rad_s;
  return inertia.principal_moments.cwiseProduct(omega_rad_s);
}

Vector3 momentum_in_frame(const Body& body, Frame frame) {
  const Vector3 momentum = momentum_principal(body);
  if (!body.state->q_frame_from_named) throw InputError("body '" + body.name + "' has no attitude");
  const Vector3 in_state_frame = *body.state->q_frame_from_named * (body.inertia->named_from_principal * momentum);
  if (frame == body.state->frame) return in_state_frame;
  return q_icrf_from(frame).conjugate() * (q_icrf_from(body.state->frame, body.state->epoch) * in_state_frame);
}

}  // namespace polhode
