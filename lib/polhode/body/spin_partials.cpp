#include "polhode/body/spin_partials.hpp"

#include <cmath>
#include <numbers>

#include "polhode/base/dual.hpp"
#include "polhode/base/error.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/body/series_rates.hpp"

namespace polhode {
namespace {

using EnergyAndMoments = Dual<4>;  // derivatives by E/E0, I1, I2, I3

struct UnitPeriods {
  EnergyAndMoments rotation, precession;  // P_psi and P_phi for a momentum of 1
};

UnitPeriods unit_periods(const Vector3& moments, AxisConvention convention, const SpinSolution& motion) {
  const auto moment = [&](int k) { return EnergyAndMoments::variable(moments[k], k + 1); };
  const EnergyAndMoments i1 = moment(0), i2 = moment(1), i3 = moment(2);
  const EnergyAndMoments excess = EnergyAndMoments::variable(motion.energy - 1.0, 0);
  const EnergyAndMoments i21 = i2 - i1, i31 = i3 - i1, i32 = i3 - i2;
  const EnergyAndMoments delta1 = (i31 - excess * i1) / i3, delta2 = (i32 - excess * i2) / i3, delta3 = -excess;
  using Canonical = CanonicalBody<EnergyAndMoments>;
  const Canonical c = motion.long_axis_mode ? Canonical{i3, i2, i1, -i32, -i31, -i21, delta3, delta2, delta1}
                                            : Canonical{i1, i2, i3, i21, i31, i32, delta1, delta2, delta3};
  const auto rates = series_rates(c, c.delta2 * c.i31 / (c.delta1 * c.i32));
  const bool of_mode_axis = motion.long_axis_mode == (convention == AxisConvention::long_axis);
  const EnergyAndMoments precession = of_mode_axis ? 2.0 * rates.rho + rates.nu : 2.0 * rates.rho;
  return {2.0 * std::numbers::pi / abs(rates.nu), 2.0 * std::numbers::pi / precession};
}

}  // namespace

TumblingPartials tumbling_partials(const Inertia& inertia, const PublishedTumbling& spin) {
  const Vector3& moments = inertia.principal_moments;
  const PublishedPeriods& periods = spin.periods;
  const SpinSolution& motion = spin.motion;
  const EulerState state =
      state_at(inertia, periods.convention, motion, spin.phi_rad, spin.psi_rad, spin.theta_above_90_deg);
  const UnitPeriods unit = unit_periods(moments, periods.convention, motion);
  const EnergyAndMoments ratio = unit.rotation / unit.precession;

  const Matrix3 convention_from_principal = matrix_of(periods.convention);
  const auto axis_of = [&](int k) {
    Eigen::Index axis = 0;
    convention_from_principal.row(k).maxCoeff(&axis);
    return static_cast<int>(axis);
  };
  const int x = axis_of(0), y = axis_of(1), z = axis_of(2);
  const double sine = std::sin(spin.psi_rad), cosine = std::cos(spin.psi_rad);
  const double transverse = sine * sine / moments[x] + cosine * cosine / moments[y], along = 1.0 / moments[z];
  const double energy = motion.energy / moments[2];
  const double of_sine_squared = std::sin(2.0 * state.theta_rad);  // d sin^2(theta) / d theta
  const Vector3 direction = state.momentum_principal / motion.momentum;
  const EulerSequence zxz("ZXZ");
  const Vector3 angles(spin.phi_rad, state.theta_rad, spin.psi_rad);

  // The effect of changes of E/E0, L, the moments and psi: theta follows from them.
  const auto column = [&](double d_phi, double d_psi, double d_energy_ratio, double d_momentum,
                          const Vector3& d_moments) {
    const double d_along = -d_moments[z] * along * along;
    const double d_energy = (d_energy_ratio - energy * d_moments[2]) / moments[2];
    const double d_transverse = 2.0 * sine * cosine * (1.0 / moments[x] - 1.0 / moments[y]) * d_psi -
                                sine * sine * d_moments[x] / (moments[x] * moments[x]) -
                                cosine * cosine * d_moments[y] / (moments[y] * moments[y]);
    const double apart = along - transverse;
    const double d_sine_squared =
        ((d_along - d_energy) * apart - (along - energy) * (d_along - d_transverse)) / (apart * apart);
    const double d_theta = d_sine_squared == 0.0 ? 0.0 : d_sine_squared / of_sine_squared;
    if (!std::isfinite(d_theta)) {
      throw InputError("theta is 90 deg: how uncertain it is does not follow from the uncertainties in proportion");
    }
    const Vector3 turn = convention_from_principal.transpose() * omega_body_rad_s(zxz, angles, {d_phi, d_theta, d_psi});
    return TumblingPartials::Column{turn, d_momentum * direction + motion.momentum * direction.cross(turn)};
  };
  // E/E0 as the periods' ratio and the moments have it, and L, which makes P_psi what it is.
  const auto at_periods = [&](double d_ratio, double d_rotation_s, const Vector3& d_moments) {
    const double d_energy = (d_ratio - ratio.partials.tail<3>().dot(d_moments)) / ratio.partials[0];
    const double d_unit_period = unit.rotation.partials[0] * d_energy + unit.rotation.partials.tail<3>().dot(d_moments);
    const double d_momentum = (d_unit_period - motion.momentum * d_rotation_s) / periods.rotation_period_s;
    return column(0.0, 0.0, d_energy, d_momentum, d_moments);
  };
  const Vector3 none = Vector3::Zero();
  const Quaternion q_principal_from_momentum = state.q_momentum_from_principal.conjugate();
  const double from_pole_rad = 0.5 * std::numbers::pi - spin.latitude_rad;
  const double published = periods.rotation_period_s / periods.precession_period_s;
  TumblingPartials out;
  out.longitude.turn = q_principal_from_momentum * Vector3(-std::sin(from_pole_rad), 0.0, std::cos(from_pole_rad));
  out.latitude.turn = q_principal_from_momentum * Vector3(0.0, -1.0, 0.0);
  out.phi = column(1.0, 0.0, 0.0, 0.0, none);
  out.psi = column(0.0, 1.0, 0.0, 0.0, none);
  out.precession_period = at_periods(-published / periods.precession_period_s, 0.0, none);
  out.rotation_period = at_periods(1.0 / periods.precession_period_s, 1.0, none);
  for (int k = 0; k < 3; ++k) out.moments[static_cast<std::size_t>(k)] = at_periods(0.0, 0.0, Vector3::Unit(k));
  return out;
}

}  // namespace polhode
