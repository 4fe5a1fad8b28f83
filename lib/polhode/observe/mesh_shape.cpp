#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string>

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

/// The facets of one surface.
struct Surface {
  SurfaceShine shine;
  OpenFacets open;
};

/// A facet over whose plane others stand.
struct HiddenFacet {
  std::uint32_t index;
  std::size_t surface;
  double area;
  Vector3 normal;
  std::array<Vector3, 4> middles;  // of its quarters
};

class MeshSurface final : public Shape {
 public:
  MeshSurface(const TriangleMesh& mesh, const std::optional<MassProperties>& solid, double unit_m,
              const std::map<std::string, SurfaceShine, std::less<>>& shines)
      : mesh_(mesh), tree_(scale(mesh_, unit_m)), surfaces_(1) {
    std::vector<std::size_t> surface_of_name(mesh_.surface_names.size(), 0);  // the first: all of which nothing is said
    for (std::size_t name = 0; name < surface_of_name.size(); ++name) {
      const auto said = shines.find(mesh_.surface_names[name]);
      if (said == shines.end()) continue;
      surface_of_name[name] = surfaces_.size();
      surfaces_.push_back({said->second, {}});
    }
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
      const std::size_t place = mesh_.surface_names.empty() ? 0 : surface_of_name[mesh_.surface_of_facet[i]];
      Surface& surface = surfaces_[place];
      const Vector3 middle = (a + b + c) / 3.0;
      for (const double side : {1.0, -1.0}) {
        if (side < 0.0 && !surface.shine.two_sided) continue;
        diffuse_m2_ += surface.shine.diffuse * area;
        const Vector3 normal = side / area * area_vector;
        if (!tree_.reaches_above(normal, normal.dot(a), margin)) {
          surface.open.add(side * area_vector);
          continue;
        }
        hidden_.push_back(
            {i, place, area, normal, {middle, 0.5 * (middle + a), 0.5 * (middle + b), 0.5 * (middle + c)}});
      }
    }
    for (Surface& surface : surfaces_) surface.open.pad();
    facets_ = solid ? solid->facets : mesh_.facets.size();
    convex_ = hidden_.empty() && solid && solid->shells == 1;
  }

  void shine(std::size_t count, const brightness::Directions& mapped, const ScatteringLaw& law,
             const brightness::Results& out) const override {
    const brightness::LawWeights diffuse{law.lommel_seeliger, law.lambert};
    brightness::best_kernels().facets(count, mapped, surfaces_[0].open.arrays(), diffuse, out);
    if (surfaces_.size() > 1) {
      std::vector<double> light(count), area(count);
      for (std::size_t surface = 1; surface < surfaces_.size(); ++surface) {
        brightness::best_kernels().facets(count, mapped, surfaces_[surface].open.arrays(), diffuse,
                                          {light.data(), area.data()});
        for (std::size_t i = 0; i < count; ++i) {
          out.brightness[i] += surfaces_[surface].shine.diffuse * light[i];
          out.area[i] += area[i];
        }
      }
    }
    for (const Surface& surface : surfaces_) {
      const double specular = surface.shine.specular.value_or(law.specular);
      if (specular != 0.0) add_glints(count, mapped, surface.open, specular, out.brightness);
    }
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
        const SurfaceShine& shine = surfaces_[facet.surface].shine;
        const double specular = shine.specular.value_or(law.specular);
        if (specular != 0.0 && is_mirror(facet.normal, observer, sun)) {
          out.brightness[i] += specular * area * mu / kSunSine2;
        }
        out.brightness[i] +=
            shine.diffuse *
            (is_area_alone(law) ? area * mu : area * mu * mu0 * (law.lommel_seeliger / (mu + mu0) + law.lambert));
      }
    }
  }

  double mean_at_opposition_m2(const ScatteringLaw& law) const override {
    if (convex_) {
      return diffuse_m2_ * (is_area_alone(law) ? 1.0 / 4.0 : law.lommel_seeliger / 8.0 + law.lambert / 6.0);
    }
    // The mean of directions that are spread evenly: Fibonacci's spiral. (A mirror would be seen in few of them.)
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

  bool has_mirrors(const ScatteringLaw& law) const override {
    return std::any_of(surfaces_.begin(), surfaces_.end(),
                       [&law](const Surface& surface) { return surface.shine.specular.value_or(law.specular) != 0.0; });
  }

  std::string description() const override {
    return convex_ ? fmt::format("a convex mesh of {} facets", facets_)
                   : fmt::format("a mesh of {} facets, {} of whose sides others may hide or shade (by rays)", facets_,
                                 hidden_.size());
  }

 private:
  static bool is_area_alone(const ScatteringLaw& law) { return law.lommel_seeliger == 0.0 && law.lambert == 0.0; }

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
  static void add_glints(std::size_t count, const brightness::Directions& mapped, const OpenFacets& open,
                         double specular, double* brightness) {
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 observer(mapped.observer[0][i], mapped.observer[1][i], mapped.observer[2][i]);
      const Vector3 sun(mapped.sun[0][i], mapped.sun[1][i], mapped.sun[2][i]);
      for (std::size_t f = 0; f < open.inverse_area.size(); ++f) {
        const Vector3 area_vector(open.normal[0][f], open.normal[1][f], open.normal[2][f]);
        const double seen = area_vector.dot(observer);
        if (!(seen > 0.0 && area_vector.dot(sun) > 0.0)) continue;
        if (is_mirror(open.inverse_area[f] * area_vector, observer, sun)) brightness[i] += specular * seen / kSunSine2;
      }
    }
  }

  static const TriangleMesh& scale(TriangleMesh& mesh, double unit_m) {
    for (Vector3& vertex : mesh.vertices) vertex *= unit_m;
    return mesh;
  }

  TriangleMesh mesh_;
  FacetTree tree_;
  std::vector<Surface> surfaces_;
  std::vector<HiddenFacet> hidden_;
  double diffuse_m2_ = 0.0;  // of the surface, each facet by its part
  std::size_t facets_ = 0;
  bool convex_ = true;
};

}  // namespace

