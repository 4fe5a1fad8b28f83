// Invariants and periods: published bodies, and random ones against a plain integration of Euler's equations.
#include "polhode/body/invariants.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/body/spin_solution.hpp"
#include "polhode/read/body.hpp"

namespace polhode {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180.0;

Inertia inertia_of(const Vector3& moments) { return inertia_from_moments(moments, false); }

Body shipped(const char* name) { return read_body(std::string(POLHODE_DATA_DIR) + "/bodies/" + name); }

// Momentum after `time` by the classical Runge-Kutta method, and the turns of axis k about L so far: the axis' azimuth
// changes at L (2E - m_k^2/I_k) / (L^2 - m_k^2).
struct Integrated {
  Vector3 momentum;
  Vector3 turns_rad;
};
Integrated integrate(const Vector3& moments, const Vector3& start, double time, int steps) {
  const auto rate = [&](const Vector3& m) { return Vector3(m.cross(m.cwiseQuotient(moments))); };
  const auto azimuth_rate = [&](const Vector3& m) {
    const double twice_energy = m.dot(m.cwiseQuotient(moments)), square = m.squaredNorm();
    Vector3 out;
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      out[k] = std::sqrt(square) * (twice_energy - m[k] * m[k] / moments[k]) / (m[a] * m[a] + m[b] * m[b]);
    }
    return out;
  };
  const double h = time / steps;
  Integrated out{start, Vector3::Zero()};
  for (int n = 0; n < steps; ++n) {
    const Vector3 m = out.momentum;
    const Vector3 k1 = rate(m), m2 = m + 0.5 * h * k1;
    const Vector3 k2 = rate(m2), m3 = m + 0.5 * h * k2;
    const Vector3 k3 = rate(m3), m4 = m + h * k3;
    out.turns_rad += h / 6.0 * (azimuth_rate(m) + 2.0 * azimuth_rate(m2) + 2.0 * azimuth_rate(m3) + azimuth_rate(m4));
    out.momentum += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(m4));
  }
  return out;
}

TEST(Invariants, Toutatis) {
  const Body body = shipped("toutatis.toml");
  const SpinInvariants spin = spin_invariants(*body.inertia, momentum_principal(body));
  EXPECT_EQ(spin.mode, RotationMode::long_axis);
  EXPECT_NEAR(*spin.polhode_period_s / 86400.0, 5.3685, 5e-5);
  EXPECT_NEAR(spin.long_axis->precession_period_s / 86400.0, 7.4117, 5e-5);
  const Vector3 momentum = momentum_in_frame(body, Frame::ecliptic_j2000).normalized();
  EXPECT_NEAR(std::atan2(momentum.y(), momentum.x()) / degree + 360.0, 181.03, 0.005);
  EXPECT_NEAR(std::asin(momentum.z()) / degree, -53.62, 0.005);
  EXPECT_LT((momentum_in_frame(body, Frame::icrf) -
             q_icrf_from(Frame::ecliptic_j2000) * momentum_in_frame(body, Frame::ecliptic_j2000))
                .norm(),
            1e-15 * spin.momentum);
}

TEST(Invariants, ApophisHasThePublishedPeriods) {
  const Body body = shipped("apophis.toml");
  const SpinInvariants spin = spin_invariants(*body.inertia, momentum_principal(body));
  EXPECT_EQ(spin.mode, RotationMode::short_axis);
  EXPECT_NEAR(*spin.polhode_period_s / 3600.0, 264.178, 1e-7);
  EXPECT_NEAR(spin.long_axis->precession_period_s / 3600.0, 27.38547, 1e-8);
  EXPECT_NEAR(spin.energy_above_ground, 0.0188, 5e-5);
  const Vector3 momentum = momentum_in_frame(body, Frame::ecliptic_j2000).normalized();
  EXPECT_NEAR(std::atan2(momentum.y(), momentum.x()) / degree + 360.0, 275.0, 1e-8);
  EXPECT_NEAR(std::asin(momentum.z()) / degree, -85.0, 1e-9);
}

