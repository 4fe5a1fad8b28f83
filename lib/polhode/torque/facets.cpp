#include "polhode/torque/facets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

constexpr std::size_t kFewNormals = 12;     // quicker summed than looked up
constexpr double kNormalsPerUnit = 0x1p40;  // normals that agree so far are one

/// A normal's back is lit where it is not: max(-c, 0) = max(c, 0) - c, so that the kinks of both are those of one.
std::vector<FacetNormal> edges_of(const std::vector<FacetNormal>& normals) {
  std::vector<FacetNormal> edges;
  if (normals.size() > Facets::kMostEdges) return edges;
  for (const FacetNormal& one : normals) {
    const auto back = std::find_if(edges.begin(), edges.end(), [&](const FacetNormal& other) {
      return (other.normal + one.normal).squaredNorm() < 1e-30;
    });
    if (back == edges.end()) {
      edges.push_back(one);
    } else {
      back->along_m3 += one.along_m3;
      back->square_m3 -= one.square_m3;
      back->linear_m3 += one.linear_m3;
    }
  }
  return edges;
}

}  // namespace

Facet facet_of(const TriangleMesh& mesh, std::size_t facet, const Rebound& rebound) {
  const auto& corners = mesh.facets[facet];
  if (std::max({corners[0], corners[1], corners[2]}) >= mesh.vertices.size()) {
    throw InputError(fmt::format("facet {} has the corners {}, {}, {}, the mesh has {} (counted from 0)", facet + 1,
                                 corners[0], corners[1], corners[2], mesh.vertices.size()));
  }
  for (const std::uint32_t corner : corners) {
    if (!mesh.vertices[corner].allFinite())
      throw InputError(fmt::format("corner {} of the mesh is not finite", corner + 1));
  }
  const Vector3 &a = mesh.vertices[corners[0]], &b = mesh.vertices[corners[1]], &c = mesh.vertices[corners[2]];
  return {0.5 * (b - a).cross(c - a), (a + b + c) / 3.0, rebound};
}

std::vector<Facet> facets_of(const TriangleMesh& mesh, const Rebound& rebound) {
  if (mesh.facets.empty()) throw InputError("the mesh has no facets");
  std::vector<Facet> facets;
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) facets.push_back(facet_of(mesh, i, rebound));
  return facets;
}

struct Facets::Shared {
  explicit Shared(std::vector<FacetNormal> all) : normals(std::move(all)), edges(edges_of(normals)), sum(normals) {}

  const FacetTable& table() const {
    std::call_once(table_is_made, [this] { made_table = std::make_unique<const FacetTable>(normals); });
    return *made_table;
  }

  std::vector<FacetNormal> normals, edges;
  FacetSum sum;
  mutable std::once_flag table_is_made;
  mutable std::unique_ptr<const FacetTable> made_table;
};

Facets::Facets(const std::vector<Facet>& facets) {
  std::vector<FacetNormal> normals;
  std::map<std::array<std::int64_t, 3>, std::size_t> place;
  for (const Facet& facet : facets) {
    const auto& [along, square, linear] = facet.rebound;
    check_finite("the area of a facet", facet.area_m2);
    check_finite("the place of a facet", facet.centre_m);
    check_finite("what a facet sends back", Vector3(along, square, linear));
    const double area_m2 = facet.area_m2.norm();
    if (!(area_m2 > 0.0)) continue;
    const Vector3 normal = facet.area_m2 / area_m2, moment_m3 = area_m2 * facet.centre_m;
    std::array<std::int64_t, 3> key{};
    for (int k = 0; k < 3; ++k) key[static_cast<std::size_t>(k)] = std::llround(normal[k] * kNormalsPerUnit);
    const auto [at, is_new] = place.emplace(key, normals.size());
    if (is_new) normals.push_back({normal});
    FacetNormal& one = normals[at->second];
    one.along_m3 += along * moment_m3;
    one.square_m3 += square * moment_m3;  // not yet across the normal
    one.linear_m3 += linear * moment_m3;
    largest_m3_ += moment_m3.norm() * (std::abs(along) + std::abs(square) + std::abs(linear));
  }
  if (normals.empty()) throw InputError("there are no facets with an area");
  for (FacetNormal& one : normals) {
    one.square_m3 = one.square_m3.cross(one.normal).eval();
    one.linear_m3 = one.linear_m3.cross(one.normal).eval();
  }
  shared_ = std::make_shared<const Shared>(std::move(normals));
  given_ = std::make_shared<const std::vector<Facet>>(facets);
}

const std::vector<Facet>& Facets::given() const {
  if (given_ == nullptr) throw InputError("facets that were turned are not those that were given");
  return *given_;
}

std::size_t Facets::normals() const { return shared_->normals.size(); }

Facets Facets::turned(const Matrix3& to_from) const {
  std::vector<FacetNormal> normals = shared_->normals;
  for (FacetNormal& one : normals) {
    one = {to_from * one.normal, to_from * one.along_m3, to_from * one.square_m3, to_from * one.linear_m3};
  }
  Facets other = *this;
  other.shared_ = std::make_shared<const Shared>(std::move(normals));
  other.given_ = nullptr;
  other.with_table_ = false;
  return other;
}

Facets Facets::with_table() const {
  Facets other = *this;
  other.with_table_ = true;
  shared_->table();
  return other;
}

double Facets::evaluations_for_table() const {
  if (normals() <= kFewNormals || with_table_) return std::numeric_limits<double>::infinity();
  return FacetTable::cost(normals());
}

Vector3 Facets::torque_m3(const Vector3& s) const {
  return with_table_ ? shared_->table().torque_m3(s) : shared_->sum.torque_m3(s);
}

std::span<const FacetNormal> Facets::edges() const { return shared_->edges; }

}  // namespace polhode
