// Spin states of asteroids as published: periods to energy, DAMIT, SHAPE, and the body file's tables for them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "polhode/base/error.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/body/spin_solution.hpp"
#include "polhode/read/asteroid_files.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/body_file.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
const std::string samples = POLHODE_DATA_DIR "/samples/";

double published_energy(const Vector3& moments, double precession, double rotation) {
  return solve_periods(inertia_from_moments(moments, false), {AxisConvention::long_axis, precession, rotation, false})
      .at(0)
      .energy;
}

std::string fault_of(const std::string& toml) {
  try {
    parse_body_file(toml, "b");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SpinSolution, PublishedPeriodsGiveTheEnergyOfTheFacts) {
  EXPECT_NEAR(published_energy({0.64, 0.97, 1.0}, 27.38547, 264.178), 1.0188, 5e-5);  // Apophis, Lee et al. 2022
  EXPECT_NEAR(published_energy({0.61, 0.965, 1.0}, 27.38, 263.0), 1.0285, 5e-5);      // Apophis, Pravec et al. 2014
  EXPECT_NEAR(published_energy({0.36, 0.96, 1.0}, 67.27, 368.7), 1.034, 5e-4);        // Krylov, Lee et al. 2020
}

TEST(SpinSolution, IsTheInverseOfThePeriods) {
  for (const bool long_mode : {false, true}) {
    for (const auto convention : {AxisConvention::long_axis, AxisConvention::short_axis}) {
      const Inertia inertia = inertia_from_moments({1.0, 3.0, 3.3}, false);
      // L of size 2 in the plane of long and short axis, on either side of the separatrix.
      const double angle = (long_mode ? 60.0 : 8.0) * degree;
      const Vector3 momentum = 2.0 * Vector3(std::sin(angle), 0.0, std::cos(angle));
      const SpinInvariants spin = spin_invariants(inertia, momentum);
      ASSERT_EQ(spin.mode, long_mode ? RotationMode::long_axis : RotationMode::short_axis);
      const AxisMotion& axis = convention == AxisConvention::long_axis ? *spin.long_axis : *spin.short_axis;
      const SpinSolution s =
          solve_periods(inertia, {convention, axis.precession_period_s, *spin.polhode_period_s, long_mode}).at(0);
      EXPECT_NEAR(s.energy, 1.0 + spin.energy_above_ground, 1e-9);
      EXPECT_NEAR(s.momentum, 2.0, 1e-9);
      // A state with angles: its energy and the direction of L are those asked for.
      const double psi = (long_mode ? 40.0 : 3.0) * degree;
      if (convention == AxisConvention::short_axis && long_mode) continue;  // psi swings about 90 deg there
      const EulerState at = state_at(inertia, convention, s, 0.7, psi, false);
      EXPECT_NEAR(at.momentum_principal.norm(), 2.0, 1e-9);
      const Vector3 squares = at.momentum_principal.cwiseProduct(at.momentum_principal);
      EXPECT_NEAR(squares.cwiseQuotient(inertia.principal_moments).sum(), spin.twice_energy, 1e-8);
      EXPECT_LT((at.q_momentum_from_principal * at.momentum_principal - Vector3(0, 0, s.momentum)).norm(), 1e-12);
    }
  }
  EXPECT_EQ(
      solve_periods(inertia_from_moments({0.64, 0.97, 1.0}, false), {AxisConvention::long_axis, 27.38547, 264.178, {}})
          .size(),
      2U);
  EXPECT_THROW(published_energy({0.64, 0.97, 1.0}, 27.38547, 30.0), InputError);
  EXPECT_THROW(published_energy({0.9, 0.9, 0.9}, 27.0, 260.0), InputError);
}

// Along the symmetry axis I_s, across it I_t: dphi/dt = L/I_t, |dpsi/dt| = L cos(theta) |1/I_s - 1/I_t|.
TEST(SpinSolution, SymmetricBodiesMoveByTheirDefiningEquations) {
  struct Case {
    Vector3 moments;
    AxisConvention convention;
    int symmetry_axis;
    double precession_s, rotation_s;
  };
  const double slender = 35.0 * 35.0, thick = 0.5 * (230.0 * 230.0 + slender);
  for (const Case& c : {Case{{slender, thick, thick}, AxisConvention::long_axis, 0, 8.67 * 3600.0, 54.48 * 3600.0},
                        Case{{1.0, 1.5, 1.5}, AxisConvention::long_axis, 0, 10.0, 21.0},
                        Case{{2.0, 2.0, 3.0}, AxisConvention::short_axis, 2, 10.0, 31.0},
                        Case{{2.0, 2.0, 2.1}, AxisConvention::short_axis, 2, 10.0, 1000.0}}) {
    const Inertia inertia = inertia_from_moments(c.moments, false);
    const std::vector<SpinSolution> solutions =
        solve_periods(inertia, {c.convention, c.precession_s, c.rotation_s, std::nullopt});
    ASSERT_EQ(solutions.size(), 1U);
    const SpinSolution& s = solutions[0];
    EXPECT_EQ(s.long_axis_mode, c.symmetry_axis == 0);
    const double along = c.moments[c.symmetry_axis], across = c.moments[1];
    const double cosine = s.momentum_at_psi_zero[c.symmetry_axis] / s.momentum;
    EXPECT_NEAR(2.0 * std::numbers::pi * across / s.momentum, c.precession_s, 1e-13 * c.precession_s);
    EXPECT_NEAR(2.0 * std::numbers::pi / (s.momentum * cosine * std::abs(1.0 / along - 1.0 / across)), c.rotation_s,
                1e-12 * c.rotation_s);
    EXPECT_NEAR(s.momentum_at_psi_zero.norm(), s.momentum, 1e-14 * s.momentum);
    const Vector3 omega = s.momentum_at_psi_zero.cwiseQuotient(c.moments);
    EXPECT_NEAR(omega.dot(s.momentum_at_psi_zero) * c.moments[2] / (s.momentum * s.momentum), s.energy, 1e-14);
    const SpinInvariants spin = spin_invariants(inertia, s.momentum_at_psi_zero);
    EXPECT_NEAR(*spin.polhode_period_s, c.rotation_s, 1e-12 * c.rotation_s);
    // Any psi: theta stays.
    for (const double psi : {0.0, 0.7, 2.0}) {
      const EulerState state = state_at(inertia, c.convention, s, 0.3, psi, false);
      EXPECT_NEAR(std::cos(state.theta_rad), cosine, 1e-12);
      EXPECT_NEAR(state.momentum_principal[c.symmetry_axis], s.momentum * cosine, 1e-12 * s.momentum);
    }
  }
}

TEST(SpinSolution, WhatSymmetricBodiesCannotDoIsRefused) {
  const auto fault = [](const Vector3& moments, AxisConvention convention, double ratio,
                        std::optional<bool> long_mode) {
    try {
      solve_periods(inertia_from_moments(moments, false), {convention, 1.0, ratio, long_mode});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(fault({1.0, 1.5, 1.5}, AxisConvention::long_axis, 1.9, {}).find("it is 2 / cos(theta)"), std::string::npos);
  EXPECT_NE(fault({1.0, 1.5, 1.5}, AxisConvention::long_axis, 2.5, false).find("long-axis mode only"),
            std::string::npos);
  EXPECT_NE(fault({2.0, 2.0, 3.0}, AxisConvention::short_axis, 3.5, true).find("short-axis mode only"),
            std::string::npos);
  EXPECT_NE(fault({2.0, 2.0, 2.0}, AxisConvention::short_axis, 3.5, {}).find("sphere"), std::string::npos);
  EXPECT_EQ(fault({2.0, 2.0, 3.0}, AxisConvention::short_axis, 3.5, {}), "accepted");
}

// The axis that precesses need not be the symmetry axis: then the periods are those that info gives.
TEST(SpinSolution, SymmetricBodiesByTheirOtherAxis) {
  for (const bool prolate : {true, false}) {
    const Inertia inertia = inertia_from_moments(prolate ? Vector3(1.0, 1.5, 1.5) : Vector3(2.0, 2.0, 3.0), false);
    const SpinInvariants spin = spin_invariants(inertia, {0.6, 0.0, 0.8});
    const AxisConvention convention = prolate ? AxisConvention::short_axis : AxisConvention::long_axis;
    const AxisMotion& axis = prolate ? *spin.short_axis : *spin.long_axis;
    const auto found = solve_periods(inertia, {convention, axis.precession_period_s, *spin.polhode_period_s, {}});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(found[0].momentum, 1.0, 1e-9);
    EXPECT_NEAR(found[0].energy, 1.0 + spin.energy_above_ground, 1e-9);
  }
}

TEST(BodyFile, OumuamuaAsASymmetricBody) {
  const Body body = parse_body_file(
      "name='1I'\n[inertia]\nsemi_axes=[230,35,35]\n[spin]\nepoch='JD 2458051.5 UTC'\nframe='ECLIPJ2000'\n"
      "unit='deg'\nlambda=20\nbeta=30\nconvention='long-axis'\nP_phi=8.67\nP_psi=54.48\nperiod_unit='h'\nphi0=10\n"
      "psi0=40\ntheta0=89\n",
      "b");
  const SpinInvariants spin = spin_invariants(*body.inertia, momentum_principal(body));
  EXPECT_NEAR(spin.long_axis->precession_period_s / 3600.0, 8.67, 1e-11);
  EXPECT_NEAR(*spin.polhode_period_s / 3600.0, 54.48, 1e-9);
  EXPECT_NEAR(spin.long_axis->least_angle_rad / degree, std::acos(2450.0 / (54125.0 - 2450.0) * 8.67 / 54.48) / degree,
              1e-9);
  const bool has_angle = std::any_of(body.notes.begin(), body.notes.end(), [](const std::string& note) {
    return note.find("residual +0.57 deg") != std::string::npos;
  });
  EXPECT_TRUE(has_angle);
}

TEST(AsteroidFiles, DamitPrincipalAxis) {
  const Body b = parse_damit_spin(read_text_file(samples + "asteroid/spin.txt"), "spin.txt");
  ASSERT_TRUE(b.state && b.state->q_frame_from_named);
  const Quaternion q = *b.state->q_frame_from_named;
  const Vector3 pole = q * Vector3::UnitZ();
  EXPECT_NEAR(pole.x(), std::cos(-63 * degree) * std::cos(251 * degree), 1e-15);
  EXPECT_NEAR(pole.z(), std::sin(-63 * degree), 1e-15);
  // r_ecl = Rz(lambda) Ry(90 - beta) Rz(phi0) r_body.
  const Quaternion wanted = Quaternion(Eigen::AngleAxisd(251 * degree, Vector3::UnitZ())) *
                            Quaternion(Eigen::AngleAxisd(153 * degree, Vector3::UnitY())) *
                            Quaternion(Eigen::AngleAxisd(37.5 * degree, Vector3::UnitZ()));
  EXPECT_LT(rotation_angle_rad(q, wanted), 1e-15);
  EXPECT_NEAR(b.state->omega_named_rad_s->z(), 2 * std::numbers::pi / (8.5251 * 3600), 1e-18);
  EXPECT_TRUE(b.missing.empty());
  const Body table = read_body(samples + "asteroid/asteroid_models.csv#101");
  EXPECT_LT(rotation_angle_rad(*table.state->q_frame_from_named, q), 1e-15);
  EXPECT_THROW(read_body(samples + "asteroid/asteroid_models.csv"), InputError);
  EXPECT_THROW(read_body(samples + "asteroid/asteroid_models.csv#103"), InputError);
  EXPECT_NE(read_body(samples + "asteroid/asteroid_models.csv#102").warnings.back().find("YORP"), std::string::npos);
}

TEST(AsteroidFiles, DamitTumbler) {
  const std::string path = samples + "asteroid/tumblers.csv";
  const Body b = read_body(path);
  const Vector3 momentum = momentum_in_frame(b, Frame::ecliptic_j2000).normalized();
  EXPECT_NEAR(std::asin(momentum.z()) / degree, -85.0, 1e-10);
  EXPECT_NEAR(std::atan2(momentum.y(), momentum.x()) / degree, 275.0 - 360.0, 1e-9);
  const SpinInvariants spin = spin_invariants(*b.inertia, momentum_principal(b));
  EXPECT_NEAR(*spin.polhode_period_s / 3600, 264.178, 1e-7);
  EXPECT_NEAR(spin.long_axis->precession_period_s / 3600, 27.38547, 1e-8);
  std::string text = read_text_file(path);
  text.replace(text.find("psi0"), 4, "zeta");
  EXPECT_THROW(parse_damit_table(text, "t", ""), InputError);
  // Any column of a tumbler makes a tumbler of it: names of another table are not taken for a single period.
  try {
    parse_damit_table("lambda,beta,period,phi0,jd0,BETA\n1,2,3,4,2451545,6\n", "t", "");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "t:1: there are two columns 'beta'");
  }
  try {
    parse_damit_table("lambda,beta,phi0,psi0,Pphi,period,jd0\n1,2,3,4,5,6,2451545\n", "t", "");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 61), "t:1: the column 'pphi' of a table of tumblers is unknown; kno");
  }
}

