// Inertia, Euler angles and the free body of a file, against their definitions.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "polhode/base/error.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/motion/free_body.hpp"

namespace polhode {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double degree = std::numbers::pi / 180.0;

Matrix3 rebuilt(const Inertia& inertia) {
  return inertia.named_from_principal * inertia.principal_moments.asDiagonal() *
         inertia.named_from_principal.transpose();
}

TEST(Inertia, DiagonalTensorsArePermutedExactly) {
  const std::vector<Vector3> cases = {{1, 2, 3}, {1, 3, 2}, {2, 1, 3}, {2, 3, 1}, {3, 1, 2},
                                      {3, 2, 1}, {2, 2, 2}, {2, 3, 2}, {3, 2, 2}, {0.1, 0.3, 0.30000000000000004}};
  for (const Vector3& named : cases) {
    const Inertia inertia = inertia_from_moments(named, false);
    EXPECT_EQ(rebuilt(inertia), Matrix3(named.asDiagonal())) << named.transpose();
    EXPECT_EQ(inertia.named_from_principal.determinant(), 1.0);
    EXPECT_LE(inertia.principal_moments[0], inertia.principal_moments[1]);
    EXPECT_LE(inertia.principal_moments[1], inertia.principal_moments[2]);
    for (int i = 0; i < 9; ++i) {
      const double element = inertia.named_from_principal(i);
      EXPECT_TRUE(element == 0.0 || std::abs(element) == 1.0);
    }
  }
  EXPECT_EQ(inertia_from_moments({1, 2, 3}, false).named_from_principal, Matrix3(Matrix3::Identity()));
}

TEST(Inertia, TensorsAreRebuiltAlsoWhenNearlyDegenerate) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double split = std::pow(10.0, -18.0 * uniform(random));
    const double i1 = std::pow(10.0, -6.0 * uniform(random));
    const double least = i % 3 == 0 ? 1.0 - 0.9 * split : i1;
    const Vector3 moments(least, 1.0, 1.0 + 0.9 * split * least);
    const Quaternion q = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
    const Matrix3 turned = q.toRotationMatrix() * moments.asDiagonal() * q.toRotationMatrix().transpose();
    const Matrix3 tensor = turned.selfadjointView<Eigen::Upper>();
    const Inertia inertia = inertia_from_tensor(tensor, true);
    const double error = (rebuilt(inertia) - tensor).norm();
    const double askew =
        (inertia.named_from_principal.transpose() * inertia.named_from_principal - Matrix3::Identity()).norm();
    ASSERT_TRUE(std::isfinite(error) && std::isfinite(askew));
    worst = std::max({worst, error, askew});
    ASSERT_GT(inertia.named_from_principal.determinant(), 0.0);
  }
  EXPECT_LT(worst, 12 * eps);
}

TEST(Inertia, EnvisatPrincipalMoments) {
  // Published tensor; principal moments published on their own by users of the DSPOSE deck (data/README.md).
  const Matrix3 tensor =
      inertia_tensor({17023.3, 124825.7, 129112.2}, {397.1, -2171.4, 344.2}, ProductsOfInertia::tensor_elements);
  const Inertia inertia = inertia_from_tensor(tensor, true);
  EXPECT_NEAR(inertia.principal_moments[0], 16979.74, 0.005);
  EXPECT_NEAR(inertia.principal_moments[1], 124801.21, 0.005);
  EXPECT_NEAR(inertia.principal_moments[2], 129180.25, 0.005);
  EXPECT_EQ(inertia_tensor({1, 2, 3}, {4, 5, 6}, ProductsOfInertia::positive_integrals)(0, 2), -5.0);
}

TEST(Inertia, EllipsoidOfTheSameInertia) {
  // Semi-axes 3, 2, 1: moments b^2 + c^2, a^2 + c^2, a^2 + b^2 (times mass / 5).
  const Vector3 ratios = equivalent_ellipsoid_ratios(inertia_from_moments({5, 10, 13}, false));
  EXPECT_LT((ratios - Vector3(1.0, 2.0 / 3.0, 1.0 / 3.0)).norm(), 2 * eps);
  EXPECT_EQ(equivalent_ellipsoid_ratios(inertia_from_moments({1, 1, 2}, false))[2], 0.0) << "a disc";
}

