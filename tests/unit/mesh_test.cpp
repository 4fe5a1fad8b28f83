// Mass properties of meshes against closed forms, and the mesh readers.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <sstream>

#include "polhode/base/error.hpp"
#include "polhode/body/mesh_inertia.hpp"
#include "polhode/read/mesh_file.hpp"

namespace polhode {
namespace {

constexpr double pi = std::numbers::pi;

/// A box of edges (a, b, c), one corner at `corner`.
TriangleMesh box(const Vector3& corner, const Vector3& edges) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(corner + edges.cwiseProduct(Vector3(i & 1, (i >> 1) & 1, i >> 2)));
  mesh.facets = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// Each facet cut into four; the new corners moved by `place`.
template <typename Place>
TriangleMesh refined(const TriangleMesh& mesh, const Place& place) {
  TriangleMesh out;
  out.vertices = mesh.vertices;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.vertices.size()));
    if (added) out.vertices.push_back(place((0.5 * (mesh.vertices[a] + mesh.vertices[b])).eval()));
    return it->second;
  };
  for (const auto& f : mesh.facets) {
    const std::uint32_t a = middle(f[0], f[1]);
    const std::uint32_t b = middle(f[1], f[2]);
    const std::uint32_t c = middle(f[2], f[0]);
    out.facets.insert(out.facets.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
  }
  return out;
}

TriangleMesh octahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.facets = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return mesh;
}

TriangleMesh sphere(int levels) {
  TriangleMesh mesh = octahedron();
  for (int i = 0; i < levels; ++i) mesh = refined(mesh, [](const Vector3& v) { return v.normalized().eval(); });
  return mesh;
}

/// A torus as n x m quadrilaterals, each cut in two.
TriangleMesh torus(double large, double small, std::uint32_t n, std::uint32_t m) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < m; ++j) {
      const double u = 2.0 * pi * i / n;
      const double v = 2.0 * pi * j / m;
      const double r = large + small * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), small * std::sin(v));
      const std::uint32_t i1 = (i + 1) % n;
      const std::uint32_t j1 = (j + 1) % m;
      mesh.facets.push_back({i * m + j, i1 * m + j, i1 * m + j1});
      mesh.facets.push_back({i * m + j, i1 * m + j1, i * m + j1});
    }
  }
  return mesh;
}

double worst(const Matrix3& found, const Matrix3& wanted) {
  const double difference = (found - wanted).cwiseAbs().maxCoeff() / wanted.cwiseAbs().maxCoeff();
  return std::isnan(difference) ? HUGE_VAL : difference;
}

std::string message_of(const TriangleMesh& mesh) {
  try {
    mass_properties(mesh);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MeshInertia, BoxIsExact) {
  const MassProperties p = mass_properties(box({-1.0, -2.0, 3.0}, {2.0, 3.0, 5.0}));
  EXPECT_DOUBLE_EQ(p.volume, 30.0);
  EXPECT_LT((p.centre_of_mass - Vector3(0.0, -0.5, 5.5)).norm(), 1e-14);
  const Matrix3 wanted = Vector3(30.0 / 12 * (9 + 25), 30.0 / 12 * (4 + 25), 30.0 / 12 * (4 + 9)).asDiagonal();
  EXPECT_LT(worst(p.inertia_about_centre, wanted), 1e-15);
}

TEST(MeshInertia, CornerTetrahedron) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.facets = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MassProperties p = mass_properties(mesh);
  EXPECT_NEAR(p.volume, 1.0 / 6.0, 1e-16);
  EXPECT_LT((p.centre_of_mass - Vector3::Constant(0.25)).norm(), 1e-15);
  // Integrals over the corner tetrahedron: x^2 1/60, xy 1/120; about the centre each less V/16.
  const double xx = 1.0 / 60 - 1.0 / 96;
  const double xy = 1.0 / 120 - 1.0 / 96;
  const Matrix3 wanted = (2 * xx + xy) * Matrix3::Identity() - Matrix3::Constant(xy);
  EXPECT_LT(worst(p.inertia_about_centre, wanted), 1e-14);
}

