#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "polhode/body/mesh_inertia.hpp"
#include "polhode/torque/sunlight_table.hpp"
#include "polhode/torque/trajectory.hpp"

namespace polhode {

/// Pressure of sunlight on the facets of a body, and of the light and heat that they send back at once (YORP without
/// thermal inertia; Rubincam 2000, Icarus 148, 2; Scheeres 2007, Icarus 188, 430). A facet of area A, outward normal n,
/// at x, lit at cosine c = n . s > 0 by the Sun in direction s feels
///
///     force = -(pressure) A c ((1 - specular) s + (2 specular c + (2/3) diffuse) n),     torque = sum of x x force
///
/// Facets do not shade each other, and there is no eclipse: for a body with deep hollows this is an estimate.
class Sunlight {
 public:
  static constexpr std::string_view name = "sunlight";
  static constexpr std::array<std::string_view, 6> keys{"mesh",     "unit_m",  "centre_of_mass",
                                                        "specular", "diffuse", "orbit"};
  static constexpr bool needs_absolute_inertia = true;
  static constexpr bool has_kinks = true;  // where a facet comes into the light or goes out of it

  struct Surface {
    double specular = 0.0;  ///< share of the light mirrored
    double diffuse = 1.0;   ///< share scattered or sent out as heat from the same facet (Lambert's law)
  };

  /// `mesh` in metres, its origin the body's centre of mass, in body axes; `way` of the body from the Sun. Throws
  /// InputError for shares outside 0 to 1 or above 1 together, a mesh without facets, a corner that is not finite, an
  /// index without corner.
  Sunlight(const TriangleMesh& mesh, Surface surface, Trajectory way);

  template <class Table>
  static Sunlight read(const Table& table) {
    const TriangleMesh mesh = table.mesh_from_centre_of_mass_m();
    const Surface surface{table.number("specular"), table.number("diffuse")};
    const Trajectory& from_sun = table.orbit().trajectory;
    return table.located("specular", [&] { return Sunlight(mesh, surface, from_sun); });
  }

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    const Vector3 sun = -place.to_body(place.orbit->position_m).template cast<double>();
    terms.constant += torque(sun).cast<Real>();
  }

  void check() const {}  // nothing is left for it: see the constructor
  Sunlight turned(const Matrix3& to_from) const;

  /// N m, in the axes of the facets (those with the same normal within 1e-12 are taken together); `to_sun_body_m` is
  /// the vector from the body to the Sun, not 0.
  Vector3 torque(const Vector3& to_sun_body_m) const;

  /// The parts of the facets' normals, if these are few (Torques::edges()).
  static constexpr std::size_t kMostEdges = 40;
  bool has_edges() const { return normals() <= kMostEdges; }
  void add_edges(const TorquePlace<double>& place, std::vector<TorqueEdge>& edges) const;

  double largest(double t_s, const Vector3& moments, double momentum) const;
  double cost_of_evaluation() const { return with_table_ ? 1.0 : static_cast<double>(normals()) / 50.0; }

  /// The same by a table of the Sun's direction, which is made when it is first asked for and shared by all copies.
  Sunlight with_table() const;
  /// After how many evaluations the table has paid for itself; infinite if the facets are few.
  double evaluations_for_table() const;
  bool has_table() const { return with_table_; }

  /// A factor of the torque: how wrong pressure and surface are together.
  template <class Visit>
  void parameters(const Visit& visit) {
    visit("strength", strength_);
  }

  Trajectory trajectory;  ///< of the body, from the Sun

 private:
  struct Facets;
  std::size_t normals() const;
  std::shared_ptr<const Facets> facets_;
  bool with_table_ = false;
  double largest_moment_m3_ = 0.0;  // sum over the facets of area times distance
  Surface surface_;
  double strength_ = 1.0;
};

}  // namespace polhode
