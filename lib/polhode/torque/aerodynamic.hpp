#pragma once

#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "polhode/torque/facets.hpp"
#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// Density falls by a factor of e in every scale height; all of it turns with the planet.
struct ExponentialAtmosphere {
  double density_kg_m3 = 0.0;            ///< at `distance_m`, 0 or more
  double distance_m = 0.0;               ///< from the planet's centre, positive
  double scale_height_m = 0.0;           ///< positive
  Vector3 turn_rad_s = Vector3::Zero();  ///< the planet's rate of rotation, inertial axes; the Earth's is 7.292115e-5

  /// Throws InputError for a number out of its range.
  void check() const;
  double density_at(double r_m) const { return density_kg_m3 * std::exp((distance_m - r_m) / scale_height_m); }
};

/// Torque of air so thin that its molecules meet the body one by one, and so slow beside the body that all of them come
/// from one direction (free molecular flow, hyperthermal limit; Hughes 1986, Spacecraft Attitude Dynamics, section 8.1;
/// Wertz 1978, section 17.2.3). The share `accommodation` of them stays for a moment and leaves by Lambert's law, at a
/// mean speed along the normal of `rebound_speed` beside that with which they came; the rest is mirrored. A facet of
/// area A, outward normal n, at x, met at cosine c = n . s > 0 by air from direction s at speed v feels
///
///     force = -(density v^2) A c (accommodation s + (2 (1 - accommodation) c + accommodation rebound_speed) n)
///
/// Facets do not shade each other, and that the body's own rotation moves them is left out.
class Aerodynamic {
 public:
  static constexpr std::string_view name = "aerodynamic";
  static constexpr std::array<std::string_view, 11> keys{
      "mesh",          "unit_m",     "centre_of_mass", "accommodation", "rebound_speed", "orbit",
      "density_kg_m3", "distance_m", "scale_height_m", "turn_rad_s",    "turn_axis"};
  static constexpr bool needs_absolute_inertia = true;

  struct Surface {
    double accommodation = 1.0;  ///< 0 to 1
    double rebound_speed = 0.0;  ///< 0 or more
  };
  /// Throws InputError for numbers out of their range.
  static Rebound rebound(const Surface& surface);

  /// Facets in body axes, `way` of the body from the planet. Throws InputError for what Facets refuses.
  Aerodynamic(const std::vector<Facet>& facets, const ExponentialAtmosphere& atmosphere, Trajectory way)
      : trajectory(std::move(way)), facets_(facets), atmosphere_(atmosphere) {}

  template <class Table>
  static Aerodynamic read(const Table& table) {
    std::vector<Facet> facets = table.facets([](const auto& surface) {
      const Surface numbers{surface.number("accommodation"), surface.number("rebound_speed")};
      return surface.located("accommodation", [&] { return rebound(numbers); });
    });
    return {facets,
            {table.number("density_kg_m3"), table.positive_number("distance_m"),
             table.positive_number("scale_height_m"), table.number("turn_rad_s") * table.direction("turn_axis")},
            table.orbit().trajectory};
  }

  const std::vector<Facet>& facets() const { return facets_.given(); }
  const ExponentialAtmosphere& atmosphere() const { return atmosphere_; }

  void check() const { atmosphere_.check(); }
  Aerodynamic turned(const Matrix3& to_from) const {
    Aerodynamic other = *this;
    other.facets_ = facets_.turned(to_from);
    return other;
  }

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    const Flow flow = flow_at(place);
    if (flow.pressure_pa != 0.0) {
      terms.constant += (flow.pressure_pa * facets_.torque_m3(flow.from_body)).template cast<Real>();
    }
  }

  bool has_kinks() const { return true; }  // where air begins to meet a facet
  bool has_edges() const { return facets_.has_edges(); }
  TorqueStream stream_at(const TorquePlace<double>& place) const {
    const Flow flow = flow_at(place);
    return {flow.from_body, flow.pressure_pa, facets_.edges()};
  }

  double largest(double t_s, const Vector3& moments, double momentum) const;
  double cost_of_evaluation() const { return facets_.cost_of_evaluation(); }
  Aerodynamic with_table() const {
    Aerodynamic other = *this;
    other.facets_ = facets_.with_table();
    return other;
  }
  bool has_table() const { return facets_.has_table(); }
  double evaluations_for_table() const { return facets_.evaluations_for_table(); }

  template <class Visit>
  void parameters(const Visit& visit) {
    visit("density_kg_m3", atmosphere_.density_kg_m3);
  }

  Trajectory trajectory;  ///< of the body, from the planet

 private:
  struct Flow {
    Vector3 from_body;   // unit vector to where the air comes from, body axes
    double pressure_pa;  // density v^2
  };
  template <class Real>
  Flow flow_at(const TorquePlace<Real>& place) const {
    // NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): torques with a trajectory are given their orbit
    const Vector3 r = place.orbit->position_m.template cast<double>();
    const Vector3 v = place.orbit->velocity_m_s.template cast<double>() - atmosphere_.turn_rad_s.cross(r);
    const double v2 = v.squaredNorm();
    if (!(v2 > 0.0)) return {Vector3::UnitX(), 0.0};
    return {place.inertial_from_body.template cast<double>().transpose() * (v / std::sqrt(v2)),
            atmosphere_.density_at(r.norm()) * v2};
  }

  Facets facets_;
  ExponentialAtmosphere atmosphere_;
};

}  // namespace polhode
