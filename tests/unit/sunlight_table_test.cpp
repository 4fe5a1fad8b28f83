#include "polhode/torque/sunlight_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "polhode/torque/torques.hpp"

namespace polhode {
namespace {

constexpr SunlightTable::Shares kShares{0.3, 0.5};

std::vector<SunlitNormal> random_normals(std::size_t count) {
  std::mt19937_64 random(count);
  std::normal_distribution<double> normal;
  std::vector<SunlitNormal> all(count);
  for (SunlitNormal& one : all) {
    one.normal = Vector3(normal(random), normal(random), normal(random)).normalized();
    one.moment_m3 = Vector3(normal(random), normal(random), normal(random));
    one.normal_moment_m3 = one.moment_m3.cross(one.normal);
  }
  // Ones that are edge-on where cells, and faces of the cube, meet.
  all[0].normal = Vector3::UnitX();
  all[1].normal = Vector3(1, -1, 0).normalized();
  for (int i = 0; i < 2; ++i) all[i].normal_moment_m3 = all[i].moment_m3.cross(all[i].normal);
  return all;
}

/// As Sunlight says it, one by one.
Vector3 torque_m3(const std::vector<SunlitNormal>& normals, const Vector3& s) {
  Vector3Of<long double> sum = Vector3Of<long double>::Zero();
  for (const SunlitNormal& one : normals) {
    const double c = one.normal.dot(s);
    if (!(c > 0.0)) continue;
    const Vector3 force =
        c * ((1.0 - kShares.specular) * s + (2.0 * kShares.specular * c + 2.0 / 3.0 * kShares.diffuse) * one.normal);
    sum -= one.moment_m3.cross(force).cast<long double>();
  }
  return sum.cast<double>();
}

std::vector<Vector3> directions(const std::vector<SunlitNormal>& normals) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<std::size_t> any(0, normals.size() - 1);
  std::vector<Vector3> all;
  for (int i = 0; i < 2000; ++i) {
    const Vector3 s = Vector3(normal(random), normal(random), normal(random)).normalized();
    all.push_back(s);
    // Edge-on to one of them, and a little beside.
    const Vector3& n = normals[any(random)].normal;
    for (const double aside : {0.0, 1e-15, -1e-12, 1e-9, -1e-6}) {
      all.push_back((s - n.dot(s) * n + aside * n).normalized());
    }
  }
  for (int x = -4; x <= 4; ++x) {  // corners of cells
    for (int y = -4; y <= 4; ++y) {
      for (int z = -4; z <= 4; ++z) {
        if (x != 0 || y != 0 || z != 0) all.push_back(Vector3(x, y, z).normalized());
      }
    }
  }
  return all;
}

TEST(SunlightTable, IsTheSumOverTheFacets) {
  for (const std::size_t count : {10, 100, 1200, 20000}) {
    const std::vector<SunlitNormal> normals = random_normals(count);
    const SunlightTable table(normals, kShares);
    const SunlitSum sum(normals, kShares);
    double worst = 0.0, worst_sum = 0.0;
    std::vector<Vector3> all = directions(normals);
    if (count > 2000) all.resize(2000);
    for (const Vector3& s : all) {
      const Vector3 truth = torque_m3(normals, s);
      worst = std::max(worst, (table.torque_m3(s) - truth).norm());
      worst_sum = std::max(worst_sum, (sum.torque_m3(s) - truth).norm());
    }
    double size = 0.0;
    for (const SunlitNormal& one : normals) size += one.moment_m3.norm();
    std::printf("%zu normals: table off by %.1f roundings of the sum of sizes, sum by %.1f\n", count,
                worst / size * 0x1p52, worst_sum / size * 0x1p52);
    EXPECT_LE(worst, table.largest_error_m3());
    EXPECT_LE(worst_sum, table.largest_error_m3());
    EXPECT_LE(table.largest_error_m3(), 1e-13 * size);
  }
}

TEST(SunlightTable, ItsSizeIsBounded) {
  for (const std::size_t count : {1, 100, 10'000, 1'000'000}) {
    const double along = static_cast<double>(SunlightTable::cells_along(count));
    EXPECT_LE(6 * along * along * (220.0 + 4.0 * 1.2 * static_cast<double>(count) / along),
              std::max(1.3 * SunlightTable::kMostBytes, 200.0 * static_cast<double>(count)));
  }
}

TEST(SunlightTable, TorquesBySunlightAreTheSame) {
  TriangleMesh ball;  // of bands, with hills
  constexpr std::uint32_t bands = 12, around = 24;
  for (std::uint32_t i = 0; i <= bands; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const double a = std::numbers::pi * i / bands, b = 2.0 * std::numbers::pi * j / around;
      const double r = 2.0 + 0.3 * std::sin(3.0 * b + 2.0 * a) * std::sin(a);
      ball.vertices.emplace_back(r * std::sin(a) * std::cos(b) + 0.2, r * std::sin(a) * std::sin(b),
                                 1.5 * r * std::cos(a));
    }
  }
  for (std::uint32_t i = 0; i < bands; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t a = i * around + j, b = i * around + (j + 1) % around;
      if (i > 0) ball.facets.push_back({a, a + around, b});
      if (i < bands - 1) ball.facets.push_back({b, a + around, b + around});
    }
  }
  const KeplerElements way{1.32712440018e20, 1.471e11, 0.0167, 0.0, {1, 0, 0}, {0, -0.4, 0.917}};
  const Sunlight sums(ball, {0.3, 0.5}, way), table = sums.with_table();
  EXPECT_TRUE(table.has_table());
  EXPECT_FALSE(sums.has_table());
  EXPECT_TRUE(std::isfinite(sums.evaluations_for_table()));
  EXPECT_FALSE(sums.has_edges());
  EXPECT_LT(table.cost_of_evaluation(), sums.cost_of_evaluation());
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const double size = sums.largest(0.0, Vector3::Ones(), 0.0);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 to_sun_m = way.periapsis_m * Vector3(normal(random), normal(random), normal(random)).normalized();
    EXPECT_LT((sums.torque(to_sun_m) - table.torque(to_sun_m)).norm(), 1e-14 * size);
  }
  // A box has six normals, and is better summed.
  TriangleMesh box;
  for (int i = 0; i < 8; ++i) box.vertices.emplace_back(i & 1 ? 1 : -1, i & 2 ? 2 : -2, i & 4 ? 3 : -2.5);
  for (const auto& c : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}}) {
    box.facets.push_back({c[0], c[1], c[2]});
    box.facets.push_back({c[0], c[2], c[3]});
  }
  const Sunlight six(box, {0.3, 0.5}, way);
  EXPECT_EQ(six.evaluations_for_table(), std::numeric_limits<double>::infinity());
  std::vector<TorqueEdge> edges;
  OrbitState<double> orbit{Vector3(-1.471e11, 2e10, 3e10), Vector3::Zero()};
  six.add_edges({Matrix3::Identity(), &orbit}, edges);
  ASSERT_EQ(edges.size(), 6u);
  Vector3 sum = Vector3::Zero();
  for (const TorqueEdge& edge : edges) sum += std::max(edge.cosine, 0.0) * edge.torque_per_cosine;
  EXPECT_LT((sum - six.torque(-orbit.position_m)).norm(), 1e-14 * sum.norm());
  const Torques torques({sums, six});
  const Torques tabulated = torques.with_tables();
  EXPECT_TRUE(std::get<Sunlight>(tabulated.list()[0]).has_table());
  EXPECT_FALSE(std::get<Sunlight>(tabulated.list()[1]).has_table());
}

}  // namespace
}  // namespace polhode
