#include "polhode/observe/facet_tree.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace polhode {
namespace {

constexpr std::uint32_t kLeafFacets = 4;
constexpr std::size_t kDeepest = 128;  // halving by count: no tree is deeper than 32

bool is_box_met(const Vector3& low, const Vector3& high, const Vector3& origin, const Vector3& inverse) {
  double from = 0.0, to = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double a = (low[k] - origin[k]) * inverse[k], b = (high[k] - origin[k]) * inverse[k];
    from = std::max(from, std::min(a, b));  // a NaN, of a ray within a face, leaves it as it is
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

/// Moeller and Trumbore's test.
bool is_facet_met(const std::array<Vector3, 3>& facet, const Vector3& origin, const Vector3& direction) {
  const Vector3 a = facet[1] - facet[0], b = facet[2] - facet[0];
  const Vector3 p = direction.cross(b);
  const double determinant = a.dot(p);
  if (determinant == 0.0) return false;
  const Vector3 t = origin - facet[0];
  const double u = t.dot(p) / determinant;
  if (!(u >= 0.0 && u <= 1.0)) return false;
  const Vector3 q = t.cross(a);
  const double v = direction.dot(q) / determinant;
  return v >= 0.0 && u + v <= 1.0 && b.dot(q) / determinant > 0.0;
}

}  // namespace

FacetTree::FacetTree(const TriangleMesh& mesh) {
  for (const auto& corners : mesh.facets) {
    facets_.push_back({mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]]});
  }
  order_.resize(facets_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  build(0, static_cast<std::uint32_t>(order_.size()));
}

std::uint32_t FacetTree::build(std::uint32_t first, std::uint32_t count) {
  const auto index = static_cast<std::uint32_t>(boxes_.size());
  Box box;
  box.low = Vector3::Constant(std::numeric_limits<double>::infinity());
  box.high = -box.low;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const Vector3& corner : facets_[order_[i]]) {
      box.low = box.low.cwiseMin(corner);
      box.high = box.high.cwiseMax(corner);
    }
  }
  boxes_.push_back(box);
  if (count <= kLeafFacets) {
    boxes_[index].first = first;
    boxes_[index].count = count;
    return index;
  }
  Eigen::Index longest = 0;
  (box.high - box.low).maxCoeff(&longest);
  const auto middle = [&](std::uint32_t facet) {
    const auto& corners = facets_[facet];
    return corners[0][longest] + corners[1][longest] + corners[2][longest];
  };
  const std::uint32_t half = count / 2;
  std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                   [&](std::uint32_t a, std::uint32_t b) { return middle(a) < middle(b); });
  build(first, half);  // comes next in boxes_
  const std::uint32_t second = build(first + half, count - half);
  boxes_[index].first = second;
  return index;
}

bool FacetTree::is_met(const Vector3& origin, const Vector3& direction, std::uint32_t itself) const {
  const Vector3 inverse = direction.cwiseInverse();
  std::array<std::uint32_t, kDeepest> ahead{};
  std::size_t depth = 1;
  while (depth > 0) {
    const std::uint32_t index = ahead[--depth];
    const Box& box = boxes_[index];
    if (!is_box_met(box.low, box.high, origin, inverse)) continue;
    if (box.count == 0) {
      ahead[depth++] = box.first;
      ahead[depth++] = index + 1;
      continue;
    }
    for (std::uint32_t i = box.first; i < box.first + box.count; ++i) {
      if (order_[i] != itself && is_facet_met(facets_[order_[i]], origin, direction)) return true;
    }
  }
  return false;
}

bool FacetTree::reaches_above(const Vector3& normal, double height, double margin) const {
  std::array<std::uint32_t, kDeepest> ahead{};
  std::size_t depth = 1;
  while (depth > 0) {
    const std::uint32_t index = ahead[--depth];
    const Box& box = boxes_[index];
    const Vector3 farthest = (normal.array() > 0.0).select(box.high, box.low);
    if (!(normal.dot(farthest) - height > margin)) continue;
    if (box.count == 0) {
      ahead[depth++] = box.first;
      ahead[depth++] = index + 1;
      continue;
    }
    for (std::uint32_t i = box.first; i < box.first + box.count; ++i) {
      for (const Vector3& corner : facets_[order_[i]]) {
        if (normal.dot(corner) - height > margin) return true;
      }
    }
  }
  return false;
}

}  // namespace polhode