TEST(MeshInertia, TorusAndEllipsoidConverge) {
  // The error of a polyhedron inscribed in a smooth surface falls as the square of the edge.
  const double large = 3.0;
  const double small = 1.0;
  const double volume = 2 * pi * pi * large * small * small;
  const double polar = volume * (large * large + 0.75 * small * small);
  const double across = volume * (0.5 * large * large + 0.625 * small * small);
  const Matrix3 of_torus = Vector3(across, across, polar).asDiagonal();
  double before = 0.0;
  for (const std::uint32_t n : {32U, 64U, 128U, 256U}) {
    const double error = worst(mass_properties(torus(large, small, 2 * n, n)).inertia_about_centre, of_torus);
    if (n > 32) {
      EXPECT_NEAR(before / error, 4.0, 0.05) << n;
    }
    before = error;
  }
  const Vector3 axes(1.0, 2.0, 0.5);
  const double ball = 4.0 / 3.0 * pi;
  const Matrix3 of_ellipsoid = Vector3(ball / 5 * (4 + 0.25), ball / 5 * (1 + 0.25), ball / 5 * 5).asDiagonal();
  for (int level = 4; level <= 7; ++level) {
    TriangleMesh mesh = sphere(level);
    for (Vector3& v : mesh.vertices) v = v.cwiseProduct(axes).eval();
    const double error = worst(mass_properties(mesh).inertia_about_centre, of_ellipsoid);
    if (level > 4) {
      EXPECT_NEAR(before / error, 4.0, 0.05) << level;
    }
    before = error;
  }
  EXPECT_LT(before, 2e-3);
}

TEST(MeshInertia, MovingTurningRefiningChangesNothing) {
  TriangleMesh mesh = sphere(3);
  for (Vector3& v : mesh.vertices) v = Vector3(v[0] + 0.2 * v[1] * v[2], 1.7 * v[1], 0.6 * v[2] + 0.1 * v[0] * v[0]);
  const MassProperties p = mass_properties(mesh);
  const Quaternion turn = Quaternion(0.3, -0.5, 0.7, 0.4).normalized();
  TriangleMesh moved = mesh;
  for (Vector3& v : moved.vertices) v = turn * v + Vector3(40.0, -70.0, 25.0);
  const MassProperties q = mass_properties(moved);
  const Matrix3 r = turn.toRotationMatrix();
  EXPECT_NEAR(q.volume, p.volume, 1e-12);
  EXPECT_LT((q.centre_of_mass - turn * p.centre_of_mass - Vector3(40.0, -70.0, 25.0)).norm(), 1e-12);
  EXPECT_LT(worst(q.inertia_about_centre, r * p.inertia_about_centre * r.transpose()), 1e-12);
  const MassProperties f =
      mass_properties(refined(refined(mesh, [](const Vector3& v) { return v; }), [](const Vector3& v) { return v; }));
  EXPECT_LT(worst(f.inertia_about_centre, p.inertia_about_centre), 1e-14);
  EXPECT_EQ(f.facets, 16 * p.facets);
  TriangleMesh tiny = mesh;
  for (Vector3& v : tiny.vertices) v *= 1e-30;
  EXPECT_LT(worst(mass_properties(tiny).inertia_about_centre * 1e150, p.inertia_about_centre), 1e-12);
}

TEST(MeshInertia, MillionFacetsInSeconds) {
  const MassProperties p = mass_properties(torus(3.0, 1.0, 1000, 500));
  EXPECT_EQ(p.facets, 1000000U);
  EXPECT_NEAR(p.volume, 6.0 * pi * pi, 3e-3);
}

