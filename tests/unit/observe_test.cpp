// What an observer sees: brightness of shapes against closed forms and integrals, shadows, angles on the sky, sights.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/units.hpp"
#include "polhode/observe/aspect.hpp"
#include "polhode/observe/kernel/target.hpp"
#include "polhode/observe/scattering.hpp"
#include "polhode/observe/shape.hpp"
#include "polhode/observe/sight.hpp"
#include "polhode/time/scale.hpp"

namespace {

using namespace polhode;

constexpr double pi = std::numbers::pi;
const std::array<const char*, 4> all_laws{"projected-area", "lambert", "lommel-seeliger", "lommel-seeliger-lambert"};

/// An octahedron whose facets are quartered, its corners put on an ellipsoid.
TriangleMesh ellipsoid_mesh(int times, const Vector3& axes) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.facets = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < times; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, is_new] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return place->second;
    };
    std::vector<std::array<std::uint32_t, 3>> facets;
    for (const auto& [a, b, c] : mesh.facets) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      facets.insert(facets.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.facets = facets;
  }
  for (Vector3& vertex : mesh.vertices) vertex = vertex.cwiseProduct(axes);
  return mesh;
}

void add_box(TriangleMesh& mesh, const Vector3& low, const Vector3& high) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices.emplace_back((corner & 1) != 0 ? high.x() : low.x(), (corner & 2) != 0 ? high.y() : low.y(),
                               (corner & 4) != 0 ? high.z() : low.z());
  }
  constexpr std::array<std::array<std::uint32_t, 3>, 12> facets{{{0, 2, 1},
                                                                 {1, 2, 3},
                                                                 {4, 5, 6},
                                                                 {5, 7, 6},
                                                                 {0, 1, 4},
                                                                 {1, 5, 4},
                                                                 {2, 6, 3},
                                                                 {3, 6, 7},
                                                                 {0, 4, 2},
                                                                 {2, 4, 6},
                                                                 {1, 3, 5},
                                                                 {3, 7, 5}}};
  for (const auto& f : facets) mesh.facets.push_back({first + f[0], first + f[1], first + f[2]});
}

Vector3 random_direction(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  return Vector3(normal(generator), normal(generator), normal(generator)).normalized();
}

TEST(Scattering, ASphereFollowsTheClosedPhaseCurves) {
  const auto sphere = ellipsoid_shape(Vector3::Ones());
  for (const char* name : all_laws) {
    const ScatteringLaw law = scattering_law(name);
    for (const double phase : {0.0, 1e-9, 1e-4, 0.3, 1.0, 1.57, 2.5, 3.0}) {
      const auto light = sphere->light({1, 0, 0}, {std::cos(phase), std::sin(phase), 0}, law);
      EXPECT_NEAR(light.brightness_m2, sphere_brightness(law, phase), 4e-14) << name << " at " << phase;
      EXPECT_NEAR(light.area_m2, pi * std::pow(std::cos(phase / 2), 2), 4e-14);
    }
  }
  // Lambert's and Lommel and Seeliger's as printed: 2/3 (sin a + (pi - a) cos a), pi/2 (1 - sin a/2 tan a/2 ln cot
  // a/4).
  EXPECT_NEAR(sphere_brightness(scattering_law("lambert"), pi / 2), 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(sphere_brightness(scattering_law("lommel-seeliger"), pi / 2),
              pi / 2 * (1.0 - std::sqrt(0.5) * std::log(1.0 / std::tan(pi / 8))), 1e-15);
}

TEST(Scattering, AnEllipsoidIsTheLimitOfItsMeshes) {
  const Vector3 axes(2.3, 1.2, 0.96);
  const auto closed = ellipsoid_shape(axes);
  std::mt19937 generator(7);
  std::vector<std::pair<Vector3, Vector3>> directions;
  for (int i = 0; i < 40; ++i) directions.emplace_back(random_direction(generator), random_direction(generator));
  for (const char* name : all_laws) {
    const ScatteringLaw law = scattering_law(name);
    std::array<double, 2> worst{};
    for (const int level : {0, 1}) {
      const auto mesh = mesh_shape(ellipsoid_mesh(4 + level, axes), 1.0);
      for (const auto& [observer, sun] : directions) {
        const double wanted = closed->light(observer, sun, law).brightness_m2;
        worst[static_cast<std::size_t>(level)] = std::max(
            worst[static_cast<std::size_t>(level)], std::abs(mesh->light(observer, sun, law).brightness_m2 - wanted));
      }
      // The mean at opposition, too.
      EXPECT_NEAR(mesh->mean_at_opposition_m2(law) / closed->mean_at_opposition_m2(law), 1.0, level == 0 ? 4e-3 : 1e-3);
    }
    // By the area a facet at the terminator counts as soon as it is lit; by the others it begins dark.
    EXPECT_LT(worst[0], law.lommel_seeliger + law.lambert > 0.0 ? 0.04 : 0.15) << name;
    EXPECT_LT(worst[1], (law.lommel_seeliger + law.lambert > 0.0 ? 0.4 : 0.7) * worst[0]) << name;
  }
}

TEST(Scattering, ALambertBodySendsOutWhatItReceives) {
  // The integral of its brightness over all directions is pi times the area that the Sun sees.
  const Vector3 axes(3.0, 1.5, 1.0), sun = Vector3(0.3, -0.5, 0.8).normalized();
  const auto body = ellipsoid_shape(axes);
  const ScatteringLaw law = scattering_law("lambert");
  constexpr int steps = 300;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double z = -1.0 + (i + 0.5) * 2.0 / steps, across = std::sqrt(1.0 - z * z);
    for (int k = 0; k < steps; ++k) {
      const double longitude = (k + 0.5) * 2.0 * pi / steps;
      sum += body->light({across * std::cos(longitude), across * std::sin(longitude), z}, sun, law).brightness_m2;
    }
  }
  sum *= 4.0 * pi / (steps * steps);
  const double cross_section = pi * axes.prod() * sun.cwiseQuotient(axes).norm();
  EXPECT_NEAR(sum / (pi * cross_section), 1.0, 1e-5);
}

