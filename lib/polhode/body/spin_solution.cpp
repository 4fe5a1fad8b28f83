#include "polhode/body/spin_solution.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/body/invariants.hpp"

namespace polhode {
namespace {

/// Principal axes (0 long, 1 intermediate, 2 short) that are x, y, z of a convention.
std::array<int, 3> axes_of(AxisConvention convention) {
  return convention == AxisConvention::long_axis ? std::array<int, 3>{1, 2, 0} : std::array<int, 3>{0, 1, 2};
}

/// L of length 1 in the plane of the long and the short axis, with an energy E/E0 = 1 + excess.
Vector3 momentum_with_excess(const Vector3& moments, double excess) {
  // m1^2 (1/I1 - 1/I3) = excess / I3
  const double long_squared = excess * moments[0] / (moments[2] - moments[0]);
  return {std::sqrt(long_squared), 0.0, std::sqrt(std::max(1.0 - long_squared, 0.0))};
}

double precession_period(const SpinInvariants& spin, AxisConvention convention) {
  return convention == AxisConvention::long_axis ? spin.long_axis->precession_period_s
                                                 : spin.short_axis->precession_period_s;
}

/// P_psi / P_phi; nothing where the body does not tumble.
std::optional<double> ratio_at(const Inertia& inertia, AxisConvention convention, double excess) {
  const SpinInvariants spin = spin_invariants(inertia, momentum_with_excess(inertia.principal_moments, excess));
  if (!spin.polhode_period_s || !std::isfinite(*spin.polhode_period_s)) return std::nullopt;
  return *spin.polhode_period_s / precession_period(spin, convention);
}

/// The energies of one mode, from the calm end (rotation about an axis) to the separatrix.
struct Mode {
  bool long_axis = false;
  double calm = 0.0;
  double separatrix = 0.0;
  double excess(double part) const { return calm + part * (separatrix - calm); }
};

/// The excess energy with the wanted ratio, by halving; `range` gets what the mode can have.
std::optional<double> solve(const Inertia& inertia, AxisConvention convention, const Mode& mode, double wanted,
                            std::array<double, 2>& range) {
  double low = 1e-9;
  double high = 1.0 - 1e-12;
  const std::optional<double> at_low = ratio_at(inertia, convention, mode.excess(low));
  const std::optional<double> at_high = ratio_at(inertia, convention, mode.excess(high));
  if (!at_low || !at_high) return std::nullopt;
  range = {std::min(*at_low, *at_high), std::max(*at_low, *at_high)};
  if (!(wanted > range[0] && wanted < range[1])) return std::nullopt;
  const bool rising = *at_high > *at_low;
  for (int i = 0; i < 200 && high - low > 1e-16 * high; ++i) {
    const double middle = 0.5 * (low + high);
    const std::optional<double> at = ratio_at(inertia, convention, mode.excess(middle));
    if (!at || (*at < wanted) != rising) {
      high = middle;
    } else {
      low = middle;
    }
  }
  return mode.excess(0.5 * (low + high));
}

/// The motion of a symmetric body whose periods follow its symmetry axis s, t being any axis across: with the angle
/// theta from L to s, constant, phi turns at L / It and psi at L cos(theta) (1/Is - 1/It).
SpinSolution about_symmetry_axis(const Inertia& inertia, const PublishedPeriods& periods, bool prolate) {
  const Vector3& moments = inertia.principal_moments;
  const double along = prolate ? moments[0] : moments[2];
  const double across = moments[1];
  const double wanted = periods.rotation_period_s / periods.precession_period_s;
  const double least = along / std::abs(across - along);
  const double cosine = least / wanted;
  if (!(cosine < 1.0)) {
    throw InputError(fmt::format(
        "P_psi / P_phi = {:.6g} does not occur with these moments of inertia: for a symmetric body it is {:.6g} / "
        "cos(theta)",
        wanted, least));
  }
  const double sine_squared = (1.0 - cosine) * (1.0 + cosine);
  SpinSolution s;
  s.long_axis_mode = prolate;
  s.energy = 1.0 + (prolate ? cosine * cosine * (across - along) / along : sine_squared * (along - across) / across);
  s.separatrix_distance = 1.0;
  s.momentum = 2.0 * std::numbers::pi * across / periods.precession_period_s;
  const double sine = std::sqrt(sine_squared);
  s.momentum_at_psi_zero = s.momentum * (prolate ? Vector3(cosine, 0.0, sine) : Vector3(sine, 0.0, cosine));
  return s;
}

}  // namespace

Matrix3 matrix_of(AxisConvention convention) {
  const std::array<int, 3> axes = axes_of(convention);
  Matrix3 convention_from_principal = Matrix3::Zero();
  for (int k = 0; k < 3; ++k) convention_from_principal(k, axes[static_cast<std::size_t>(k)]) = 1.0;
  return convention_from_principal;
}

std::vector<SpinSolution> solve_periods(const Inertia& inertia, const PublishedPeriods& periods) {
  check(inertia);
  const Vector3& moments = inertia.principal_moments;
  if (moments[0] == moments[2]) {
    throw InputError("all moments of inertia are equal: a sphere turns about a fixed axis and has one period only");
  }
  if (!(periods.rotation_period_s > 0.0 && periods.precession_period_s > 0.0 &&
        std::isfinite(periods.rotation_period_s) && std::isfinite(periods.precession_period_s))) {
    throw InputError(fmt::format("the periods are P_phi = {} s and P_psi = {} s; both must be positive and finite",
                                 periods.precession_period_s, periods.rotation_period_s));
  }
  const bool prolate = moments[1] == moments[2];
  const bool symmetric = prolate || moments[0] == moments[1];
  if (symmetric && periods.long_axis_mode.value_or(prolate) != prolate) {
    throw InputError(fmt::format("a body with two equal moments of inertia, the {} ones, tumbles in {}-axis mode only",
                                 prolate ? "larger" : "smaller", prolate ? "long" : "short"));
  }
  if (symmetric && (periods.convention == AxisConvention::long_axis) == prolate) {
    return {about_symmetry_axis(inertia, periods, prolate)};
  }
  const double wanted = periods.rotation_period_s / periods.precession_period_s;
  const std::array<Mode, 2> modes{{{false, 0.0, moments[2] / moments[1] - 1.0},
                                   {true, moments[2] / moments[0] - 1.0, moments[2] / moments[1] - 1.0}}};
  std::vector<SpinSolution> solutions;
  std::string ranges;
  for (const Mode& mode : modes) {
    if (periods.long_axis_mode && *periods.long_axis_mode != mode.long_axis) continue;
    if (mode.calm == mode.separatrix) continue;  // a symmetric body has one mode
    std::array<double, 2> range{};
    const std::optional<double> excess = solve(inertia, periods.convention, mode, wanted, range);
    ranges += fmt::format("{}{:.4g} to {:.4g} in {}-axis mode", ranges.empty() ? "" : ", ", range[0], range[1],
                          mode.long_axis ? "long" : "short");
    if (!excess) continue;
    const Vector3 unit = momentum_with_excess(moments, *excess);
    const SpinInvariants spin = spin_invariants(inertia, unit);
    SpinSolution s;
    s.long_axis_mode = mode.long_axis;
    s.energy = 1.0 + *excess;
    s.separatrix_distance = spin.separatrix_distance.value();
    s.momentum = *spin.polhode_period_s / periods.rotation_period_s;  // periods go as 1/L
    s.momentum_at_psi_zero = s.momentum * unit;
    solutions.push_back(s);
  }
  if (solutions.empty()) {
    throw InputError(
        fmt::format("P_psi / P_phi = {:.6g} does not occur with these moments of inertia: it is {}", wanted, ranges));
  }
  return solutions;
}

double energy_at(const Inertia& inertia, AxisConvention convention, double theta_rad, double psi_rad) {
  check(inertia);
  if (!std::isfinite(theta_rad) || !std::isfinite(psi_rad)) throw InputError("the angles theta and psi are not finite");
  const std::array<int, 3> axes = axes_of(convention);
  const double transverse = std::pow(std::sin(psi_rad), 2) / inertia.principal_moments[axes[0]] +
                            std::pow(std::cos(psi_rad), 2) / inertia.principal_moments[axes[1]];
  const double sine = std::sin(theta_rad);
  const double cosine = std::cos(theta_rad);
  return inertia.principal_moments[2] *
         (sine * sine * transverse + cosine * cosine / inertia.principal_moments[axes[2]]);
}

EulerState state_at(const Inertia& inertia, AxisConvention convention, const SpinSolution& motion, double phi_rad,
                    double psi_rad, bool theta_above_90_deg) {
  check(inertia);
  if (!(motion.momentum > 0.0 && std::isfinite(motion.momentum) && std::isfinite(motion.energy))) {
    throw InputError(
        fmt::format("the motion has the momentum {} and E/E0 = {}; a positive momentum and finite numbers "
                    "are wanted",
                    motion.momentum, motion.energy));
  }
  const std::array<int, 3> axes = axes_of(convention);
  const Vector3& moments = inertia.principal_moments;
  const double transverse =
      std::pow(std::sin(psi_rad), 2) / moments[axes[0]] + std::pow(std::cos(psi_rad), 2) / moments[axes[1]];
  const double about_axis = 1.0 / moments[axes[2]];
  const double energy = motion.energy / moments[2];
  const double sine_squared = (about_axis - energy) / (about_axis - transverse);
  if (!(sine_squared >= 0.0 && sine_squared <= 1.0)) {
    throw InputError(fmt::format("psi = {:.6g} deg is never reached at E/E0 = {:.6g}",
                                 psi_rad * 180.0 / std::numbers::pi, motion.energy));
  }
  const double cosine = std::sqrt((energy - transverse) / (about_axis - transverse));
  const double theta = std::atan2(std::sqrt(sine_squared), theta_above_90_deg ? -cosine : cosine);
  const Quaternion q_momentum_from_convention = q_frame_from_body(EulerSequence("ZXZ"), {phi_rad, theta, psi_rad});
  EulerState state;
  state.theta_rad = theta;
  state.q_momentum_from_principal = (q_momentum_from_convention * Quaternion(matrix_of(convention))).normalized();
  state.momentum_principal = motion.momentum * (state.q_momentum_from_principal.conjugate() * Vector3::UnitZ());
  return state;
}

Quaternion q_frame_from_momentum(double longitude_rad, double latitude_rad) {
  if (!std::isfinite(longitude_rad) || !std::isfinite(latitude_rad)) {
    throw InputError("the direction of the angular momentum is not finite");
  }
  return Quaternion(Eigen::AngleAxisd(longitude_rad, Vector3::UnitZ())) *
         Quaternion(Eigen::AngleAxisd(0.5 * std::numbers::pi - latitude_rad, Vector3::UnitY()));
}

}  // namespace polhode
