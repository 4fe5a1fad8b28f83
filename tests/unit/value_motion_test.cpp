#include "polhode/motion/value_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/motion/values/dormand_prince.hpp"
#include "polhode/motion/values/edge_corrections.hpp"
#include "polhode/torque/trajectory_pieces.hpp"
#include "support/truth.hpp"

namespace polhode {
namespace {

namespace dp = dormand_prince;

constexpr double kEarth = 3.986004418e14;

FreeBody satellite(const Vector3& omega_rad_s = {0.02, 0.01, 0.04}) {
  const Vector3 moments(17000, 124800, 129200);
  return {moments, Quaternion(0.3, -0.5, 0.7, 0.2).normalized(), moments.cwiseProduct(omega_rad_s)};
}

Torques gravity(double eccentricity = 0.0) {
  return Torques(
      {GravityGradient(kEarth, KeplerElements{kEarth, 7.146e6, eccentricity, 100.0, {1, 0, 0}, {0, 0.6, 0.8}})});
}

const KeplerElements kSunWay{1.32712440018e20, 1.471e11, 0.0167, 0.0, {1, 0, 0}, {0, -0.4, 0.917}};

void add_box(TriangleMesh& mesh, const Vector3& centre, const Vector3& half) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(
        centre + Vector3(i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]));
  }
  constexpr std::uint32_t corners[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& c : corners) {
    mesh.facets.push_back({first + c[0], first + c[1], first + c[2]});
    mesh.facets.push_back({first + c[0], first + c[2], first + c[3]});
  }
}

/// A body, a wing and a dish: 36 facets.
TriangleMesh box_satellite() {
  TriangleMesh mesh;
  add_box(mesh, {0.5, 0.2, 0.0}, {5.0, 1.5, 1.5});
  add_box(mesh, {2.0, 9.0, 0.3}, {1.2, 7.0, 0.05});
  add_box(mesh, {-3.0, 0.0, 2.5}, {1.5, 0.6, 0.9});
  return mesh;
}

double worst_rad(const Motion& a, const Motion& b, double first_s, double last_s, int count = 300) {
  double worst = 0.0;
  for (int i = 0; i <= count; ++i) {
    const double t_s = first_s + (last_s - first_s) * i / count;
    const double angle = rotation_angle_rad(a.at(t_s).q_inertial_from_body, b.at(t_s).q_inertial_from_body);
    if (!(angle <= worst)) worst = angle;
  }
  return worst;
}

TEST(DormandPrince, CoefficientsAreConsistent) {
  for (std::size_t i = 0; i < dp::kStagesOfAll; ++i) {
    double sum = 0.0, size = 0.0;
    for (const double a : dp::kWeights[i]) sum += a, size += std::abs(a);
    EXPECT_NEAR(sum, i == dp::kStages ? 1.0 : dp::kAbscissae[i], 1e-15 * (1.0 + size)) << i;
  }
  for (int power = 0; power < 8; ++power) {  // order 8 of the weights, 7 and 5 of the estimates
    double eighth = 0.0, fifth = 0.0;
    for (std::size_t i = 0; i < dp::kStages; ++i) {
      const double c = std::pow(dp::kAbscissae[i], power);
      eighth += dp::kWeights[dp::kStages][i] * c;
      fifth += dp::kFifthOrderError[i] * c;
    }
    EXPECT_NEAR(eighth, 1.0 / (power + 1), 1e-14) << power;
    if (power < 5) {
      EXPECT_NEAR(fifth, 0.0, 1e-14) << power;
    }
  }
}

TEST(DormandPrince, StepAndContinuousExtensionHaveTheirOrders) {
  // y' = i y in pairs of unknowns, of four frequencies.
  const auto rate = [](double, const dp::Unknowns& y) {
    dp::Unknowns r;
    for (int i = 0; i < 4; ++i) r[2 * i] = -(i + 1.0) * y[2 * i + 1], r[2 * i + 1] = (i + 1.0) * y[2 * i];
    return r;
  };
  const auto exact = [](double t) {
    dp::Unknowns y;
    for (int i = 0; i < 4; ++i) y[2 * i] = std::cos((i + 1.0) * t), y[2 * i + 1] = std::sin((i + 1.0) * t);
    return y;
  };
  double step_error[2], dense_error[2];
  for (int i = 0; i < 2; ++i) {
    const double h = i == 0 ? 0.4 : 0.2;
    const dp::Unknowns y = exact(0.0);
    dp::Unknowns k[dp::kStagesOfAll];
    k[0] = rate(0.0, y);
    dp::stages<1, dp::kStagesOfAll>(rate, 0.0, y, h, k);
    step_error[i] = (y + dp::increment(h, k) - exact(h)).abs().maxCoeff();
    const dp::Dense dense(y, h, k);
    dense_error[i] = 0.0;
    for (int j = 1; j < 10; ++j) {
      dense_error[i] = std::max(dense_error[i], (dense.at(0.1 * j) - exact(0.1 * j * h)).abs().maxCoeff());
    }
    const double estimate = dp::Estimates(k).error(h, dp::Unknowns::Ones());
    EXPECT_GT(estimate, step_error[i]);
    EXPECT_LT(estimate, 1e4 * step_error[i]);
  }
  EXPECT_NEAR(std::log2(step_error[0] / step_error[1]), 9.0, 0.6);
  EXPECT_GT(std::log2(dense_error[0] / dense_error[1]), 7.4);
}

