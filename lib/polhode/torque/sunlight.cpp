#include "polhode/torque/sunlight.hpp"

#include <fmt/format.h>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

constexpr double kSolarConstant_w_m2 = 1361.0;  // total solar irradiance at 1 au, IAU 2015 resolution B3
constexpr double kAstronomicalUnit_m = 149597870700.0;
constexpr double kLightSpeed_m_s = 299792458.0;

}  // namespace

Rebound Sunlight::rebound(const Surface& surface) {
  if (!(surface.specular >= 0.0 && surface.diffuse >= 0.0 && surface.specular + surface.diffuse <= 1.0)) {
    throw InputError(
        fmt::format("the surface reflects {} specular and {} diffuse, shares from 0 to 1 together are wanted",
                    surface.specular, surface.diffuse));
  }
  return {1.0 - surface.specular, 2.0 * surface.specular, 2.0 / 3.0 * surface.diffuse};
}

void Sunlight::check() const {
  if (second_trajectory && !(ball_radius_m_ > 0.0 && std::isfinite(ball_radius_m_))) {
    throw InputError(
        fmt::format("the radius of what eclipses the Sun is {} m, a positive number is wanted", ball_radius_m_));
  }
  if (second_trajectory && *second_trajectory == trajectory) {
    throw InputError("what eclipses the Sun has the orbit of the Sun itself");
  }
  if (second_trajectory && !(ball_radius_m_ < second_trajectory->least_distance_m())) {
    throw InputError(
        fmt::format("what eclipses the Sun has the radius {:g} m, and the body comes within {:g} m of its "
                    "centre",
                    ball_radius_m_, second_trajectory->least_distance_m()));
  }
}

double Sunlight::pressure_pa(double r2) {
  return kSolarConstant_w_m2 / kLightSpeed_m_s * (kAstronomicalUnit_m * kAstronomicalUnit_m / r2);
}

std::vector<double> Sunlight::times_of_kinks_s(double first_s, double last_s) const {
  if (!second_trajectory) return {};
  return shadow_edges_s(trajectory, *second_trajectory, ball_radius_m_, first_s, last_s);
}

double Sunlight::largest(double t_s, const Vector3& /*moments*/, double /*momentum*/) const {
  return std::abs(strength_) * pressure_pa(trajectory.state(t_s).position_m.squaredNorm()) * facets_.largest_m3();
}

}  // namespace polhode