TEST(Inertia, TheImpossibleIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(inertia_from_moments({1, 2, 3.001}, false), InputError);
  EXPECT_THROW(inertia_from_moments({-1, 2, 2}, false), InputError);
  EXPECT_THROW(inertia_from_moments({0, 2, 2}, false), InputError);
  EXPECT_THROW(inertia_from_moments({nan, 2, 2}, false), InputError);
  EXPECT_THROW(inertia_from_moments({1, 2, INFINITY}, false), InputError);
  EXPECT_THROW(inertia_from_tensor(inertia_tensor({2, 2, 2}, {3, 0, 0}, ProductsOfInertia::tensor_elements), false),
               InputError);
  EXPECT_NO_THROW(inertia_from_moments({1, 2, 3 * (1 + 1e-10)}, false)) << "a lamina, rounded";
  EXPECT_NO_THROW(inertia_from_moments({1e-300, 1e-300, 1e-300}, false));
  EXPECT_NO_THROW(inertia_from_moments({1e300, 1e300, 1e300}, false));
}

TEST(Euler, EverySequenceGoesRound) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  double worst = 0.0;
  for (const char* name : {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "XYX", "XZX", "YXY", "YZY", "ZXZ", "ZYZ"}) {
    const EulerSequence sequence(name);
    EXPECT_EQ(sequence.name(), name);
    for (int i = 0; i < 500; ++i) {
      Quaternion q = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
      if (i % 5 == 0) {  // on and beside the singularity
        const double off = i % 2 == 0 ? 0.0 : 1e-9 * normal(random);
        q = q_frame_from_body(
            sequence, {normal(random), (sequence.proper() ? 0.0 : 0.5 * std::numbers::pi) + off, normal(random)});
      }
      const Vector3 angles = euler_angles_rad(sequence, q);
      const double error = rotation_angle_rad(q_frame_from_body(sequence, angles), q);
      ASSERT_TRUE(std::isfinite(error));
      worst = std::max(worst, error);
      ASSERT_GE(angles[1], sequence.proper() ? 0.0 : -0.5 * std::numbers::pi);
      ASSERT_LE(angles[1], (sequence.proper() ? 1.0 : 0.5) * std::numbers::pi);
    }
  }
  EXPECT_LT(worst, 1e-14);
}

TEST(Euler, NinetyDegreesAboutZ) {
  // A body turned by +90 deg about the frame's z has its x axis along the frame's y.
  const Quaternion q = q_frame_from_body(EulerSequence("ZXZ"), {90.0 * degree, 0.0, 0.0});
  EXPECT_LT((q * Vector3::UnitX() - Vector3::UnitY()).norm(), 2 * eps);
  // Then +90 deg about the body's own x: its y axis points to the frame's z.
  const Quaternion both = q_frame_from_body(EulerSequence("313"), {90.0 * degree, 90.0 * degree, 0.0});
  EXPECT_LT((both * Vector3::UnitY() - Vector3::UnitZ()).norm(), 3 * eps);
}

TEST(Euler, RatesAreTheDerivative) {
  const Vector3 angles(0.3, 0.7, -1.1), rates(0.2, -0.5, 0.9);
  const double h = 1e-5;
  for (const char* name : {"ZXZ", "XYZ", "ZYX", "YXY"}) {
    const EulerSequence sequence(name);
    const Quaternion later = q_frame_from_body(sequence, angles + h * rates);
    const Quaternion earlier = q_frame_from_body(sequence, angles - h * rates);
    const Vector3 omega = 2.0 * (earlier.conjugate() * later).vec() / (2.0 * h);
    EXPECT_LT((omega_body_rad_s(sequence, angles, rates) - omega).norm(), 1e-9) << name;
  }
}

