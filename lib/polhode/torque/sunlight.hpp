#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "polhode/torque/facets.hpp"
#include "polhode/torque/shadow.hpp"
#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// Pressure of sunlight on the facets of a body, and of the light and heat that they send back at once (YORP without
/// thermal inertia; Rubincam 2000, Icarus 148, 2; Scheeres 2007, Icarus 188, 430). A facet of area A, outward normal n,
/// at x, lit at cosine c = n . s > 0 by the Sun in direction s feels
///
///     force = -(pressure) A c ((1 - specular) s + (2 specular c + (2/3) diffuse) n),     torque = sum of x x force
///
/// Facets do not shade each other: for a body with deep hollows this is an estimate. A planet may stand between: the
/// pressure is then that of the share of the Sun's disc that is seen (torque/shadow.hpp).
class Sunlight {
 public:
  static constexpr std::string_view name = "sunlight";
  static constexpr std::array<std::string_view, 8> keys{"mesh",    "unit_m", "centre_of_mass", "specular",
                                                        "diffuse", "orbit",  "shadow_orbit",   "shadow_radius_m"};
  static constexpr bool needs_absolute_inertia = true;

  struct Surface {
    double specular = 0.0;  ///< share of the light mirrored
    double diffuse = 1.0;   ///< share scattered or sent out as heat from the same facet (Lambert's law)
  };
  /// Throws InputError for shares outside 0 to 1 or above 1 together.
  static Rebound rebound(const Surface& surface);

  /// A ball that eclipses the Sun: its radius, and the way of the body from its centre.
  struct Eclipsing {
    Trajectory trajectory;
    double radius_m;
  };

  /// Facets in body axes, `way` of the body from the Sun. Throws InputError for what Facets refuses.
  Sunlight(const std::vector<Facet>& facets, Trajectory way, std::optional<Eclipsing> eclipsing = std::nullopt)
      : trajectory(std::move(way)), facets_(facets) {
    if (!eclipsing) return;
    second_trajectory = std::move(eclipsing->trajectory);
    ball_radius_m_ = eclipsing->radius_m;
  }
  /// A mesh whose facets are all alike, in metres from the centre of mass. Throws InputError for what facets_of() and
  /// rebound() refuse.
  Sunlight(const TriangleMesh& mesh, Surface surface, Trajectory way)
      : Sunlight(facets_of(mesh, rebound(surface)), std::move(way)) {}

  template <class Table>
  static Sunlight read(const Table& table) {
    std::vector<Facet> facets = table.facets([](const auto& surface) {
      const Surface shares{surface.number("specular"), surface.number("diffuse")};
      return surface.located("specular", [&] { return rebound(shares); });
    });
    std::optional<Eclipsing> eclipsing;
    if (table.has("shadow_orbit") || table.has("shadow_radius_m")) {
      eclipsing = {table.orbit("shadow_orbit").trajectory, table.positive_number("shadow_radius_m")};
    }
    return {facets, table.orbit().trajectory, std::move(eclipsing)};
  }

  /// Throws InputError for a radius that is not positive or reaches to the body, and for an eclipse by the Sun itself.
  void check() const;
  Sunlight turned(const Matrix3& to_from) const {
    Sunlight other = *this;
    other.facets_ = facets_.turned(to_from);
    return other;
  }

  const std::vector<Facet>& facets() const { return facets_.given(); }
  double ball_radius_m() const { return ball_radius_m_; }  ///< of what eclipses the Sun; 0 if nothing does

  /// N m, in the axes of the facets, without an eclipse; `to_sun_body_m` is the vector from the body to the Sun, not 0.
  Vector3 torque(const Vector3& to_sun_body_m) const {
    const double r2 = to_sun_body_m.squaredNorm();
    return strength_ * pressure_pa(r2) * facets_.torque_m3(to_sun_body_m / std::sqrt(r2));
  }

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    const Light light = light_at(place);
    if (light.pressure_pa != 0.0) {
      terms.constant += (light.pressure_pa * facets_.torque_m3(light.from_body)).template cast<Real>();
    }
  }

  bool has_kinks() const { return true; }  // where a facet comes into the light or goes out of it
  std::vector<double> times_of_kinks_s(double first_s, double last_s) const;
  bool has_edges() const { return facets_.has_edges(); }
  TorqueStream stream_at(const TorquePlace<double>& place) const {
    const Light light = light_at(place);
    return {light.from_body, light.pressure_pa, facets_.edges()};
  }

  double largest(double t_s, const Vector3& moments, double momentum) const;
  double cost_of_evaluation() const { return facets_.cost_of_evaluation(); }
  Sunlight with_table() const {
    Sunlight other = *this;
    other.facets_ = facets_.with_table();
    return other;
  }
  bool has_table() const { return facets_.has_table(); }
  double evaluations_for_table() const { return facets_.evaluations_for_table(); }

  /// A factor of the torque: how wrong pressure and surface are together.
  template <class Visit>
  void parameters(const Visit& visit) {
    visit("strength", strength_);
  }

  Trajectory trajectory;                        ///< of the body, from the Sun
  std::optional<Trajectory> second_trajectory;  ///< and from a ball that eclipses it

 private:
  struct Light {
    Vector3 from_body;  // unit vector to the Sun, body axes
    double pressure_pa;
  };
  template <class Real>
  Light light_at(const TorquePlace<Real>& place) const {
    // NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): torques with a trajectory are given their orbit
    const Vector3 to_sun_m = -place.orbit->position_m.template cast<double>();
    const double r2 = to_sun_m.squaredNorm();
    Light light{place.inertial_from_body.template cast<double>().transpose() * (to_sun_m / std::sqrt(r2)),
                strength_ * pressure_pa(r2)};
    if (place.second_orbit != nullptr) {
      light.pressure_pa *= lit_share(to_sun_m, place.second_orbit->position_m.template cast<double>(), ball_radius_m_);
    }
    return light;
  }
  /// By the square of the distance in m.
  static double pressure_pa(double r2);

  Facets facets_;
  double ball_radius_m_ = 0.0;
  double strength_ = 1.0;
};

}  // namespace polhode