TEST(EdgeCorrections, IntegrateAPartThatSetsInOrEnds) {
  double largest = 0.0;
  for (const double sign : {1.0, -1.0}) {
    for (int i = 1; i < 40; ++i) {
      const double edge = i / 40.0, h = 0.5;  // the edge at this part of the step
      // A stream that turns about z, and another one that never leaves its facet.
      const std::vector<FacetNormal> edges{
          {sign * Vector3::UnitY(), {0.1, 0.2, 0.3}, {0.5, -0.3, 0.2}, {1.0, 2.0, 3.0}},
          {Vector3::UnitX(), {1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}}};
      const auto from_body = [&](double x) { return Vector3(std::cos(h * (x - edge)), std::sin(h * (x - edge)), 0.0); };
      const auto pressure = [&](double x) { return std::exp(-h * x); };
      const auto cosine = [&](double x) { return edges[0].normal.dot(from_body(x)); };
      const auto per_cosine = [&](double x) {
        return Vector3(-pressure(x) *
                       (edges[0].along_m3.cross(from_body(x)) + cosine(x) * edges[0].square_m3 + edges[0].linear_m3));
      };
      std::array<EdgeCorrections::Place, 5> places;
      for (std::size_t j = 0; j < 5; ++j) {
        const double x = 0.25 * static_cast<double>(j);
        places[j].streams = {{from_body(x), pressure(x), edges}, {from_body(x), 0.0, edges}};
        places[j].columns << Matrix3::Identity(), 2.0, 0.0, 0.0;
      }
      EdgeCorrections corrections;
      ASSERT_TRUE(corrections.find(places, h));
      Vector3 exact = Vector3::Zero(), stages = Vector3::Zero();
      constexpr int count = 20000;
      for (int j = 0; j < count; ++j) {
        const double x = (j + 0.5) / count;
        exact += h / count * std::max(cosine(x), 0.0) * per_cosine(x);
      }
      for (std::size_t j = 0; j < dp::kStages; ++j) {
        const double x = dp::kAbscissae[j];
        stages += h * dp::kWeights[dp::kStages][j] * std::max(cosine(x), 0.0) * per_cosine(x);
      }
      const Vector3 corrected = stages + corrections.increment.head<3>().matrix();
      EXPECT_LT((corrected - exact).norm(), 3e-6) << edge;  // without, up to 5e-2
      largest = std::max(largest, (stages - exact).norm());
      EXPECT_NEAR(corrections.increment[3], 2.0 * corrections.increment[0], 1e-14);
      EXPECT_TRUE((corrections.increment.tail<4>() == 0.0).all());
    }
  }
  std::printf("without corrections off by up to %.1e\n", largest);
  EXPECT_GT(largest, 1e-3);
}

TEST(TrajectoryPieces, HoldTheOrbitToRounding) {
  for (const double e : {0.0, 0.7, 1.0, 3.0}) {
    const Trajectory way(KeplerElements{kEarth, 8e6, e, 500.0, {1, 0, 0}, {0, 0.6, 0.8}});
    const TrajectoryPieces pieces(way, -40000.0, 60000.0);
    std::size_t piece = 0;
    for (int i = 0; i <= 20000; ++i) {
      const double t_s = -40000.0 + 5.0 * i;
      const OrbitState<double> state = pieces.state(t_s, piece);
      const OrbitState<long double> exact = way.state<long double>(t_s);
      ASSERT_LT((state.position_m.cast<long double>() - exact.position_m).norm(), 1e-15L * exact.position_m.norm());
      ASSERT_LT((state.velocity_m_s.cast<long double>() - exact.velocity_m_s).norm(),
                1e-15L * exact.velocity_m_s.norm());
    }
    EXPECT_GT(pieces.pieces(), 0u);
    EXPECT_LT(pieces.pieces(), 200u);
    const TrajectoryPieces none(way, -40000.0, 60000.0, 2);
    EXPECT_EQ(none.pieces(), 0u);
    EXPECT_EQ(none.state(123.0, piece).position_m, way.state(123.0).position_m);
  }
}

