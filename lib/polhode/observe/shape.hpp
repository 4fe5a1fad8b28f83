#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/mesh_inertia.hpp"
#include "polhode/observe/kernel/target.hpp"
#include "polhode/observe/scattering.hpp"

namespace polhode {

/// A body's surface, as it shines. Everything is in its named axes and in metres.
class Shape {
 public:
  virtual ~Shape() = default;

  /// Directions in named axes are wanted as map() times them.
  const Matrix3& map() const { return map_; }

  /// Brightness (m2: a surface that scatters all, times the law) and lit and seen area (m2) at unit directions, mapped.
  virtual void shine(std::size_t count, const brightness::Directions& mapped, const ScatteringLaw& law,
                     const brightness::Results& out) const = 0;

  /// The brightness at phase 0, mean of all directions: what the absolute magnitude H belongs to.
  virtual double mean_at_opposition_m2(const ScatteringLaw& law) const = 0;

  /// Whether it throws light on like a mirror somewhere, which is seen for a moment only.
  virtual bool has_mirrors(const ScatteringLaw& /*law*/) const { return false; }

  /// Of a ball about the origin of the named axes, or about its middle where its origin does not matter, that holds it.
  double radius_m() const { return radius_m_; }

  /// What it is and how it is computed, for people.
  virtual std::string description() const = 0;

  /// Of one pair of directions in named axes, of any length but 0.
  struct Light {
    double brightness_m2, area_m2;
  };
  Light light(const Vector3& observer_named, const Vector3& sun_named, const ScatteringLaw& law) const;

 protected:
  Shape() = default;
  Matrix3 map_ = Matrix3::Identity();
  double radius_m_ = 0.0;
};

/// An ellipsoid with these semi-axes along the named x, y and z. The area, and the brightness by Lommel and Seeliger's
/// law, are closed forms (Ostro & Connelly 1984, Icarus 57, 443; Muinonen & Lumme 2015, A&A 584, A23); Lambert's law is
/// integrated by Gauss's quadrature with 24 x 24 points over what is lit and seen: within 1e-9 for axes up to 3 : 1.
/// Nothing of it is a mirror. Throws InputError for semi-axes outside 1e-6 to 1e12 m.
std::shared_ptr<const Shape> ellipsoid_shape(const Vector3& semi_axes_m);

/// How the facets of one surface shine, which a mesh gives a name.
struct SurfaceShine {
  double diffuse = 1.0;            ///< the part of what the law sends
  std::optional<double> specular;  ///< that it throws on like a mirror; ScatteringLaw's if none
  bool two_sided = false;          ///< thin plates, whose back is like the front
};

/// The solid that a mesh bounds, coordinates times `unit_m`; its origin does not matter. Facets are flat and shine as
/// the law says, which for a convex mesh is exact. Where other facets stand above the plane of one, this is cut into
/// four like triangles, and each is lit or seen if a ray from its middle to the Sun or the observer meets no facet
/// (tested by a tree of boxes). `surfaces` are those of the mesh's names that shine otherwise than the rest; with
/// them the mesh may have plates, and need not bound a solid. Throws InputError as mass_properties() where it must, for
/// no facets, corners that are not there or not finite, a name that the mesh does not have, and parts outside 0 to 1 or
/// that are more than 1 together.
std::shared_ptr<const Shape> mesh_shape(const TriangleMesh& mesh, double unit_m,
                                        const std::map<std::string, SurfaceShine, std::less<>>& surfaces = {});

}  // namespace polhode