TEST(Invariants, PeriodsAndAnglesAgreeWithIntegration) {
  std::mt19937_64 random(1758);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  double worst_closing = 0.0, worst_turn = 0.0, worst_angle = 0.0;
  for (int i = 0; i < 24; ++i) {
    const double i1 = std::pow(10.0, -1.0 * uniform(random));
    const Vector3 moments(i1, 1.0, 1.0 + i1 * uniform(random) * (i % 4 == 0 ? 0.01 : 1.0));
    Vector3 start = Vector3(normal(random), normal(random), normal(random)).normalized();
    if (i % 3 == 0) start = Vector3(0.05 * normal(random), 1.0, 0.05 * normal(random)).normalized();
    const SpinInvariants spin = spin_invariants(inertia_of(moments), start);
    ASSERT_TRUE(spin.polhode_period_s && spin.long_axis && spin.short_axis);
    const int steps = 20000;
    const double period = *spin.polhode_period_s;
    const Integrated end = integrate(moments, start, period, steps);
    const double closing = (end.momentum - start).norm();
    const Vector3 turns(period / spin.long_axis->precession_period_s, 0.0,
                        period / spin.short_axis->precession_period_s);
    const double turn = std::max(std::abs(end.turns_rad[0] / (2.0 * pi) - turns[0]),
                                 std::abs(end.turns_rad[2] / (2.0 * pi) - turns[2]));
    ASSERT_TRUE(std::isfinite(closing) && std::isfinite(turn));
    worst_closing = std::max(worst_closing, closing);
    worst_turn = std::max(worst_turn, turn / turns[0]);
    // Extreme angles: along the polhode, at steps of its 4000th.
    double least[3] = {pi, pi, pi}, greatest[3] = {};
    Vector3 m = start;
    for (int n = 0; n < 4000; ++n) {
      m = integrate(moments, m, period / 4000, 4).momentum;
      for (int k = 0; k < 3; k += 2) {
        const double angle = std::atan2(std::hypot(m[(k + 1) % 3], m[(k + 2) % 3]), m[k]);
        least[k] = std::min(least[k], angle);
        greatest[k] = std::max(greatest[k], angle);
      }
    }
    for (int k = 0; k < 3; k += 2) {
      if (least[k] > 0.5 * pi) {  // the other end of the axis is nearer
        std::swap(least[k], greatest[k]);
        least[k] = pi - least[k];
        greatest[k] = pi - greatest[k];
      }
      const AxisMotion& axis = k == 0 ? *spin.long_axis : *spin.short_axis;
      worst_angle = std::max(
          {worst_angle, std::abs(axis.least_angle_rad - least[k]), std::abs(axis.greatest_angle_rad - greatest[k])});
    }
  }
  EXPECT_LT(worst_closing, 3e-12);
  EXPECT_LT(worst_turn, 1e-12);
  EXPECT_LT(worst_angle, 1e-4);
}

TEST(Invariants, BothSeriesAgreeWhereTheyMeet) {
  // Continuity of rho through the switch of series: the mean rate over tiny changes of the state.
  const Inertia inertia = inertia_of({1.0, 2.0, 2.5});
  double before = 0.0;
  double worst = 0.0;
  for (int i = 0; i <= 4000; ++i) {
    const double angle = 0.2 + 1e-4 * i;
    const auto spin = spin_invariants(inertia, {std::sin(angle) * 0.3, std::cos(angle), std::sin(angle)});
    if (spin.mode != RotationMode::short_axis) continue;
    const double rate = 1.0 / spin.long_axis->precession_period_s;
    if (before != 0.0) worst = std::max(worst, std::abs(rate - before));
    before = rate;
  }
  EXPECT_NE(before, 0.0);
  EXPECT_LT(worst, 1e-3);
}

TEST(Invariants, SymmetricTops) {
  // Oblate: the short axis precesses at L/I1, the polhode turns at L_3 (1/I1 - 1/I3); one constant angle.
  const Vector3 m(0.3, 0.4, 1.2);
  const SpinInvariants oblate = spin_invariants(inertia_of({1.0, 1.0, 1.5}), m);
  EXPECT_EQ(oblate.mode, RotationMode::short_axis);
  EXPECT_NEAR(oblate.short_axis->precession_period_s, 2.0 * pi * 1.0 / 1.3, 1e-14);
  EXPECT_NEAR(*oblate.polhode_period_s, 2.0 * pi / (1.2 * (1.0 - 1.0 / 1.5)), 1e-13);
  EXPECT_NEAR(oblate.short_axis->least_angle_rad, std::atan2(0.5, 1.2), 1e-15);
  EXPECT_NEAR(oblate.short_axis->greatest_angle_rad, std::atan2(0.5, 1.2), 1e-15);
  EXPECT_EQ(*oblate.separatrix_distance, 1.0);
  const SpinInvariants prolate = spin_invariants(inertia_of({0.5, 1.0, 1.0}), {1.2, 0.3, -0.4});
  EXPECT_EQ(prolate.mode, RotationMode::long_axis);
  EXPECT_NEAR(prolate.long_axis->precession_period_s, 2.0 * pi * 1.0 / 1.3, 1e-14);
  EXPECT_NEAR(*prolate.polhode_period_s, 2.0 * pi / (1.2 * (1.0 / 0.5 - 1.0)), 1e-13);
}

TEST(Invariants, Separatrix) {
  // I = 1, 2, 3 with m1^2 (I2 - I1)/I1 = m3^2 (I3 - I2)/I3: m1^2 : m3^2 = 1 : 3, as near as doubles come.
  const SpinInvariants on = spin_invariants(inertia_of({1.0, 2.0, 3.0}), {0.5, 1.0, 0.5 * std::sqrt(3.0)});
  EXPECT_EQ(on.mode, RotationMode::separatrix);
  EXPECT_TRUE(std::isinf(*on.polhode_period_s));
  EXPECT_NEAR(on.long_axis->precession_period_s, 2.0 * pi * 2.0 / on.momentum, 1e-12);  // 2 rho = L/I2
  const SpinInvariants near = spin_invariants(inertia_of({1.0, 2.0, 3.0}), {0.5, 1.0, 0.5 * std::sqrt(3.0) + 1e-9});
  EXPECT_EQ(near.mode, RotationMode::short_axis);
  EXPECT_LT(*near.separatrix_distance, 1e-8);
  EXPECT_GT(*near.polhode_period_s, 20.0);
}

