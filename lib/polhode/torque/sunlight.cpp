#include "polhode/torque/sunlight.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

constexpr double kSolarConstant_w_m2 = 1361.0;  // total solar irradiance at 1 au, IAU 2015 resolution B3
constexpr double kAstronomicalUnit_m = 149597870700.0;
constexpr double kLightSpeed_m_s = 299792458.0;

}  // namespace

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
  std::vector<Facet> facets;
  facets.reserve(mesh.facets.size());
  for (const auto& corners : mesh.facets) {
    if (std::max({corners[0], corners[1], corners[2]}) >= mesh.vertices.size()) {
      throw InputError(fmt::format("facet {} has the corners {}, {}, {}, the mesh has {} (counted from 0)",
                                   facets.size() + 1, corners[0], corners[1], corners[2], mesh.vertices.size()));
    }
    const Vector3 &a = mesh.vertices[corners[0]], &b = mesh.vertices[corners[1]], &c = mesh.vertices[corners[2]];
    facets.push_back({0.5 * (b - a).cross(c - a), (a + b + c) / 3.0});
    largest_moment_m3_ += facets.back().area_m2.norm() * facets.back().centre_m.norm();
  }
  facets_ = std::make_shared<const std::vector<Facet>>(std::move(facets));
}

Sunlight Sunlight::turned(const Matrix3& to_from) const {
  std::vector<Facet> facets = *facets_;
  for (Facet& facet : facets) facet = {to_from * facet.area_m2, to_from * facet.centre_m};
  Sunlight other = *this;
  other.facets_ = std::make_shared<const std::vector<Facet>>(std::move(facets));
  return other;
}

Vector3 Sunlight::torque(const Vector3& to_sun_body_m) const {
  const double r2 = to_sun_body_m.squaredNorm();
  const Vector3 s = to_sun_body_m / std::sqrt(r2);
  Vector3 sum = Vector3::Zero();
  for (const Facet& facet : *facets_) {
    const double lit_m2 = facet.area_m2.dot(s);
    if (!(lit_m2 > 0.0)) continue;
    const double area_m2 = facet.area_m2.norm(), cosine = lit_m2 / area_m2;
    const Vector3 n = facet.area_m2 / area_m2;
    sum -= lit_m2 * facet.centre_m.cross((1.0 - surface_.specular) * s +
                                         (2.0 * surface_.specular * cosine + 2.0 / 3.0 * surface_.diffuse) * n);
  }
  return kSolarConstant_w_m2 / kLightSpeed_m_s * (kAstronomicalUnit_m * kAstronomicalUnit_m / r2) * sum;
}

double Sunlight::largest(double t_s, const Vector3& /*moments*/, double /*momentum*/) const {
  const double r2 = trajectory.state(t_s).position_m.squaredNorm();
  // The push of a facet is at most twice that of the light on it.
  return 2.0 * kSolarConstant_w_m2 / kLightSpeed_m_s * (kAstronomicalUnit_m * kAstronomicalUnit_m / r2) *
         largest_moment_m3_;
}

}  // namespace polhode