TEST(AsteroidFiles, AByteOrderMarkIsNoPartOfAFile) {
  const std::string path = ::testing::TempDir() + "polhode_marked_spin.txt";
  std::ofstream(path, std::ios::binary) << "\xEF\xBB\xBF" << read_text_file(samples + "asteroid/spin.txt");
  EXPECT_EQ(read_body(path).state->q_frame_from_named->coeffs(),
            read_body(samples + "asteroid/spin.txt").state->q_frame_from_named->coeffs());
  std::filesystem::remove(path);
  EXPECT_THROW(read_text_file("/dev/zero"), InputError);  // it has no end
}

TEST(AsteroidFiles, ShapeModelIsToutatis) {
  const Body b = read_body(samples + "asteroid/toutatis.mod");
  const Vector3 momentum = momentum_in_frame(b, Frame::ecliptic_j2000).normalized();
  EXPECT_NEAR(std::atan2(momentum.y(), momentum.x()) / degree + 360.0, 181.03, 5e-3);
  EXPECT_NEAR(std::asin(momentum.z()) / degree, -53.62, 5e-3);
  const SpinInvariants spin = spin_invariants(*b.inertia, momentum_principal(b));
  EXPECT_NEAR(*spin.polhode_period_s / 86400, 5.3685, 5e-5);
  EXPECT_NEAR(spin.long_axis->precession_period_s / 86400, 7.4117, 5e-5);
  const std::string text = read_text_file(samples + "asteroid/toutatis.mod");
  EXPECT_THROW(parse_shape_model(text.substr(0, text.find("moment of inertia 1")), "t"), InputError);
}

