#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "polhode/body/mesh_inertia.hpp"
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

  struct Surface {
    double specular = 0.0;  ///< share of the light mirrored
    double diffuse = 1.0;   ///< share scattered or sent out as heat from the same facet (Lambert's law)
  };

  /// `mesh` in metres, its origin the body's centre of mass, in body axes; `way` of the body from the Sun. Throws
  /// InputError for shares outside 0 to 1 or above 1 together, a mesh without facets, a corner that is not finite, an
  /// index without corner.
  Sunlight(const TriangleMesh& mesh, Surface surface, Trajectory way);

  template <class Real>
  void add(const TorquePlace<Real>& place, const Vector3Of<Real>&, TorqueTerms<Real>& terms) const {
    const Vector3 sun = -place.to_body(place.orbit->position_m).template cast<double>();
    terms.constant += torque(sun).cast<Real>();
  }

  void check() const {}  // nothing is left for it: see the constructor
  Sunlight turned(const Matrix3& to_from) const;

  /// N m, in the axes of the facets; `to_sun_body_m` is the vector from the body to the Sun, not 0.
  Vector3 torque(const Vector3& to_sun_body_m) const;

  /// N m: no attitude feels more at time t.
  double largest_torque(double t_s) const;

  std::size_t facet_count() const { return facets_->size(); }

  Trajectory trajectory;  ///< of the body, from the Sun

 private:
  struct Facet {
    Vector3 area_m2, centre_m;  // area times normal
  };
  std::shared_ptr<const std::vector<Facet>> facets_;
  double largest_moment_m3_ = 0.0;  // sum over the facets of area times distance
  Surface surface_;
};

}  // namespace polhode
