#include "polhode/torque/aerodynamic.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

void check_number(std::string_view what, double value, bool may_be_0) {
  if (!((may_be_0 ? value >= 0.0 : value > 0.0) && std::isfinite(value))) {
    throw InputError(fmt::format("{} is {}, {} is wanted", what, value, may_be_0 ? "0 or more" : "a positive number"));
  }
}

}  // namespace

void ExponentialAtmosphere::check() const {
  // Denser air does not let molecules meet a body one by one: at 90 km the Earth's has 3e-6 kg/m3, and free paths of
  // cm.
  constexpr double densest_kg_m3 = 1e-5, fastest_rad_s = 0.01;
  check_number("the density", density_kg_m3, true);
  if (density_kg_m3 > densest_kg_m3) {
    throw InputError(
        fmt::format("the density is {:g} kg/m3; thin air is meant, of up to {:g} kg/m3", density_kg_m3, densest_kg_m3));
  }
  check_number("the distance at which the density is known", distance_m, false);
  check_number("the scale height", scale_height_m, false);
  check_finite("the rotation of the atmosphere", turn_rad_s);
  if (turn_rad_s.norm() > fastest_rad_s) {
    throw InputError(fmt::format("the atmosphere turns with {:g} rad/s; up to {:g} rad/s are allowed",
                                 turn_rad_s.norm(), fastest_rad_s));
  }
}

Rebound Aerodynamic::rebound(const Surface& surface) {
  if (!(surface.accommodation >= 0.0 && surface.accommodation <= 1.0)) {
    throw InputError(fmt::format("the accommodation is {}, a share from 0 to 1 is wanted", surface.accommodation));
  }
  check_number("the speed of rebound", surface.rebound_speed, true);
  return {surface.accommodation, 2.0 * (1.0 - surface.accommodation), surface.accommodation * surface.rebound_speed};
}

double Aerodynamic::largest(double t_s, const Vector3& /*moments*/, double /*momentum*/) const {
  const OrbitState<double> here = trajectory.state(t_s);
  return flow_at(TorquePlace<double>{Matrix3::Identity(), &here}).pressure_pa * facets_.largest_m3();
}

}  // namespace polhode
