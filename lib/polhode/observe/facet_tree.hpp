#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/mesh_inertia.hpp"

namespace polhode {

/// The facets of a mesh in a tree of boxes, to find those that a ray meets.
class FacetTree {
 public:
  explicit FacetTree(const TriangleMesh& mesh);

  /// Whether a ray from `origin` (which it leaves out) meets a facet other than `itself`.
  bool is_met(const Vector3& origin, const Vector3& direction, std::uint32_t itself) const;

  /// Whether a corner lies farther than `margin` above the plane of n.x = height; n of length 1.
  bool reaches_above(const Vector3& normal, double height, double margin) const;

 private:
  struct Box {
    Vector3 low, high;
    std::uint32_t first = 0, count = 0;  // facets in order_ of a leaf; of another its second child, and 0
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t count);

  std::vector<std::array<Vector3, 3>> facets_;
  std::vector<std::uint32_t> order_;
  std::vector<Box> boxes_;
};

}  // namespace polhode
