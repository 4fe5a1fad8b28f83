#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/observe/facet_tree.hpp"
#include "polhode/observe/shape.hpp"

namespace polhode {
namespace {

/// Facets that nothing hides, as the kernels want them.
struct OpenFacets {
  std::array<std::vector<double>, 3> normal;
  std::vector<double> inverse_area;

  void add(const Vector3& area_vector) {
    for (std::size_t k = 0; k < 3; ++k) normal[k].push_back(area_vector[static_cast<Eigen::Index>(k)]);
    inverse_area.push_back(1.0 / area_vector.norm());
  }
  void pad() {
    constexpr std::size_t most_lanes = 8;
    const std::size_t size = (inverse_area.size() + most_lanes - 1) / most_lanes * most_lanes;
    for (auto& component : normal) component.resize(size, 0.0);
    inverse_area.resize(size, 0.0);
  }
  brightness::FacetArrays arrays() const {
    return {{normal[0].data(), normal[1].data(), normal[2].data()}, inverse_area.data(), inverse_area.size()};
  }
};

/// A facet over whose plane others stand.
struct HiddenFacet {
  std::uint32_t index;
  double area;
  Vector3 normal;
  std::array<Vector3, 4> middles;  // of its quarters
};

class MeshSurface final : public Shape {
 public:
  MeshSurface(const TriangleMesh& mesh, const MassProperties& solid, double unit_m)
      : mesh_(mesh), tree_(scale(mesh_, unit_m)) {
    double size = 0.0;
    for (const Vector3& vertex : mesh_.vertices) size = std::max(size, (vertex - mesh_.vertices[0]).norm());
    const double margin = 1e-9 * size;
    Eigen::AlignedBox3d box;
    for (const Vector3& vertex : mesh_.vertices) box.extend(vertex);
    radius_m_ = 0.5 * box.diagonal().norm();
    for (std::uint32_t i = 0; i < mesh_.facets.size(); ++i) {
      const auto& corners = mesh_.facets[i];
      const Vector3 &a = mesh_.vertices[corners[0]], &b = mesh_.vertices[corners[1]], &c = mesh_.vertices[corners[2]];
      const Vector3 area_vector = 0.5 * (b - a).cross(c - a);
      const double area = area_vector.norm();
      if (!(area > 0.0)) continue;
      surface_m2_ += area;
      const Vector3 normal = area_vector / area;
      if (!tree_.reaches_above(normal, normal.dot(a), margin)) {
        open_.add(area_vector);
        continue;
      }
      const Vector3 middle = (a + b + c) / 3.0;
      hidden_.push_back({i, area, normal, {middle, 0.5 * (middle + a), 0.5 * (middle + b), 0.5 * (middle + c)}});
    }
    open_.pad();
    facets_ = solid.facets;
    convex_ = hidden_.empty() && solid.shells == 1;
  }

  void shine(std::size_t count, const brightness::Directions& mapped, const ScatteringLaw& law,
             const brightness::Results& out) const override {
    brightness::best_kernels().facets(count, mapped, open_.arrays(), {law.lommel_seeliger, law.lambert}, out);
    if (law.specular != 0.0) add_glints(count, mapped, law.specular, out.brightness);
    if (hidden_.empty()) return;
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 observer(mapped.observer[0][i], mapped.observer[1][i], mapped.observer[2][i]);
      const Vector3 sun(mapped.sun[0][i], mapped.sun[1][i], mapped.sun[2][i]);
      const bool together = (observer - sun).squaredNorm() < 1e-20;
      for (const HiddenFacet& facet : hidden_) {
        const double mu = facet.normal.dot(observer), mu0 = facet.normal.dot(sun);
        if (!(mu > 0.0 && mu0 > 0.0)) continue;
        int free = 0;
        for (const Vector3& middle : facet.middles) {
          free += int(is_open(middle, facet.index, observer, sun, together));
        }
        const double area = 0.25 * free * facet.area;
        out.area[i] += area * mu;
        if (law.specular != 0.0 && is_mirror(facet.normal, observer, sun)) {
          out.brightness[i] += law.specular * area * mu / kSunSine2;
        }
        out.brightness[i] += law.lommel_seeliger == 0.0 && law.lambert == 0.0
                                 ? area * mu
                                 : area * mu * mu0 * (law.lommel_seeliger / (mu + mu0) + law.lambert);
      }
    }
  }

