#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polhode/body/mesh_inertia.hpp"
#include "polhode/torque/facet_table.hpp"
#include "polhode/torque/terms.hpp"

namespace polhode {

/// How a facet sends back a stream that falls on it at a cosine c > 0 from direction s; n is its outward normal:
///
///     force = -(pressure) (area) c (along s + (square c + linear) n)
struct Rebound {
  double along = 1.0, square = 0.0, linear = 0.0;
};

/// A flat part of a body's surface: one side of it.
struct Facet {
  Vector3 area_m2;   ///< along the outward normal, as long as the area is large
  Vector3 centre_m;  ///< from the centre of mass
  Rebound rebound;
};

/// That of a thin plate.
inline Facet other_side(const Facet& side) { return {-side.area_m2, side.centre_m, side.rebound}; }

/// The facets of a mesh, all alike. Corners in metres from the centre of mass, in body axes. Throws InputError for a
/// mesh without facets, a corner that is not finite, an index without corner. Facets without area are left out.
std::vector<Facet> facets_of(const TriangleMesh& mesh, const Rebound& rebound);
/// The same of one of its facets.
Facet facet_of(const TriangleMesh& mesh, std::size_t facet, const Rebound& rebound);

/// The torque of a stream on facets, that do not shade each other.
class Facets {
 public:
  /// Facets with the same normal within 1e-12 are taken together. Throws InputError where there is none, or a number is
  /// not finite.
  explicit Facets(const std::vector<Facet>& facets);

  Facets turned(const Matrix3& to_from) const;

  /// As given. Throws InputError for what turned() made, which has none.
  const std::vector<Facet>& given() const;

  /// m^3, per unit of pressure; s is the unit vector to where the stream comes from, body axes.
  Vector3 torque_m3(const Vector3& s) const;
  /// From above.
  double largest_m3() const { return largest_m3_; }
  std::size_t normals() const;

  /// The edges (Torques::streams()), if the normals are few. Facets back to back have one together.
  static constexpr std::size_t kMostEdges = 40;
  bool has_edges() const { return normals() <= kMostEdges; }
  std::span<const FacetNormal> edges() const;

  double cost_of_evaluation() const { return with_table_ ? 0.4 : static_cast<double>(normals()) / 50.0; }
  /// The same by a table of the direction, which is made when it is first asked for and shared by all copies.
  Facets with_table() const;
  bool has_table() const { return with_table_; }
  /// After how many evaluations the table has paid for itself; infinite if the normals are as few as those of a box.
  double evaluations_for_table() const;

 private:
  struct Shared;
  std::shared_ptr<const Shared> shared_;
  std::shared_ptr<const std::vector<Facet>> given_;  // null if turned
  bool with_table_ = false;
  double largest_m3_ = 0.0;
};

}  // namespace polhode