namespace {
void check_facets(const TriangleMesh& mesh) {
  if (mesh.facets.empty()) throw InputError("the mesh has no facets");
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    for (const std::uint32_t corner : mesh.facets[i]) {
      if (corner >= mesh.vertices.size() || !mesh.vertices[corner].allFinite()) {
        throw InputError(fmt::format("facet {} of the mesh has a corner that is not there, or not finite", i + 1));
      }
    }
  }
}

}  // namespace

std::shared_ptr<const Shape> mesh_shape(const TriangleMesh& mesh, double unit_m,
                                        const std::map<std::string, SurfaceShine, std::less<>>& surfaces) {
  if (!(unit_m > 0.0 && std::isfinite(unit_m))) {
    throw InputError(fmt::format("the mesh's unit is {} m; a positive number is wanted", unit_m));
  }
  for (const auto& [name, shine] : surfaces) {
    if (std::find(mesh.surface_names.begin(), mesh.surface_names.end(), name) == mesh.surface_names.end()) {
      throw InputError(
          fmt::format("the mesh has no surface '{:.40}'; it names {}", name,
                      mesh.surface_names.empty() ? "none" : fmt::format("{}", fmt::join(mesh.surface_names, ", "))));
    }
    for (const double part : {shine.diffuse, shine.specular.value_or(0.0)}) {
      if (!(part >= 0.0 && part <= 1.0)) {
        throw InputError(fmt::format("surface '{:.40}': found {}, parts from 0 to 1 are wanted", name, part));
      }
    }
    if (shine.diffuse + shine.specular.value_or(0.0) > 1.0) {
      throw InputError(fmt::format("surface '{:.40}': found {} and {}, more than all light together", name,
                                   shine.diffuse, *shine.specular));
    }
  }
  std::optional<MassProperties> solid;
  try {
    solid = mass_properties(mesh);  // refuses what bounds no solid
  } catch (const InputError&) {
    if (surfaces.empty()) throw;
    check_facets(mesh);
  }
  return std::make_shared<const MeshSurface>(mesh, solid, unit_m, surfaces);
}

}  // namespace polhode
