#include <algorithm>
#include <cmath>

#include "polhode/motion/taylor/equations.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode::taylor {
namespace {

using Extended = long double;

/// Of the torques that a run is made for.
struct Parts {
  int pulls = 0, fields = 0;
  const KeplerOrbit* only_orbit = nullptr;  // of the only point mass
  double only_mu_m3_s2 = 0.0;
  const KeplerOrbit* field_orbit = nullptr;
  Vector3 dipole_t_m3 = Vector3::Zero();  // inertial
  Vector3 constant = Vector3::Zero(), outside = Vector3::Zero();
  Matrix3 damping = Matrix3::Zero(), magnetic_tensor_s_m4 = Matrix3::Zero();
  double relaxation = 0.0;
  // (Whatever their numbers: one may be 0 and its derivative wanted.)
  bool served = true, damped = false, slips = false, has_outside = false;

  void add(const GravityGradient& one) {
    only_orbit = pulls++ == 0 ? one.trajectory.orbit() : nullptr;
    only_mu_m3_s2 = one.mu_m3_s2;
  }
  void add(const ConstantTorque& one) {
    const bool is_outside = one.axes == ConstantTorque::Axes::inertial;
    (is_outside ? outside : constant) += one.torque;
    has_outside = has_outside || is_outside;
  }
  void add(const ThrusterPulse& /*one*/) {}  // a constant torque between its jumps
  void add(const LinearDamping& one) { damping += one.coefficients, damped = true; }
  void add(const InternalDissipation& one) { relaxation += one.relaxation, slips = true; }
  void add(const EddyCurrents& one) {
    served = served && fields++ == 0;
    magnetic_tensor_s_m4 = one.magnetic_tensor_s_m4;
    field_orbit = one.trajectory.orbit();
    dipole_t_m3 = one.dipole_t_m3 * one.dipole_axis;
  }
  template <class Other>
  void add(const Other& /*one*/) {  // of which nothing but values is known
    served = false;
  }

  /// Whether all depends on one orbit.
  bool plane() const {
    return pulls == 1 && only_orbit != nullptr && (fields == 0 || field_orbit == only_orbit) && !has_outside && !slips;
  }
};

Parts parts_of(const Torques& torques) {
  Parts parts;
  for (const Torque& torque : torques.list()) {
    std::visit([&](const auto& one) { parts.add(one); }, torque);
  }
  return parts;
}

/// The entry of kEntries in taylor/run.hpp.
int kinds_of(const Parts& parts) {
  if (parts.plane()) return parts.fields > 0 ? 7 : parts.damped ? 3 : 2;
  const bool more = parts.has_outside || parts.slips;
  if (parts.fields == 0 && parts.pulls == 0) return more ? 4 : parts.damped ? 1 : 0;
  return more || parts.damped || parts.fields > 0 ? 6 : 5;
}

/// The fixed axes: of the orbit, if it is alone.
Matrix3Of<Extended> axes_of(const Parts& parts) {
  if (!parts.plane()) return Matrix3Of<Extended>::Identity();
  const auto [x, y] = parts.only_orbit->axes();
  Matrix3Of<Extended> axes;
  axes << x, y, x.cross(y);
  return axes;
}

}  // namespace

bool have_series(const Torques& torques) { return parts_of(torques).served; }

Matrix3Of<Extended> fixed_axes(const Torques& torques) { return axes_of(parts_of(torques)); }

Equations equations_of(const Vector3Of<Extended>& I, const Torques& torques, double unit_s) {
  const Parts parts = parts_of(torques);
  Equations equations;
  equations.unit_s = unit_s;
  equations.kinds = kinds_of(parts);
  for (int i = 0; i < 3; ++i) {
    const Extended a = I[(i + 1) % 3], b = I[(i + 2) % 3], c = I[i], first = I[0];
    equations.euler_weights[i] = (a - b) / c;
    equations.moments[i] = c / first;
    equations.slip_weights[i] = parts.relaxation * (a - b) / unit_s;
    equations.inverse_moments[i] = first / c;
    equations.constant[i] = parts.constant[i] / c * unit_s * unit_s;
    equations.outside[i] = parts.outside[i] / first * unit_s * unit_s;
    for (int k = 0; k < 3; ++k) {
      equations.damping[k][i] = -parts.damping(i, k) / c * unit_s;
      equations.magnetic_tensor[k][i] = parts.magnetic_tensor_s_m4(i, k) / first * unit_s;
    }
  }
  if (parts.plane()) {
    const KeplerElements& elements = parts.only_orbit->elements();
    Equations::Orbit& o = equations.orbit;
    o.orbit = parts.only_orbit;
    o.eccentricity = elements.eccentricity;
    o.parameter_m = elements.periapsis_m * (Extended(1) + elements.eccentricity);
    o.rate = std::sqrt(parts.only_mu_m3_s2 / o.parameter_m) / o.parameter_m * unit_s;
    const Vector3 dipole = axes_of(parts).cast<double>().transpose() * parts.dipole_t_m3;
    for (int i = 0; i < 3; ++i) o.dipole[i] = dipole[i] / std::pow(static_cast<double>(o.parameter_m), 3);
  }
  return equations;
}

BodyNumbers BodyNumbers::change_from(const BodyNumbers& others, long double by) const {
  static_assert(sizeof(BodyNumbers) % sizeof(long double) == 0);
  constexpr std::size_t count = sizeof(BodyNumbers) / sizeof(long double);
  BodyNumbers change;
  const auto* a = reinterpret_cast<const long double*>(this);
  const auto* b = reinterpret_cast<const long double*>(&others);
  auto* const to = reinterpret_cast<long double*>(&change);
  for (std::size_t i = 0; i < count; ++i) to[i] = (a[i] - b[i]) / by;
  return change;
}

}  // namespace polhode::taylor
