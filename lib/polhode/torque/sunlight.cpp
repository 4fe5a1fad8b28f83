#include "polhode/torque/sunlight.hpp"

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

constexpr double kSolarConstant_w_m2 = 1361.0;  // total solar irradiance at 1 au, IAU 2015 resolution B3
constexpr double kAstronomicalUnit_m = 149597870700.0;
constexpr double kLightSpeed_m_s = 299792458.0;

/// Of sunlight, by the square of the distance in m.
double pressure_pa(double r2) {
  return kSolarConstant_w_m2 / kLightSpeed_m_s * (kAstronomicalUnit_m * kAstronomicalUnit_m / r2);
}

constexpr double kNormalsPerUnit = 0x1p40;  // normals that agree so far are one

}  // namespace

struct Sunlight::Facets {
  Facets(std::vector<SunlitNormal> all, Surface surface)
      : normals(std::move(all)), shares{surface.specular, surface.diffuse}, sum(normals, shares) {}

  const SunlightTable& table() const {
    std::call_once(table_is_made, [this] { made_table = std::make_unique<const SunlightTable>(normals, shares); });
    return *made_table;
  }

  std::vector<SunlitNormal> normals;
  SunlightTable::Shares shares;
  SunlitSum sum;
  mutable std::once_flag table_is_made;
  mutable std::unique_ptr<const SunlightTable> made_table;
};

Sunlight::Sunlight(const TriangleMesh& mesh, Surface surface, Trajectory way)
    : trajectory(std::move(way)), surface_(surface) {
  if (!(surface.specular >= 0.0 && surface.diffuse >= 0.0 && surface.specular + surface.diffuse <= 1.0)) {
    throw InputError(
        fmt::format("the surface reflects {} specular and {} diffuse, shares from 0 to 1 together are wanted",
                    surface.specular, surface.diffuse));
  }
  if (mesh.facets.empty()) throw InputError("the mesh has no facets");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) throw InputError(fmt::format("corner {} of the mesh is not finite", i + 1));
  }
  std::vector<SunlitNormal> normals;
  std::map<std::array<std::int64_t, 3>, std::size_t> place;
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    const auto& corners = mesh.facets[i];
    if (std::max({corners[0], corners[1], corners[2]}) >= mesh.vertices.size()) {
      throw InputError(fmt::format("facet {} has the corners {}, {}, {}, the mesh has {} (counted from 0)", i + 1,
                                   corners[0], corners[1], corners[2], mesh.vertices.size()));
    }
    const Vector3 &a = mesh.vertices[corners[0]], &b = mesh.vertices[corners[1]], &c = mesh.vertices[corners[2]];
    const Vector3 area_m2 = 0.5 * (b - a).cross(c - a), centre_m = (a + b + c) / 3.0;
    const double size_m2 = area_m2.norm();
    if (!(size_m2 > 0.0)) continue;
    const Vector3 normal = area_m2 / size_m2;
    std::array<std::int64_t, 3> key{};
    for (int k = 0; k < 3; ++k) key[static_cast<std::size_t>(k)] = std::llround(normal[k] * kNormalsPerUnit);
    const auto [at, is_new] = place.emplace(key, normals.size());
    if (is_new) normals.push_back({normal, Vector3::Zero(), Vector3::Zero()});
    normals[at->second].moment_m3 += size_m2 * centre_m;
    largest_moment_m3_ += size_m2 * centre_m.norm();
  }
  for (SunlitNormal& one : normals) one.normal_moment_m3 = one.moment_m3.cross(one.normal);
  facets_ = std::make_shared<const Facets>(std::move(normals), surface);
}

std::size_t Sunlight::normals() const { return facets_->normals.size(); }

Sunlight Sunlight::turned(const Matrix3& to_from) const {
  std::vector<SunlitNormal> normals = facets_->normals;
  for (SunlitNormal& one : normals) {
    one = {to_from * one.normal, to_from * one.moment_m3, to_from * one.normal_moment_m3};
  }
  Sunlight other = *this;
  other.facets_ = std::make_shared<const Facets>(std::move(normals), surface_);
  other.with_table_ = false;
  return other;
}

Sunlight Sunlight::with_table() const {
  Sunlight other = *this;
  other.with_table_ = true;
  facets_->table();
  return other;
}

double Sunlight::evaluations_for_table() const {
  if (has_edges() || with_table_) return std::numeric_limits<double>::infinity();
  return SunlightTable::cost(normals());
}

Vector3 Sunlight::torque(const Vector3& to_sun_body_m) const {
  const double r2 = to_sun_body_m.squaredNorm();
  const Vector3 s = to_sun_body_m / std::sqrt(r2);
  return strength_ * pressure_pa(r2) * (with_table_ ? facets_->table().torque_m3(s) : facets_->sum.torque_m3(s));
}

void Sunlight::add_edges(const TorquePlace<double>& place, std::vector<TorqueEdge>& edges) const {
  if (place.orbit == nullptr || !has_edges()) return;
  const Vector3 to_sun = -place.to_body(place.orbit->position_m);
  const double r2 = to_sun.squaredNorm(), pressure = strength_ * pressure_pa(r2);
  const Vector3 s = to_sun / std::sqrt(r2);
  for (const SunlitNormal& one : facets_->normals) {
    const double cosine = one.normal.dot(s);
    const double along_normal = 2.0 * surface_.specular * cosine + 2.0 / 3.0 * surface_.diffuse;
    edges.push_back({cosine, -pressure * ((1.0 - surface_.specular) * one.moment_m3.cross(s) +
                                          along_normal * one.normal_moment_m3)});
  }
}

double Sunlight::largest(double t_s, const Vector3& /*moments*/, double /*momentum*/) const {
  const double r2 = trajectory.state(t_s).position_m.squaredNorm();
  // The push of a facet is at most twice that of the light on it.
  return 2.0 * std::abs(strength_) * pressure_pa(r2) * largest_moment_m3_;
}

}  // namespace polhode