TEST(Scattering, TheMeanAtOppositionIsAMean) {
  const auto body = ellipsoid_shape({2.0, 1.3, 1.0});
  std::mt19937 generator(3);
  for (const char* name : all_laws) {
    const ScatteringLaw law = scattering_law(name);
    double sum = 0.0;
    constexpr int count = 40000;
    for (int i = 0; i < count; ++i) {
      const Vector3 to = random_direction(generator);
      sum += body->light(to, to, law).brightness_m2;
    }
    EXPECT_NEAR(sum / count / body->mean_at_opposition_m2(law), 1.0, 5e-3) << name;
  }
}

TEST(Scattering, WhatOthersHideAndShadeIsDark) {
  TriangleMesh boxes;
  add_box(boxes, {0, 0, 0}, {1, 1, 1});
  add_box(boxes, {3, 0, 0}, {4, 1, 1});
  const auto shape = mesh_shape(boxes, 1.0);
  const ScatteringLaw area = scattering_law("projected-area");
  // Along x the near box hides the far one; along y both are seen.
  EXPECT_NEAR(shape->light({1, 0, 0}, {1, 0, 0}, area).area_m2, 1.0, 1e-12);
  EXPECT_NEAR(shape->light({0, 1, 0}, {0, 1, 0}, area).area_m2, 2.0, 1e-12);
  // Seen at 45 deg from +x+y, lit along x: the face +x of the box at 3, not that of the other, which lies in its
  // shadow.
  const Vector3 slanted = Vector3(1, 1, 0).normalized();
  EXPECT_NEAR(shape->light(slanted, {1, 0, 0}, area).area_m2, std::sqrt(0.5), 1e-12);
  // Lit along y and seen from there all the same: the faces +y of both.
  EXPECT_NEAR(shape->light(slanted, {0, 1, 0}, area).area_m2, 2.0 * std::sqrt(0.5), 1e-12);
}