TEST(MeshInertia, CavitiesAndSeparatePieces) {
  TriangleMesh mesh = box({0, 0, 0}, {4, 4, 4});
  const auto add = [&mesh](TriangleMesh other, bool inward) {
    const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (auto f : other.facets) {
      if (inward) std::swap(f[1], f[2]);
      mesh.facets.push_back({f[0] + n, f[1] + n, f[2] + n});
    }
  };
  const TriangleMesh plain = mesh;
  add(box({1, 1, 1}, {1, 1, 1}), true);
  const MassProperties hollow = mass_properties(mesh);
  EXPECT_NEAR(hollow.volume, 63.0, 1e-12);
  EXPECT_EQ(hollow.shells, 2U);
  mesh = plain;
  add(box({10, 1, 1}, {1, 1, 1}), false);
  EXPECT_NEAR(mass_properties(mesh).volume, 65.0, 1e-12);
  mesh = plain;
  add(box({1, 1, 1}, {1, 1, 1}), false);
  EXPECT_NE(message_of(mesh).find("inside another"), std::string::npos) << message_of(mesh);
  mesh = plain;
  add(box({10, 1, 1}, {1, 1, 1}), true);
  EXPECT_NE(message_of(mesh).find("no cavity"), std::string::npos) << message_of(mesh);
  mesh = plain;
  add(box({3.1, 1.2, 1.3}, {2, 1.1, 1}), false);
  EXPECT_NE(message_of(mesh).find("intersect"), std::string::npos) << message_of(mesh);
  // Boxes that meet on the diagonals of their faces pierce no facet within.
  mesh = plain;
  add(box({2, 2, 2}, {4, 4, 4}), false);
  EXPECT_NE(message_of(mesh).find("overlap"), std::string::npos) << message_of(mesh);
  // Touching is allowed.
  mesh = plain;
  add(box({4, 1, 1}, {1, 2, 2}), false);
  EXPECT_NEAR(mass_properties(mesh).volume, 68.0, 1e-12);
}

TEST(MeshInertia, WhatBoundsNoSolidIsRefused) {
  TriangleMesh mesh = sphere(2);
  TriangleMesh bad = mesh;
  bad.facets.erase(bad.facets.begin() + 5);
  EXPECT_NE(message_of(bad).find("open"), std::string::npos) << message_of(bad);
  bad = mesh;
  std::swap(bad.facets[7][0], bad.facets[7][1]);
  EXPECT_NE(message_of(bad).find("and 8 are neighbours"), std::string::npos) << message_of(bad);
  bad = mesh;
  for (auto& f : bad.facets) std::swap(f[0], f[1]);
  EXPECT_NE(message_of(bad).find("inside out"), std::string::npos) << message_of(bad);
  bad = mesh;
  bad.facets.push_back(bad.facets[3]);
  EXPECT_NE(message_of(bad).find("not a manifold"), std::string::npos) << message_of(bad);
  bad = mesh;
  bad.facets[0][0] = 100000;
  EXPECT_NE(message_of(bad).find("facet 1 names vertex 100001"), std::string::npos) << message_of(bad);
  bad = mesh;
  bad.vertices[3][1] = NAN;
  EXPECT_NE(message_of(bad).find("vertex 4 is not finite"), std::string::npos) << message_of(bad);
  bad = box({0, 0, 0}, {1, 1, 1e-15});
  EXPECT_NE(message_of(bad).find("no volume"), std::string::npos) << message_of(bad);
  // One corner pulled through the opposite side.
  bad = sphere(3);
  bad.vertices[4] = Vector3(0.05, 0.07, -3.0);
  EXPECT_NE(message_of(bad).find("intersect"), std::string::npos) << message_of(bad);
}