TEST(Invariants, MotionsWithoutTumbling) {
  const Inertia triaxial = inertia_of({1.0, 2.0, 2.5});
  EXPECT_EQ(spin_invariants(triaxial, Vector3::Zero()).mode, RotationMode::rest);
  for (int k = 0; k < 3; ++k) {
    const SpinInvariants spin = spin_invariants(triaxial, -3.0 * Vector3::Unit(k));
    EXPECT_EQ(spin.mode, RotationMode::principal_axis);
    EXPECT_EQ(spin.rotation_axis, k);
    EXPECT_NEAR(*spin.rotation_period_s, 2.0 * pi / 3.0 * triaxial.principal_moments[k], 1e-14);
    EXPECT_FALSE(spin.polhode_period_s);
  }
  EXPECT_EQ(spin_invariants(inertia_of({2, 2, 2}), {1, 2, 3}).mode, RotationMode::sphere);
  EXPECT_EQ(spin_invariants(inertia_of({1, 1, 1.5}), {1, 2, 0}).mode, RotationMode::principal_axis);
  EXPECT_EQ(spin_invariants(triaxial, {0, 1e-200, 1}).mode, RotationMode::short_axis);
  EXPECT_NEAR(spin_invariants(triaxial, {0, 0, 1}).energy_above_ground, 0.0, 0.0);
  EXPECT_NEAR(spin_invariants(triaxial, {1, 0, 0}).energy_above_ground, 1.5, 1e-15);
}

TEST(Invariants, ScalesDropOut) {
  const Vector3 m(0.3, -0.7, 0.9), moments(1.0, 2.0, 2.2);
  const SpinInvariants plain = spin_invariants(inertia_of(moments), m);
  for (const double scale : {1e-120, 1e120}) {
    const SpinInvariants scaled = spin_invariants(inertia_of(scale * moments), scale * m);
    EXPECT_NEAR(*scaled.polhode_period_s / *plain.polhode_period_s, 1.0, 1e-14);
    EXPECT_NEAR(scaled.long_axis->precession_period_s / plain.long_axis->precession_period_s, 1.0, 1e-14);
    EXPECT_NEAR(*scaled.separatrix_distance / *plain.separatrix_distance, 1.0, 1e-14);
  }
}

TEST(Invariants, WhatDoublesDoNotHoldIsRefused) {
  EXPECT_THROW(spin_invariants(inertia_of({1e-240, 1, 1}), {1, 2, 3}), InputError);
  EXPECT_THROW(spin_invariants(inertia_of({1e308, 1e308, 1e308}), {1, 2, 3}), InputError);
  EXPECT_THROW(spin_invariants(inertia_of({1, 2, 2.2}), {1e-310, 1e-312, 0}), InputError);
  EXPECT_THROW(spin_invariants(inertia_of({1, 2, 2.2}), {0, 0, 1e308}), InputError);
  EXPECT_THROW(spin_invariants(inertia_of({1, 2, 2.2}), {0, 0, 1e200}), InputError);  // its energy is none
}

TEST(Invariants, WhatIsMissingIsNamed) {
  Body body;
  EXPECT_THROW(momentum_principal(body), InputError);
  body.inertia = inertia_of({1, 2, 2});
  EXPECT_THROW(momentum_principal(body), InputError);
  body.state = SpinState{};
  body.state->omega_named_rad_s = Vector3::UnitX();
  EXPECT_EQ(momentum_principal(body), Vector3::UnitX());
  EXPECT_THROW(momentum_in_frame(body, Frame::icrf), InputError);
}

}  // namespace
TEST(Invariants, FrequenciesOfALightCurve) {
  // Apophis (Lee et al. 2022): the main period of the light curve is 1/(1/P_phi - 1/P_psi) = 30.55 h, published by
  // half.
  const polhode::Inertia inertia = polhode::inertia_from_moments({0.64, 0.97, 1.0}, false);
  const auto solutions =
      polhode::solve_periods(inertia, {polhode::AxisConvention::long_axis, 27.38547 * 3600, 264.178 * 3600, false});
  const auto all =
      polhode::light_curve_frequencies(polhode::spin_invariants(inertia, solutions.at(0).momentum_at_psi_zero));
  ASSERT_EQ(all.size(), 5U);
  EXPECT_STREQ(all[3].name, "2/P_phi - 2/P_psi");
  EXPECT_NEAR(2.0 / all[3].per_s / 3600, 1.0 / (1.0 / 27.38547 - 1.0 / 264.178), 1e-6);
  EXPECT_NEAR(2.0 / all[1].per_s / 3600, 27.38547, 1e-6);
  EXPECT_TRUE(polhode::light_curve_frequencies(polhode::spin_invariants(inertia, {0, 0, 1})).empty());
}

}  // namespace polhode