const std::string spin_head =
    "name = 'x'\n[inertia]\nmoments = [0.64, 0.97, 1.0]\nunit = 'ratios'\n[spin]\nepoch = 'JD 2456284.5 TDB'\n"
    "frame = 'ECLIPJ2000'\nunit = 'deg'\nperiod_unit = 'h'\nlambda = 275\nbeta = -85\n";

TEST(BodyFile, SpinTable) {
  const std::string periods = "convention = 'long-axis'\nP_phi = 27.38547\nP_psi = 264.178\nenergy = 1.02\n";
  const Body no_angles = parse_body_file(spin_head + periods, "b");
  EXPECT_EQ(no_angles.missing, std::vector<std::string>{"the angles phi0 and psi0 at its epoch"});
  EXPECT_NE(no_angles.notes.at(1).find("residual -0.0012"), std::string::npos) << no_angles.notes.at(1);
  std::string no_mode = periods;
  no_mode.erase(no_mode.find("energy"));
  EXPECT_NE(fault_of(spin_head + no_mode).find("the mode or the energy must be given"), std::string::npos);
  const Body whole = parse_body_file(spin_head + periods + "phi0 = 152\npsi0 = 14\n", "b");
  const Body table = read_body(samples + "asteroid/tumblers.csv");
  EXPECT_LT(rotation_angle_rad(*whole.state->q_frame_from_named, *table.state->q_frame_from_named), 1e-14);
  const Body simple = parse_body_file(spin_head + "period = 10\nphi0 = 5\n", "b");
  EXPECT_TRUE(simple.missing.empty());
  EXPECT_NE(fault_of(spin_head + "period = 10\nP_phi = 5\n").find("goes with P_phi and P_psi"), std::string::npos);
  EXPECT_NE(fault_of(spin_head + "convention = 'long-axis'\nP_phi = 27\nP_psi = 28\n").find("does not occur"),
            std::string::npos);
  EXPECT_NE(fault_of(spin_head + "convention = 'L'\nP_phi = 27\nP_psi = 280\n").find("allowed: 'long-axis'"),
            std::string::npos);
}