/// One unit cube in every format.
TEST(MeshFile, FormatsAgree) {
  const TriangleMesh cube = box({0, 0, 0}, {1, 2, 3});
  std::ostringstream obj;
  std::ostringstream shape;
  std::ostringstream stl;
  std::ostringstream ply;
  std::string binary_stl(80, ' ');
  obj << "# cube\no cube\n";
  shape << cube.vertices.size() << ' ' << cube.facets.size() << '\n';
  ply << "element vertex 8\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
         "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
  std::string binary_ply_le = "ply\nformat binary_little_endian 1.0\n" + ply.str();
  std::string binary_ply_be = "ply\nformat binary_big_endian 1.0\n" + ply.str();
  const auto append = [](std::string& to, const auto value, bool big) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (big) std::reverse(bytes.begin(), bytes.end());
    to += bytes;
  };
  for (const Vector3& v : cube.vertices) {
    obj << "v " << v.transpose() << '\n';
    shape << v.transpose() << '\n';
    ply << v.transpose() << " 7\n";
    for (int k = 0; k < 3; ++k) append(binary_ply_le, static_cast<float>(v[k]), false);
    for (int k = 0; k < 3; ++k) append(binary_ply_be, static_cast<float>(v[k]), true);
    binary_ply_le += '\7';
    binary_ply_be += '\7';
  }
  stl << "solid cube\n";
  append(binary_stl, static_cast<std::uint32_t>(cube.facets.size()), false);
  for (const auto& f : cube.facets) {
    obj << "f " << f[0] + 1 << "/1/1 " << f[1] + 1 << "//2 " << static_cast<int>(f[2]) - 8 << '\n';
    shape << f[0] + 1 << ' ' << f[1] + 1 << ' ' << f[2] + 1 << "\r\n";
    ply << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
    binary_ply_le += '\3';
    binary_ply_be += '\3';
    stl << "facet normal 0 0 0\nouter loop\n";
    binary_stl += std::string(12, '\0');
    for (const std::uint32_t v : f) {
      append(binary_ply_le, v, false);
      append(binary_ply_be, v, true);
      stl << "vertex " << cube.vertices[v].transpose() << '\n';
      for (int k = 0; k < 3; ++k) append(binary_stl, static_cast<float>(cube.vertices[v][k]), false);
    }
    stl << "endloop\nendfacet\n";
    binary_stl += std::string(2, '\0');
  }
  stl << "endsolid cube\n";
  const Matrix3 wanted = mass_properties(cube).inertia_about_centre;
  for (const std::string& content : {obj.str(), shape.str(), stl.str(), "ply\nformat ascii 1.0\n" + ply.str(),
                                     binary_ply_le, binary_ply_be, binary_stl}) {
    const TriangleMesh mesh = read_mesh(content, "mesh");
    EXPECT_EQ(mesh.facets.size(), 12U);
    EXPECT_LT(worst(mass_properties(mesh).inertia_about_centre, wanted), 1e-15) << content.substr(0, 40);
  }
}

TEST(MeshFile, IsKnownByItsContent) {
  EXPECT_TRUE(is_mesh("# of a modeller\nmtllib a.mtl\no Cube\nvt 0 0\nvn 0 0 1\nv 0 0 0\n"));
  EXPECT_TRUE(is_mesh("8 12\n0 0 0\n"));
  EXPECT_FALSE(is_mesh("251 -63\n2451545.0 10\n"));  // a spin.txt without its period
  EXPECT_FALSE(is_mesh("name = 'v'\n"));
}

TEST(MeshFile, FaultsNameTheLine) {
  const auto message = [](const std::string& content) -> std::string {
    try {
      read_mesh(content, "mesh");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message("v 0 0 0\nv 1 x 0\n"), "mesh:2: 'x' is not a number");
  EXPECT_EQ(message("v 0 0 0\nf 1 2 3\n"), "mesh:2: corner 2 is not one of the 1 vertices above");
  EXPECT_EQ(message("4 4\n0 0 0\n"), "mesh:2: the file ends before its last vertex");
  EXPECT_EQ(message("ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\n"
                    "property float z\nend_header\n1 2 3\n"),
            "mesh: vertex 2: the file ends before its last element");
  EXPECT_EQ(message("hello\n"), "mesh: no facets found; known meshes are OBJ, PLY, STL and DAMIT's shape.txt");
  EXPECT_THROW(read_mesh_file("no such file"), FileError);
}

}  // namespace
}  // namespace polhode