TEST(Scattering, ACubeGlintsFourTimesATurn) {
  TriangleMesh cube;
  add_box(cube, {-1, -1, -1}, {1, 1, 1});
  const auto shape = mesh_shape(cube, 1.0);
  ScatteringLaw law = scattering_law("lambert");
  law.specular = 0.3;
  // It turns about z; the Sun and the observer stand 40 deg apart in the plane across. A face throws the Sun's disc at
  // the observer while its normal is within half the disc's radius of the middle of both.
  const double phase = 40.0 * degree;
  constexpr int steps = 200000;
  int glints = 0, bright = 0;
  bool before = false;
  double brightest = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double turn = 2.0 * pi * (i + 0.5) / steps + 0.3;
    const Vector3 observer(std::cos(turn), std::sin(turn), 0), sun(std::cos(turn + phase), std::sin(turn + phase), 0);
    ScatteringLaw dull = law;
    dull.specular = 0.0;
    const double extra =
        shape->light(observer, sun, law).brightness_m2 - shape->light(observer, sun, dull).brightness_m2;
    brightest = std::max(brightest, extra);
    glints += int(extra > 0.0 && !before);
    bright += int(extra > 0.0);
    before = extra > 0.0;
  }
  EXPECT_EQ(glints, 4);
  EXPECT_NEAR(bright * 2.0 * pi / steps, 4.0 * kSunRadius_rad, 8 * 2.0 * pi / steps);
  const double sine = std::sin(kSunRadius_rad);
  EXPECT_NEAR(brightest, 0.3 * 4.0 * std::cos(0.5 * phase) / (sine * sine), 0.01 * brightest);  // a face of 4 m2
}

TEST(Scattering, SurfacesShineByThemselves) {
  for (const double apart : {0.0, 3.0}) {  // one cube, which is convex, or two that may hide each other
    TriangleMesh mesh;
    add_box(mesh, {-1, -1, -1}, {1, 1, 1});
    if (apart != 0.0) add_box(mesh, {-1, -1 + apart, -1}, {1, 1 + apart, 1});
    mesh.surface_names = {"foil", "panel"};
    for (const auto& facet : mesh.facets) {
      const Vector3 &a = mesh.vertices[facet[0]], &b = mesh.vertices[facet[1]], &c = mesh.vertices[facet[2]];
      mesh.surface_of_facet.push_back((b - a).cross(c - a).x() > 0.5 ? 1 : 0);  // +x is a panel
    }
    ScatteringLaw law = scattering_law("lambert");
    law.specular = 0.1;
    const auto shape = mesh_shape(mesh, 1.0, {{"panel", {0.25, 0.5}}});
    const double faces = apart == 0.0 ? 4.0 : 8.0;  // m2 of one side
    const double lit = std::cos(0.2), mirrored = std::pow(std::sin(kSunRadius_rad), -2);
    for (const double sign : {1.0, -1.0}) {
      const Vector3 observer(sign * std::cos(0.2), 0, std::sin(0.2)), sun(sign * std::cos(0.2), 0, -std::sin(0.2));
      const double diffuse = sign > 0.0 ? 0.25 : 1.0, specular = sign > 0.0 ? 0.5 : 0.1;
      // (Besides, nothing is lit and seen: the sides lie along both directions, or away from one.)
      EXPECT_NEAR(shape->light(observer, sun, law).brightness_m2,
                  faces * (diffuse * lit * lit + specular * lit * mirrored), 1e-9 * mirrored);
      EXPECT_NEAR(shape->light(observer, sun, law).area_m2, faces * lit, 1e-9);
    }
    if (apart == 0.0) {
      EXPECT_NEAR(shape->mean_at_opposition_m2(law), (20.0 + 0.25 * 4.0) / 6.0, 1e-12);
    }
    EXPECT_THROW(mesh_shape(mesh, 1.0, {{"dish", {}}}), InputError);
    EXPECT_THROW(mesh_shape(mesh, 1.0, {{"panel", {1.5, 0.0}}}), InputError);
    EXPECT_THROW(mesh_shape(mesh, 1.0, {{"panel", {0.5, -0.1}}}), InputError);
  }
}