  double mean_at_opposition_m2(const ScatteringLaw& law) const override {
    const bool area_alone = law.lommel_seeliger == 0.0 && law.lambert == 0.0;
    if (convex_) {
      return area_alone ? surface_m2_ / 4.0 : surface_m2_ * (law.lommel_seeliger / 8.0 + law.lambert / 6.0);
    }
    // The mean of directions that are spread evenly: Fibonacci's spiral.
    constexpr int directions = 2000;
    const double step = std::numbers::pi * (3.0 - std::sqrt(5.0));
    double sum = 0.0;
    for (int i = 0; i < directions; ++i) {
      const double z = 1.0 - (2.0 * i + 1.0) / directions, across = std::sqrt(1.0 - z * z);
      const Vector3 to(across * std::cos(i * step), across * std::sin(i * step), z);
      sum += light(to, to, law).brightness_m2;
    }
    return sum / directions;
  }

  std::string description() const override {
    return convex_ ? fmt::format("a convex mesh of {} facets", facets_)
                   : fmt::format("a mesh of {} facets, {} of which others may hide or shade (by rays)", facets_,
                                 hidden_.size());
  }

 private:
  static inline const double kSunSine2 = std::pow(std::sin(kSunRadius_rad), 2);

  /// Whether a mirror with this normal shows the observer some of the Sun's disc.
  static bool is_mirror(const Vector3& normal, const Vector3& observer, const Vector3& sun) {
    const Vector3 thrown = 2.0 * normal.dot(sun) * normal - sun;
    return (thrown - observer).norm() <= 2.0 * std::sin(0.5 * kSunRadius_rad);
  }

  bool is_open(const Vector3& place, std::uint32_t facet, const Vector3& observer, const Vector3& sun,
               bool together) const {
    return !tree_.is_met(place, observer, facet) && (together || !tree_.is_met(place, sun, facet));
  }

  /// Of the facets that nothing hides.
  void add_glints(std::size_t count, const brightness::Directions& mapped, double specular, double* brightness) const {
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 observer(mapped.observer[0][i], mapped.observer[1][i], mapped.observer[2][i]);
      const Vector3 sun(mapped.sun[0][i], mapped.sun[1][i], mapped.sun[2][i]);
      for (std::size_t f = 0; f < open_.inverse_area.size(); ++f) {
        const Vector3 area_vector(open_.normal[0][f], open_.normal[1][f], open_.normal[2][f]);
        const double seen = area_vector.dot(observer);
        if (!(seen > 0.0 && area_vector.dot(sun) > 0.0)) continue;
        if (is_mirror(open_.inverse_area[f] * area_vector, observer, sun)) brightness[i] += specular * seen / kSunSine2;
      }
    }
  }

  static const TriangleMesh& scale(TriangleMesh& mesh, double unit_m) {
    for (Vector3& vertex : mesh.vertices) vertex *= unit_m;
    return mesh;
  }

  TriangleMesh mesh_;
  FacetTree tree_;
  OpenFacets open_;
  std::vector<HiddenFacet> hidden_;
  double surface_m2_ = 0.0;
  std::size_t facets_ = 0;
  bool convex_ = true;
};

}  // namespace

std::shared_ptr<const Shape> mesh_shape(const TriangleMesh& mesh, double unit_m) {
  if (!(unit_m > 0.0 && std::isfinite(unit_m))) {
    throw InputError(fmt::format("the mesh's unit is {} m; a positive number is wanted", unit_m));
  }
  const MassProperties solid = mass_properties(mesh);  // refuses what bounds no solid
  return std::make_shared<const MeshSurface>(mesh, solid, unit_m);
}

}  // namespace polhode