TEST(Euler, BadSequencesAreRefused) {
  for (const char* name : {"", "ZZX", "ZXX", "ZX", "ZXZX", "ABC", "310", "zx "}) {
    EXPECT_THROW(EulerSequence{name}, InputError) << name;
  }
}

TEST(FreeBody, AnglesMomentumAndFramesAreThoseOfTheNamedAxes) {
  Body body;
  body.inertia = inertia_from_moments({3.0836, 3.235, 1.0}, false);
  body.state = SpinState{};
  body.state->frame = Frame::ecliptic_j2000;
  body.state->q_frame_from_named = q_frame_from_body(EulerSequence("ZXZ"), Vector3(145.498, 65.865, 241.524) * degree);
  body.state->omega_named_rad_s = Vector3(14.51, 33.529, -98.709) * degree / 86400.0;
  const FreeBody ecliptic = free_body(body, Frame::ecliptic_j2000);
  EXPECT_EQ(ecliptic.principal_moments, Vector3(1.0, 3.0836, 3.235));
  // Principal axes are z, x, y of the file: bit for bit.
  EXPECT_EQ(ecliptic.momentum_body[0], -98.709 * degree / 86400.0);
  // The long axis, the file's z, points where the angles say.
  const Vector3 long_axis = ecliptic.q_inertial_from_body * Vector3::UnitX();
  const Vector3 published(std::sin(145.498 * degree) * std::sin(65.865 * degree),
                          -std::cos(145.498 * degree) * std::sin(65.865 * degree), std::cos(65.865 * degree));
  EXPECT_LT((long_axis - published).norm(), 4 * eps);
  const Vector3 momentum = ecliptic.q_inertial_from_body * ecliptic.momentum_body;
  EXPECT_NEAR(std::atan2(momentum.y(), momentum.x()) / degree + 360.0, 181.03, 0.005);
  EXPECT_NEAR(std::asin(momentum.z() / momentum.norm()) / degree, -53.62, 0.005);
  const FreeBody icrf = free_body(body);
  EXPECT_LT((icrf.q_inertial_from_body * icrf.momentum_body - q_icrf_from(Frame::ecliptic_j2000) * momentum).norm(),
            4 * eps * momentum.norm());
}

TEST(FreeBody, ExactRotationAboutTheMiddleAxisStaysExact) {
  Body body;
  body.inertia = inertia_from_moments({5.0, 3.0, 4.0}, false);  // z is the middle axis
  body.state = SpinState{};
  body.state->q_frame_from_named = Quaternion::Identity();
  body.state->omega_named_rad_s = Vector3(0.0, 0.0, 0.1);
  const Vector3 momentum = free_body(body).momentum_body;
  EXPECT_EQ(momentum[0], 0.0);
  EXPECT_EQ(momentum[2], 0.0);
  EXPECT_EQ(std::abs(momentum[1]), 0.4);
}

TEST(FreeBody, TemeIsTakenAsItStandsAtTheEpoch) {
  Body body;
  body.inertia = inertia_from_moments({1, 2, 2}, false);
  body.state = SpinState{};
  body.state->epoch = parse_date("2020-06-01", TimeScale::utc);
  body.state->frame = Frame::teme;
  body.state->q_frame_from_named = Quaternion::Identity();
  body.state->omega_named_rad_s = Vector3::UnitX();
  EXPECT_LT(rotation_angle_rad(free_body(body).q_inertial_from_body, q_icrf_from(Frame::teme, body.state->epoch)),
            4 * eps);
  EXPECT_THROW(free_body(body, Frame::teme), InputError);
}

TEST(FreeBody, WhatIsMissingIsNamed) {
  Body body;
  EXPECT_THROW(free_body(body), InputError);
  body.inertia = inertia_from_moments({1, 2, 2}, false);
  EXPECT_THROW(free_body(body), InputError);
  body.state = SpinState{};
  body.state->q_frame_from_named = Quaternion::Identity();
  EXPECT_THROW(free_body(body), InputError);
  body.state->omega_named_rad_s = Vector3::Zero();
  EXPECT_NO_THROW(free_body(body));
}

}  // namespace
}  // namespace polhode