TEST(Scattering, PlatesShineOnBothSides) {
  TriangleMesh plate;  // 2 m2 in the plane z = 0, seen from above
  plate.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  plate.facets = {{0, 1, 2}, {0, 2, 3}};
  plate.surface_names = {"plate"};
  plate.surface_of_facet = {0, 0};
  const ScatteringLaw law = scattering_law("lambert");
  EXPECT_THROW(mesh_shape(plate, 1.0), InputError);
  const Vector3 above(0.0, 0.6, 0.8), below(0.0, 0.6, -0.8);
  for (const bool two_sided : {false, true}) {
    const auto shape = mesh_shape(plate, 1.0, {{"plate", {0.5, 0.0, two_sided}}});
    EXPECT_NEAR(shape->light(above, above, law).brightness_m2, 0.5 * 2.0 * 0.64, 1e-12);
    EXPECT_NEAR(shape->light(below, below, law).brightness_m2, two_sided ? 0.5 * 2.0 * 0.64 : 0.0, 1e-12);
    EXPECT_EQ(shape->light(above, below, law).brightness_m2, 0.0);  // lit from behind
  }
  // Two of them, one above the other: the lower is hidden from above, and not by its own front from below.
  TriangleMesh two = plate;
  for (int i = 0; i < 4; ++i) two.vertices.push_back(plate.vertices[static_cast<std::size_t>(i)] + Vector3(0, 0, 1));
  two.facets.push_back({4, 5, 6});
  two.facets.push_back({4, 6, 7});
  two.surface_of_facet.resize(4, 0);
  const auto shape = mesh_shape(two, 1.0, {{"plate", {1.0, 0.0, true}}});
  EXPECT_NEAR(shape->light({0, 0, 1}, {0, 0, 1}, law).area_m2, 2.0, 1e-12);
  EXPECT_NEAR(shape->light({0, 0, -1}, {0, 0, -1}, law).area_m2, 2.0, 1e-12);
  plate.vertices[1].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(mesh_shape(plate, 1.0, {{"plate", {}}}), InputError);
}

TEST(Scattering, AMeshsUnitCounts) {
  TriangleMesh box;
  add_box(box, {-1, -1, -1}, {1, 1, 1});
  const ScatteringLaw area = scattering_law("projected-area");
  EXPECT_NEAR(mesh_shape(box, 1000.0)->light({0, 0, 1}, {0, 0, 1}, area).area_m2, 4e6, 1e-6);
  EXPECT_THROW(mesh_shape(box, 0.0), InputError);
  box.facets.pop_back();
  EXPECT_THROW(mesh_shape(box, 1.0), InputError);
  EXPECT_THROW(ellipsoid_shape({1.0, 0.0, 1.0}), InputError);
  EXPECT_THROW(scattering_law("hapke"), InputError);
}

TEST(Scattering, EveryInstructionSetGivesTheSame) {
  const brightness::Kernels* available[3];
  const std::size_t targets = brightness::kernels(available);
  constexpr std::size_t count = 37;  // no multiple of any number of lanes
  std::array<std::vector<double>, 10> in;
  std::mt19937 generator(11);
  for (auto& one : in) one.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 observer = random_direction(generator);
    Vector3 sun = random_direction(generator);
    if (i == 5) sun = observer;
    if (i == 6) sun = -observer;
    const Vector3 axis = random_direction(generator);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto j = static_cast<std::size_t>(k);
      in[j][i] = observer[k];
      in[3 + j][i] = sun[k];
      in[7 + j][i] = 0.6 * axis[k];
    }
    in[6][i] = 0.8;
  }
  const brightness::Directions directions{{in[0].data(), in[1].data(), in[2].data()},
                                          {in[3].data(), in[4].data(), in[5].data()}};
  const double* const q[4] = {in[6].data(), in[7].data(), in[8].data(), in[9].data()};
  std::array<std::vector<double>, 4> normals;
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < 24; ++i) normals[k].push_back(in[k][i] + (k == 3 ? 2.0 : 0.0));
  }
  const brightness::FacetArrays facets{
      {normals[0].data(), normals[1].data(), normals[2].data()}, normals[3].data(), 24};
  constexpr double map[9] = {0.0, 0.5, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0};
  std::vector<std::vector<double>> results;
  for (std::size_t t = 0; t < targets; ++t) {
    std::array<std::vector<double>, 6> turned;
    for (auto& one : turned) one.resize(count);
    double* const observer[3] = {turned[0].data(), turned[1].data(), turned[2].data()};
    double* const sun[3] = {turned[3].data(), turned[4].data(), turned[5].data()};
    available[t]->turn(count, q, directions, map, observer, sun);
    const brightness::Directions mapped{{observer[0], observer[1], observer[2]}, {sun[0], sun[1], sun[2]}};
    std::vector<double> all;
    for (const auto& one : turned) all.insert(all.end(), one.begin(), one.end());
    std::vector<double> brightness(count), area(count);
    const auto keep = [&] {
      all.insert(all.end(), brightness.begin(), brightness.end());
      all.insert(all.end(), area.begin(), area.end());
    };
    available[t]->ellipsoid_area(count, mapped, 2.0, area.data());
    available[t]->ellipsoid_lommel_seeliger(count, mapped, 2.0, brightness.data());
    keep();
    for (const brightness::LawWeights& law : {brightness::LawWeights{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.1}}) {
      available[t]->facets(count, directions, facets, law, {brightness.data(), area.data()});
      keep();
    }
    results.push_back(std::move(all));
  }
  for (const std::vector<double>& result : results) {
    for (std::size_t i = 0; i < result.size(); ++i) {
      ASSERT_NEAR(result[i], results[0][i], 1e-13 * (1.0 + std::abs(results[0][i]))) << i;
    }
  }
  // One of the turns by hand.
  const Quaternion turn(q[0][3], q[1][3], q[2][3], q[3][3]);
  const Vector3 body = turn.conjugate() * Vector3(in[0][3], in[1][3], in[2][3]);
  EXPECT_NEAR(results[0][3], 0.5 * body.y(), 1e-15);
  EXPECT_NEAR(results[0][count + 3], body.z(), 1e-15);
  EXPECT_NEAR(results[0][2 * count + 3], 2.0 * body.x(), 1e-15);
}

