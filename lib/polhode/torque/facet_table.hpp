#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "polhode/base/geometry.hpp"

namespace polhode {

/// Facets with the same normal, as a stream sees them that pushes them: sunlight, or thin air. Where the direction s
/// that the stream comes from is at a cosine c = n . s > 0, they feel per unit of pressure
///
///     torque = -c (along x s + c square + linear)
struct FacetNormal {
  Vector3 normal;
  Vector3 along_m3 = Vector3::Zero();   ///< sum of (share x area) times centre
  Vector3 square_m3 = Vector3::Zero();  ///< such a sum, x normal
  Vector3 linear_m3 = Vector3::Zero();  ///< and another
};

/// The torque of a stream per unit of its pressure by its direction in the body, for bodies of many facets.
///
/// The directions are the cells of a cube's faces (gnomonic, 6 N^2 of them). Where all of a cell sees a facet lit or
/// none of it does, the facet's torque is a polynomial of degree 2 in the direction, so that the sum of all of these is
/// one, kept by its 27 coefficients; the facets that turn edge-on somewhere in the cell, about 1.2/N of all, are summed
/// one by one. Nothing is interpolated: the table gives the sum over the facets, kinks included, to the rounding of its
/// coefficients.
class FacetTable {
 public:
  static constexpr std::size_t kMostBytes = 48u << 20;  ///< of the table: what limits N

  explicit FacetTable(const std::vector<FacetNormal>& normals);

  /// m^3; s is the unit vector to where the stream comes from.
  Vector3 torque_m3(const Vector3& s) const;

  /// The table may be off by this much, m^3: 16 roundings (2^-52) of the sum of the lengths of all vectors. Found: at
  /// most 1, for 10 to 20000 normals, in random directions, edge-on to a facet within 1e-15 to 1e-6, and at corners of
  /// cells (tests/unit/facets_test.cpp).
  double largest_error_m3() const { return largest_error_m3_; }

  /// What making it costs, in sums over all facets, roughly.
  static double cost(std::size_t normals);
  /// Cells along the edge of a face, for so many normals.
  static std::size_t cells_along(std::size_t normals);

 private:
  struct Cell {
    std::array<double, 27> coefficients{};  // 9 for each component: of x, y, z, xx, yy, zz, xy, yz, zx
    std::uint32_t first = 0, end = 0;       // of edge_on_
  };
  class Maker;

  std::vector<FacetNormal> normals_;
  std::size_t along_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> edge_on_;
  double largest_error_m3_ = 0.0;
};

/// The sum over all normals, in fours.
class FacetSum {
 public:
  FacetSum() = default;
  explicit FacetSum(const std::vector<FacetNormal>& normals);
  Vector3 torque_m3(const Vector3& s) const;

 private:
  struct Four {
    Eigen::Array4d normal[3], along_m3[3], square_m3[3], linear_m3[3];  // component by component
  };
  std::vector<Four> fours_;
};

}  // namespace polhode