TEST(ValueMotion, WithoutTorquesItIsTheFreeMotion) {
  for (const Vector3& omega : {Vector3(0.02, 0.01, 0.04), Vector3(0.05, 0.01, 0.004), Vector3(0.001, 0.05, 0.001)}) {
    const FreeBody body = satellite(omega);
    const ThetaMotion exact(body);
    for (const double tolerance_rad : {1e-3, 1e-6, 1e-9}) {
      const ValueMotion motion(body, {}, {tolerance_rad, -3000.0, 20000.0});
      EXPECT_TRUE(motion.whole());
      EXPECT_LE(motion.error_rad(), tolerance_rad);
      EXPECT_LE(worst_rad(motion, exact, -3000.0, 20000.0), motion.error_rad());
      const State a = motion.at(12345.6), b = exact.at(12345.6);
      EXPECT_LT((a.momentum_body - b.momentum_body).norm(), 2.0 * tolerance_rad * b.momentum_body.norm());
    }
  }
}

TEST(ValueMotion, KeepsItsPromiseOnTheTruthCorpus) {
  std::vector<double> overshoots;
  for (const test::TruthCase& c : test::truth_cases(POLHODE_DATA_DIR "/truth/torqued")) {
    const FreeBody& body = c.question.body;
    double first_s = 0.0, last_s = 0.0;
    for (const test::TruthRow& row : c.rows) first_s = std::min(first_s, row.t_s), last_s = std::max(last_s, row.t_s);
    for (const double tolerance_rad : {1e-3, 1e-6, 1e-9, 1e-10}) {
#ifndef NDEBUG
      if (tolerance_rad < 1e-6) continue;  // for its time
#endif
      const ValueMotion motion(body, c.question.torques.in_principal_axes(body.named_from_principal),
                               {tolerance_rad, first_s, last_s});
      double worst = 0.0;
      for (const test::TruthRow& row : c.rows) {
        const double error_rad = 0x1p-52 * test::row_error(motion.at(row.t_s), row).attitude_eps;
        if (!(error_rad <= worst)) worst = error_rad;
      }
      EXPECT_LE(worst, motion.error_rad()) << c.name << " at " << tolerance_rad;
      // Two whose errors grow a million times are not reached in doubles.
      if (tolerance_rad > 1e-9 || (c.name != "ecc-01" && c.name != "envisat-slow-01")) {
        EXPECT_LE(motion.error_rad(), tolerance_rad) << c.name;
      }
      overshoots.push_back(tolerance_rad / worst);
    }
  }
  ASSERT_GE(overshoots.size(), 30u);
  std::nth_element(overshoots.begin(), overshoots.begin() + std::ssize(overshoots) / 2, overshoots.end());
  std::printf("median overshoot %.0f\n", overshoots[overshoots.size() / 2]);
  EXPECT_LT(overshoots[overshoots.size() / 2], 30.0);
}

TEST(ValueMotion, JumpsEndSteps) {
  // From rest, a pulse about the third axis: the angle is known.
  const Vector3 moments(2.0, 3.0, 4.0);
  const FreeBody body{moments, Quaternion::Identity(), Vector3::Zero()};
  const Torques torques({ThrusterPulse{100.0, 7.0, {0.0, 0.0, 0.02}}});
  const ValueMotion motion(body, torques, {1e-9, -50.0, 400.0});
  EXPECT_TRUE(motion.whole());
  const double rate = 0.02 / 4.0;
  for (const double t_s : {-50.0, 0.0, 99.0, 100.0, 103.0, 107.0, 107.5, 399.0}) {
    const double on_s = std::clamp(t_s - 100.0, 0.0, 7.0), after_s = std::max(t_s - 107.0, 0.0);
    const double angle = 0.5 * rate * on_s * on_s + rate * 7.0 * after_s;
    const State state = motion.at(t_s);
    const Quaternion& q = state.q_inertial_from_body;  // its sign goes on, too: twice around is once
    EXPECT_NEAR(std::remainder(2.0 * std::atan2(q.z(), q.w()) - angle, 4.0 * std::numbers::pi), 0.0, 1e-9) << t_s;
    EXPECT_NEAR(state.momentum_body[2], 0.02 * on_s, 1e-12) << t_s;
  }
}

