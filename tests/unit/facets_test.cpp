#include "polhode/torque/facet_table.hpp"

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

std::vector<FacetNormal> random_normals(std::size_t count) {
  std::mt19937_64 random(count);
  std::normal_distribution<double> normal;
  std::vector<FacetNormal> all(count);
  for (FacetNormal& one : all) {
    one.normal = Vector3(normal(random), normal(random), normal(random)).normalized();
    for (Vector3* vector : {&one.along_m3, &one.square_m3, &one.linear_m3}) {
      *vector = Vector3(normal(random), normal(random), normal(random));
    }
  }
  // Ones that are edge-on where cells, and faces of the cube, meet.
  all[0].normal = Vector3::UnitX();
  all[1].normal = Vector3(1, -1, 0).normalized();
  return all;
}

/// As FacetNormal says it, one by one.
Vector3 torque_m3(const std::vector<FacetNormal>& normals, const Vector3& s) {
  Vector3Of<long double> sum = Vector3Of<long double>::Zero();
  for (const FacetNormal& one : normals) {
    const double c = one.normal.dot(s);
    if (!(c > 0.0)) continue;
    sum -= (c * (one.along_m3.cross(s) + c * one.square_m3 + one.linear_m3)).cast<long double>();
  }
  return sum.cast<double>();
}

std::vector<Vector3> directions(const std::vector<FacetNormal>& normals) {
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

TEST(FacetTable, IsTheSumOverTheFacets) {
  for (const std::size_t count : {10, 100, 1200, 20000}) {
    const std::vector<FacetNormal> normals = random_normals(count);
    const FacetTable table(normals);
    const FacetSum sum(normals);
    double worst = 0.0, worst_sum = 0.0;
    std::vector<Vector3> all = directions(normals);
    if (count > 2000) all.resize(2000);
    for (const Vector3& s : all) {
      const Vector3 truth = torque_m3(normals, s);
      worst = std::max(worst, (table.torque_m3(s) - truth).norm());
      worst_sum = std::max(worst_sum, (sum.torque_m3(s) - truth).norm());
    }
    double size = 0.0;
    for (const FacetNormal& one : normals) size += one.along_m3.norm() + one.square_m3.norm() + one.linear_m3.norm();
    std::printf("%zu normals: table off by %.1f roundings of the sum of sizes, sum by %.1f\n", count,
                worst / size * 0x1p52, worst_sum / size * 0x1p52);
    EXPECT_LE(worst, table.largest_error_m3());
    EXPECT_LE(worst_sum, table.largest_error_m3());
    EXPECT_LE(table.largest_error_m3(), 1e-13 * size);
  }
}

TEST(FacetTable, ItsSizeIsBounded) {
  for (const std::size_t count : {1, 100, 10'000, 1'000'000}) {
    const double along = static_cast<double>(FacetTable::cells_along(count));
    EXPECT_LE(6 * along * along * (220.0 + 4.0 * 1.2 * static_cast<double>(count) / along),
              std::max(1.3 * FacetTable::kMostBytes, 200.0 * static_cast<double>(count)));
  }
}

Vector3 constant(const Sunlight& sunlight, const Quaternion& q) {
  return Torques({sunlight}).at<double>(0.0, q, Vector3::Ones()).constant;
}

TEST(FacetTable, TorquesBySunlightAreTheSame) {
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
    const Quaternion q = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
    EXPECT_LT((constant(sums, q) - constant(table, q)).norm(), 1e-14 * size);
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
  // Its edges hold its kinks: what is left without them is a polynomial of the second degree in the direction.
  const auto left = [&](const Vector3& from_body) {
    const OrbitState<double> orbit{-1.471e11 * from_body.normalized(), Vector3::Zero()};
    const TorquePlace<double> place{Matrix3::Identity(), &orbit};
    const TorqueStream stream = six.stream_at(place);
    EXPECT_EQ(stream.edges.size(), 3u);
    TorqueTerms<double> terms;
    six.add<double>(place, Vector3::Ones(), terms);
    Vector3 rest = terms.constant;
    for (const FacetNormal& edge : stream.edges) {
      const double c = edge.normal.dot(stream.from_body);
      if (c > 0.0) {
        rest += stream.pressure_pa * c * (edge.along_m3.cross(stream.from_body) + c * edge.square_m3 + edge.linear_m3);
      }
    }
    return rest;
  };
  const double six_size = six.largest(0.0, Vector3::Ones(), 0.0);
  for (int i = 0; i < 200;
       ++i) {  // on a circle: of the second order in its angle, so that the third differences are known
    const Vector3 tilt = Vector3(normal(random), normal(random), normal(random)).normalized();
    const Vector3 x = tilt.unitOrthogonal(), y = tilt.cross(x);
    Vector3 third_harmonic = Vector3::Zero();
    for (int j = 0; j < 12; ++j) {
      const double angle = std::numbers::pi / 6.0 * j;
      third_harmonic += std::cos(3.0 * angle) * left(std::cos(angle) * x + std::sin(angle) * y + 0.3 * tilt);
    }
    EXPECT_LT(third_harmonic.norm(), 1e-13 * six_size);
  }
  const Torques torques({sums, six});
  const Torques tabulated = torques.with_tables();
  EXPECT_TRUE(std::get<Sunlight>(tabulated.list()[0]).has_table());
  EXPECT_FALSE(std::get<Sunlight>(tabulated.list()[1]).has_table());
}

}  // namespace
}  // namespace polhode