TEST(Scattering, ThePhaseFunctionOfMuinonen) {
  EXPECT_EQ(hg1g2({0.26, 0.38}, 0.0), 1.0);
  EXPECT_NEAR(hg1g2({1.0, 0.0}, 60.0 * degree), 1.3410560e-1, 1e-12);
  EXPECT_NEAR(hg1g2({0.0, 1.0}, 90.0 * degree), 1.2716367e-1, 1e-12);
  EXPECT_NEAR(hg1g2({0.0, 0.0}, 2.0 * degree), 4.2144772e-1, 1e-12);
  EXPECT_NEAR(hg1g2({1.0, 0.0}, 7.5 * degree), 0.75, 1e-9);  // the straight part meets the curve
  // A sphere follows it.
  const auto sphere = ellipsoid_shape(Vector3::Ones());
  const ScatteringLaw law = scattering_law("lommel-seeliger");
  const double phase = 40.0 * degree;
  const double light = sphere->light({1, 0, 0}, {std::cos(phase), std::sin(phase), 0}, law).brightness_m2;
  const double magnitude = -2.5 * std::log10(light / sphere->mean_at_opposition_m2(law)) +
                           phase_magnitude(HG1G2Phase{0.26, 0.38}, law, phase);
  EXPECT_NEAR(magnitude, -2.5 * std::log10(hg1g2({0.26, 0.38}, phase)), 1e-13);
  EXPECT_NEAR(phase_magnitude(PolynomialPhase{0.03, -1e-4}, law, 10.0 * degree), 0.29, 1e-13);
}

TEST(Aspect, PositionAnglesGoFromNorthThroughEast) {
  // A target at right ascension 0, declination 0; the observer lies towards -x of it.
  const Vector3 towards(-1, 0, 0);
  EXPECT_NEAR(axis_on_sky({0, 0, 2}, towards).position_angle_rad, 0.0, 1e-15);
  EXPECT_NEAR(axis_on_sky({0, 1, 0}, towards).position_angle_rad, pi / 2, 1e-15);  // east: growing right ascension
  EXPECT_NEAR(axis_on_sky({0, 0, -1}, towards).position_angle_rad, pi, 1e-15);
  EXPECT_NEAR(axis_on_sky({0, -1, 1}, towards).position_angle_rad, 7 * pi / 4, 1e-15);
  EXPECT_NEAR(axis_on_sky({-3, 0, 0}, towards).aspect_angle_rad, 0.0, 1e-15);
  EXPECT_NEAR(axis_on_sky({1, 0, 1}, towards).aspect_angle_rad, 3 * pi / 4, 1e-15);
  EXPECT_NEAR(axis_on_sky({0, 1, 1}, towards).icrf.latitude_rad, pi / 4, 1e-15);
}