TEST(ValueMotion, BatchesAnswerWhatSingleTimesDo) {
  const ValueMotion motion(satellite(), gravity(0.1), {1e-6, -2000.0, 9000.0});
  std::vector<double> times{8999.0, -2000.0, 0.0, std::numeric_limits<double>::quiet_NaN(), 3.0, 3.1, -0.5, 9000.004};
  for (int i = 0; i < 2000; ++i) times.push_back(-2000.0 + 5.5 * i);
  std::vector<double> q(4 * times.size()), m(3 * times.size());
  motion.batch({times}, StateArrays::of_structures(q.data(), m.data()));
  Quaternion before = motion.at(-2000.0).q_inertial_from_body;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const State state = motion.at(times[i]);
    if (std::isnan(times[i])) {
      EXPECT_TRUE(std::isnan(q[4 * i]) && std::isnan(m[3 * i]));
      continue;
    }
    EXPECT_EQ(Eigen::Map<const Eigen::Vector4d>(&q[4 * i]), scalar_first(state.q_inertial_from_body));
    EXPECT_EQ(Eigen::Map<const Vector3>(&m[3 * i]), state.momentum_body);
    EXPECT_NEAR(state.q_inertial_from_body.norm(), 1.0, 4e-16);
    if (i < 8) continue;
    EXPECT_GT(state.q_inertial_from_body.dot(before), 0.9);  // 0.25 rad apart at most
    before = state.q_inertial_from_body;
  }
  EXPECT_THROW(motion.at(9000.01), InputError);
  EXPECT_THROW(motion.at(-2001.0), InputError);
}

TEST(ValueMotion, SpansWithoutLengthAndToOneSide) {
  const FreeBody body = satellite();
  const ValueMotion nothing(body, gravity(), {1e-9, 0.0, 0.0});
  EXPECT_LT(rotation_angle_rad(nothing.at(0.0).q_inertial_from_body, body.q_inertial_from_body), 1e-15);
  const ValueMotion past(body, gravity(), {1e-9, -500.0, 0.0}), future(body, gravity(), {1e-9, 0.0, 500.0});
  EXPECT_LT(rotation_angle_rad(past.at(0.004).q_inertial_from_body, future.at(0.004).q_inertial_from_body), 1e-9);
  EXPECT_LT(rotation_angle_rad(past.at(-0.004).q_inertial_from_body, future.at(-0.004).q_inertial_from_body), 1e-9);
  EXPECT_THROW(ValueMotion(body, gravity(), {0.0, 0.0, 1.0}), InputError);
  EXPECT_THROW(ValueMotion(body, gravity(), {1e-6, 1.0, 2.0}), InputError);
}

TEST(ValueMotion, TheLimitOfEvaluationsEndsIt) {
  const ValueMotion early(satellite(), gravity(), {1e-9, 0.0, 1e5, 5000});
  EXPECT_FALSE(early.whole());
  EXPECT_LT(early.last_s(), 1e5);
  EXPECT_GT(early.last_s(), 0.0);
  EXPECT_LE(early.evaluations(), 5100u);
  EXPECT_NO_THROW(early.at(early.last_s()));
  EXPECT_FALSE(early.error_rad() < 1.0);
  // A run before was whole: it stays, with what is known of it.
  const ValueMotion enough(satellite(), gravity(), {1e-9, 0.0, 1e4});
  const ValueMotion late(satellite(), gravity(),
                         {1e-9, 0.0, 1e4, enough.evaluations() - enough.kept_evaluations() / 2});
  EXPECT_FALSE(late.whole());
  EXPECT_EQ(late.last_s(), 1e4);
  EXPECT_FALSE(late.error_rad() <= 1e-9);
  EXPECT_LE(worst_rad(late, enough, 0.0, 1e4), late.error_rad());
}

TEST(ValueMotion, FacetsKeepTheirPromise) {
  const Torques torques({Sunlight(box_satellite(), {0.3, 0.5}, kSunWay)});
  ASSERT_TRUE(torques.has_edges());
  const FreeBody body = satellite({0.004, 0.003, 0.012});
  constexpr double last_s = 40000.0;
  const ValueMotion truth(body, torques, {1e-9, 0.0, last_s});
  ASSERT_LE(truth.error_rad(), 1e-9);
  for (const double tolerance_rad : {1e-3, 1e-5, 1e-7}) {
    const ValueMotion motion(body, torques, {tolerance_rad, 0.0, last_s});
    const double worst = worst_rad(motion, truth, 0.0, last_s);
    std::printf("36 facets to %g rad: off by %.1e, claimed %.1e, %zu evaluations\n", tolerance_rad, worst,
                motion.error_rad(), motion.evaluations());
    EXPECT_LE(motion.error_rad(), tolerance_rad);
    EXPECT_LE(worst, motion.error_rad() + truth.error_rad());
    // Facets that come into the light do not shorten the steps.
    const ValueMotion smooth(body, {}, {tolerance_rad, 0.0, last_s});
    EXPECT_LT(motion.kept_evaluations(), 2 * smooth.kept_evaluations());
  }
}

}  // namespace
}  // namespace polhode