TEST(BodyFile, IncompletePublishedBodies) {
  for (const auto& [file, energy] : {std::pair("apophis-2014.toml", 1.0285), std::pair("krylov.toml", 1.034)}) {
    const Body b = read_body(std::string(POLHODE_DATA_DIR "/bodies/incomplete/") + file);
    EXPECT_NEAR(1.0 + spin_invariants(*b.inertia, momentum_principal(b)).energy_above_ground, energy, 5e-4) << file;
    EXPECT_EQ(b.missing.size(), 1U) << file;
  }
  // The body file of the example APM is the message.
  const Body message = read_body(samples + "ccsds/valid/APMExample12.txt");
  const Body file = read_body(std::string(POLHODE_DATA_DIR "/bodies/mms.toml"));
  EXPECT_LT((*message.state->omega_named_rad_s - *file.state->omega_named_rad_s).norm(), 1e-16);
  EXPECT_LT(rotation_angle_rad(*message.state->q_frame_from_named, *file.state->q_frame_from_named), 1e-15);
}

TEST(BodyFile, ShapesGiveInertia) {
  const Body ellipsoid =
      parse_body_file("name = 'x'\n[inertia]\nsemi_axes = [1, 2, 3]\nmass_kg = 5\nlength_unit = 'm'\n", "b");
  EXPECT_TRUE(ellipsoid.inertia->absolute);
  EXPECT_LT((ellipsoid.inertia->principal_moments - Vector3(5, 10, 13)).norm(), 1e-13);
  const Body box = parse_body_file("name = 'x'\n[inertia]\nmesh = 'box.obj'\ndensity_kg_m3 = 2\nlength_unit = 'm'\n",
                                   samples + "mesh/b.toml");
  EXPECT_LT((box.inertia->principal_moments - Vector3(5, 10, 13)).norm(), 1e-13);  // 12 kg: (1 + 4, 1 + 9, 4 + 9)
  for (const char* file :
       {"mesh/box.obj", "mesh/box.ply", "mesh/box.stl", "mesh/box_binary.stl", "mesh/box_shape.txt"}) {
    const Body b = read_body(samples + file);
    EXPECT_FALSE(b.inertia->absolute);
    EXPECT_LT((b.inertia->principal_moments * 12 - Vector3(5, 10, 13)).norm(), 1e-13) << file;
  }
  EXPECT_NE(fault_of("name = 'x'\n[inertia]\nsemi_axes = [1, 2, -3]\n").find("positive"), std::string::npos);
}

}  // namespace
}  // namespace polhode