TEST(Aspect, TheAnglesOfAConventionAreThoseOfStateAt) {
  const Inertia inertia = inertia_from_moments({1.0, 2.0, 2.5}, false);
  for (const AxisConvention convention : {AxisConvention::long_axis, AxisConvention::short_axis}) {
    for (const bool long_axis_mode : {false, true}) {
      const double ratio = convention == AxisConvention::long_axis ? 1.1 : 0.9;
      std::vector<SpinSolution> solutions;
      for (double r = 0.3; r < 12.0 && solutions.empty(); r *= 1.05) {
        try {
          solutions = solve_periods(inertia, {convention, 1000.0, r * ratio * 1000.0, long_axis_mode});
        } catch (const InputError&) {  // no such motion; the next ratio
        }
      }
      ASSERT_FALSE(solutions.empty());
      for (const double psi : {0.1, 3.0}) {
        try {
          const EulerState state = state_at(inertia, convention, solutions[0], 0.7, psi, false);
          const Vector3 angles = convention_angles_rad(convention, state.q_momentum_from_principal);
          EXPECT_NEAR(angles[0], 0.7, 1e-13);
          EXPECT_NEAR(angles[1], state.theta_rad, 1e-13);
          EXPECT_NEAR(angles[2], psi, 1e-13);
        } catch (const InputError&) {  // psi swings and does not come there
        }
      }
    }
  }
}

TEST(Sight, LightTimeIsThatOfTheWay) {
  // A target at rest 3e11 m from the barycentre, an observer there.
  const Instant zero = parse_date("2020-01-01T00:00:00", TimeScale::tdb);
  const auto at = [&](const Vector3& position) {
    OrbitTable table;
    for (int i = -2; i <= 2; ++i) {
      table.times_s.push_back(1e6 * i);
      table.positions_m.push_back(position);
    }
    table.degree = 3;
    return KnownWay{Trajectory(TabulatedOrbit({table})), Frame::icrf, zero, "SSB", {}};
  };
  const Viewing viewing(at({3e11, 0, 0}), at({0, 4e11, 0}), at({1.0, 0, 0}));
  const Sight sight = viewing.at(zero);
  EXPECT_NEAR(sight.light_time_s, 5e11 / speed_of_light_m_s, 1e-9);
  EXPECT_NEAR((sight.observer_from_target_m - Vector3(-3e11, 4e11, 0)).norm(), 0.0, 1e-3);
  EXPECT_NEAR((sight.sun_from_target_m - Vector3(1.0 - 3e11, 0, 0)).norm(), 0.0, 1e-3);
  EXPECT_THROW(Viewing(KnownWay{at({1, 0, 0}).trajectory, Frame::icrf, zero, "MARS", {}}, TheGeocentre{}), InputError);
  EXPECT_THROW(viewing.at(zero + Seconds{1e8, 0.0}), InputError);
}

TEST(Sight, ManyInstantsAreInterpolated) {
  const Instant zero = parse_date("2029-04-01T00:00:00", TimeScale::tdb);
  const KeplerElements elements{1.32712440018e20, 1.1e11, 0.2, 3e6, {1, 0.2, 0}, {-0.02, 0.1, 1}};
  const Viewing viewing(KnownWay{Trajectory(elements), Frame::icrf, zero, "Sun", {}}, TheGeocentre{});
  std::vector<Instant> instants;
  for (int i = 0; i < 5000; ++i) instants.push_back(zero + Seconds{i * 4000.0, 0.0});
  const Sights sights(viewing, instants);
  ASSERT_TRUE(sights.interpolated());
  for (std::size_t i = 0; i < instants.size(); i += 499) {
    const Sight wanted = viewing.at(instants[i]), found = sights.at(instants[i]);
    EXPECT_NEAR(found.light_time_s, wanted.light_time_s, 2e-8);
    EXPECT_LT((found.observer_from_target_m - wanted.observer_from_target_m).norm(),
              3e-11 * wanted.observer_from_target_m.norm());
  }
  EXPECT_FALSE(Sights(viewing, std::span(instants).first(20)).interpolated());
}

}  // namespace
