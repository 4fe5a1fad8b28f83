#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "polhode/base/error.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {
namespace {

constexpr double kEarth = 3.986004418e14;
using Extended = Vector3Of<long double>;

KeplerElements elements(double periapsis_m, double eccentricity, double time_s = 0.0) {
  return {kEarth, periapsis_m, eccentricity, time_s, {1, 2, -0.5}, {0.5, 0, 1}};
}

/// The residual of the textbook equation that belongs to the eccentricity, in the time, relative to |t|: from a
/// position, back to the time, by the true anomaly, in long double.
double time_error(const KeplerElements& e, const Extended& r, double t_s) {
  const Extended x = e.to_periapsis.cast<long double>().normalized();
  Extended normal = e.along_normal.cast<long double>();
  normal = (normal - normal.dot(x) * x).normalized();
  const long double ecc = e.eccentricity, q = e.periapsis_m, mu = e.mu_m3_s2;
  const long double half = std::tan(std::atan2(r.dot(normal.cross(x)), r.dot(x)) / 2);
  long double t = 0;
  if (ecc == 1) {
    t = std::sqrt(2 * q * q * q / mu) * (half + half * half * half / 3);
  } else if (ecc < 1) {
    const long double a = q / (1 - ecc), E = 2 * std::atan(std::sqrt((1 - ecc) / (1 + ecc)) * half);
    t = std::sqrt(a * a * a / mu) * (E - ecc * std::sin(E));
  } else {
    const long double a = q / (ecc - 1), H = 2 * std::atanh(std::sqrt((ecc - 1) / (ecc + 1)) * half);
    t = std::sqrt(a * a * a / mu) * (ecc * std::sinh(H) - H);
  }
  return static_cast<double>(std::abs((t - t_s) / t_s));
}

TEST(KeplerOrbit, SatisfiesKeplersEquationForEveryEccentricity) {
  for (const double e : {0.0, 0.001, 0.3, 0.9, 0.999, 1.0, 1.0001, 1.5, 4.25, 92.0}) {
    const KeplerElements k = elements(7.2e6, e);
    const KeplerOrbit orbit(k);
    const double unit_s = std::sqrt(7.2e6 * 7.2e6 * 7.2e6 / kEarth);
    for (const double t : {1e-3, -0.1, 1.0, -2.0, 2.9, 30.0, -1e4}) {
      const double half_turn = e < 1.0 ? std::numbers::pi * std::pow(1.0 - e, -1.5) : 1e99;
      if (std::abs(t) > 0.95 * half_turn) continue;
      const Extended r = orbit.state<long double>(static_cast<long double>(t * unit_s)).position_m;
      // The textbook's own loss: of 1 - e near the parabola, of the anomaly near the asymptote of a hyperbola.
      const double forgiven = e > 1.0 && std::abs(t) > 1e3 ? 1e-13
                              : std::abs(e - 1.0) < 1e-2   ? 1e-14
                                                           : 1e-16;  // the textbook's own cancellation
      EXPECT_LT(time_error(k, r, t * unit_s), forgiven) << "e = " << e << ", t = " << t;
      const Vector3 plain = orbit.state(t * unit_s).position_m;
      EXPECT_LT((plain - r.cast<double>()).norm(), 1e-14 * plain.norm() * std::max(1.0, std::abs(t))) << e << " " << t;
    }
  }
}

TEST(KeplerOrbit, IsContinuousThroughTheParabola) {
  for (const double t : {10.0, 3000.0, -2e5, 1e7}) {
    const Vector3 parabola = KeplerOrbit(elements(7e6, 1.0)).state(t).position_m;
    for (const double d : {-1e-15, 1e-15, 1e-13, -1e-13}) {
      const Vector3 near = KeplerOrbit(elements(7e6, 1.0 + d)).state(t).position_m;
      EXPECT_LT((near - parabola).norm(), (1e-14 + 1e4 * std::abs(d)) * parabola.norm()) << t << " " << d;
    }
  }
}

TEST(KeplerOrbit, VelocityIsTheDerivativeAndEnergyIsConserved) {
  for (const double e : {0.0, 0.7, 1.0, 4.25}) {
    const KeplerOrbit orbit(elements(8e6, e, 500.0));
    for (const double t : {-4000.0, 500.0, 2100.0}) {
      const long double h = 1e-2L;
      const Extended slope = (orbit.state(t + h).position_m - orbit.state(t - h).position_m) / (2 * h);
      const OrbitState<double> s = orbit.state(t);
      EXPECT_LT((s.velocity_m_s - slope.cast<double>()).norm(), 1e-9 * s.velocity_m_s.norm());
      const double energy = 0.5 * s.velocity_m_s.squaredNorm() - kEarth / s.position_m.norm();
      EXPECT_NEAR(energy, -kEarth * (1.0 - e) / 16e6, 1e-13 * kEarth / 8e6);
    }
  }
}

TEST(KeplerOrbit, RefusesImpossibleElements) {
  EXPECT_THROW(KeplerOrbit(elements(0.0, 0.5)), InputError);
  EXPECT_THROW(KeplerOrbit(elements(7e6, -0.1)), InputError);
  EXPECT_THROW(KeplerOrbit(elements(7e6, std::nan(""))), InputError);
  EXPECT_THROW(KeplerOrbit({kEarth, 7e6, 0.1, 0.0, {1, 0, 0}, {-2, 0, 0}}), InputError);
  EXPECT_THROW(KeplerOrbit({-1.0, 7e6, 0.1, 0.0, {1, 0, 0}, {0, 0, 1}}), InputError);
}

TEST(TabulatedOrbit, FollowsTheOrbitItWasMadeFrom) {
  const KeplerOrbit orbit(elements(7e6, 0.1));
  std::vector<double> times_s;
  std::vector<Vector3> positions_m;
  for (double t = -600.0; t <= 6000.0; t += 60.0) {
    times_s.push_back(t);
    positions_m.push_back(orbit.state(t).position_m);
  }
  const TabulatedOrbit table({OrbitTable{times_s, positions_m, {}, 9, {}, {}}});
  for (double t = -597.0; t < 6000.0; t += 13.7) {
    EXPECT_LT((table.state(t).position_m - orbit.state(t).position_m).norm(), 1e-3);
    EXPECT_LT((table.state(t).velocity_m_s - orbit.state(t).velocity_m_s).norm(), 1e-4);
  }
  EXPECT_THROW(table.state(-601.0), InputError);
  EXPECT_THROW(TabulatedOrbit({OrbitTable{{0.0, 1.0, 1.0}, std::vector<Vector3>(3), {}, 2, {}, {}}}), InputError);
  EXPECT_THROW(TabulatedOrbit({OrbitTable{{0.0, 1.0}, std::vector<Vector3>(2), {}, 2, {}, {}}}), InputError);
}

TEST(TabulatedOrbit, WithVelocitiesIsGoodForTwiceAsManyConditions) {
  const KeplerOrbit orbit(elements(7e6, 0.1));
  const auto rows = [&](double step_s, int degree, bool hermite, double first_s = 0.0, double last_s = 6000.0) {
    OrbitTable table;
    table.degree = degree;
    for (double t = first_s; t <= last_s; t += step_s) {
      const OrbitState<double> state = orbit.state(t);
      table.times_s.push_back(t);
      table.positions_m.push_back(state.position_m);
      if (hermite) table.velocities_m_s.push_back(state.velocity_m_s);
    }
    return table;
  };
  const auto worst_m = [&](const OrbitTable& table) {
    const TabulatedOrbit tabulated({table});
    double worst = 0.0;
    for (double t = 1000.0; t < 5000.0; t += 13.7) {
      const OrbitState<double> found = tabulated.state(t), exact = orbit.state(t);
      worst = std::max(worst, (found.position_m - exact.position_m).norm());
      // The velocity is the derivative of the position, but where two pieces meet.
      const double row = std::remainder(t, table.times_s[1] - table.times_s[0]);
      if (std::abs(row) < 0.02) continue;
      const Vector3Of<long double> slope =
          (tabulated.state<long double>(t + 0.01L).position_m - tabulated.state<long double>(t - 0.01L).position_m) /
          0.02L;
      EXPECT_LT((found.velocity_m_s - slope.cast<double>()).norm(), 1e-4);
    }
    return worst;
  };
  // Orders 4 and 8 of the spacing for Hermite of degree 3 and 7, 2 for straight lines; degree 6 is taken as 7.
  for (const auto& [degree, order] : {std::pair{3, 4.0}, {7, 8.0}}) {
    EXPECT_NEAR(std::log2(worst_m(rows(400.0, degree, true)) / worst_m(rows(200.0, degree, true))), order, 0.7);
  }
  EXPECT_NEAR(std::log2(worst_m(rows(100.0, 1, false)) / worst_m(rows(50.0, 1, false))), 2.0, 0.2);
  EXPECT_EQ(worst_m(rows(200.0, 6, true)), worst_m(rows(200.0, 7, true)));

  // Two tables: nothing is interpolated across the seam, the later counts where they overlap.
  OrbitTable before = rows(200.0, 7, true, 0.0, 3000.0), after = rows(200.0, 7, true, 2000.0, 6000.0);
  for (Vector3& position : after.positions_m) position *= 2.0;
  for (Vector3& velocity : after.velocities_m_s) velocity *= 2.0;
  after.useable_from_s = 2500.0;
  const TabulatedOrbit two({before, after});
  EXPECT_EQ(two.seams_s(), std::vector<double>{2500.0});
  EXPECT_LT((two.state(2499.9).position_m - orbit.state(2499.9).position_m).norm(), 1.0);
  EXPECT_LT((two.state(2500.0).position_m - 2.0 * orbit.state(2500.0).position_m).norm(), 2.0);
  after.useable_from_s = 3100.0;
  EXPECT_THROW(TabulatedOrbit({before, after}), InputError);  // a gap
  after.useable_from_s = 1999.0;
  EXPECT_THROW(TabulatedOrbit({after}), InputError);
}

/// All of one torque at t and q, at rest.
TorqueTerms<double> terms(const Torque& torque, double t_s, const Quaternion& q, const Vector3& moments) {
  return Torques({torque}).at(t_s, q, moments);
}

TEST(GravityGradient, IsTheSumOverPointMassesOfTheBody) {
  // Two masses on each axis have these moments; the torque of the exact attraction on them tends to ours.
  const Vector3 moments(3, 4, 5);
  const Vector3 squares(3, 2, 1);  // sum of x^2, y^2, z^2 of unit masses: (I2 + I3 - I1)/2 …
  const GravityGradient gravity(kEarth, elements(7.2e6, 0.2));
  const Quaternion q = Quaternion(0.3, -0.5, 0.7, 0.2).normalized();
  const double t = 1000.0;
  const Vector3 r = KeplerOrbit(elements(7.2e6, 0.2)).state(t).position_m;
  Vector3 sum = Vector3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      // Long double: the parts nearly cancel.
      const Extended arm = (sign * std::sqrt(0.5L * squares[axis]) * Extended::Unit(axis)) * 10.0L;
      const Extended place = q.conjugate().cast<long double>() * r.cast<long double>() + arm;
      const long double d = place.norm();
      sum += (arm.cross(place) * (-kEarth / (d * d * d))).cast<double>() / 100.0;
    }
  }
  EXPECT_LT((terms(gravity, t, q, moments).constant - sum).norm(), 1e-9 * sum.norm());
  EXPECT_EQ(terms(gravity, t, q, Vector3(2, 2, 2)).constant.norm(), 0.0);
}

TEST(EddyCurrents, IsTheTorqueOnAConductorAsSeenFromItself) {
  Matrix3 M;
  M << 3, 0.2, 0, 0.2, 4, -0.1, 0, -0.1, 5;
  M *= 1e5;
  const EddyCurrents eddy{M, Vector3(0.1, -0.2, 1).normalized(), 7.8e15, elements(7.2e6, 0.05)};
  const Quaternion q = Quaternion(0.3, -0.5, 0.7, 0.2).normalized();
  const Vector3 omega(0.02, -0.05, 0.01);
  // The field that the body sees, and its rate, by differences: the body turns and moves at once.
  const auto field_body = [&](double dt) -> Vector3 {
    const Vector3 r = KeplerOrbit(elements(7.2e6, 0.05)).state(700.0 + dt).position_m;
    const double d = r.norm();
    const Vector3 B = 7.8e15 / (d * d * d) * (3.0 * eddy.dipole_axis.dot(r) * r / (d * d) - eddy.dipole_axis);
    const Quaternion turned = q * Quaternion(Eigen::AngleAxisd(omega.norm() * dt, omega.normalized()));
    return turned.conjugate() * B;
  };
  const double h = 0.01;
  const Vector3 expected = field_body(0).cross(M * ((field_body(h) - field_body(-h)) / (2 * h)));
  const Vector3 torque = terms(eddy, 700.0, q, {1, 2, 3}).torque(omega);
  EXPECT_LT((torque - expected).norm(), 1e-7 * expected.norm());
  // Without motion along the orbit it only takes energy.
  EXPECT_LT(omega.dot(-terms(eddy, 700.0, q, {1, 2, 3}).damping * omega), 0.0);
}

TEST(Sunlight, PushesAPlateAlongTheLight) {
  // One plate of 2 m2, 3 m off the centre along x, its normal towards -x; black, so that only the light pushes.
  TriangleMesh plate;
  plate.vertices = {{3, 0, 0}, {3, 0, 2}, {3, 2, 0}};
  plate.facets = {{0, 1, 2}};
  const double au = 149597870700.0;
  const Sunlight black(plate, {0.0, 0.0}, Trajectory(KeplerElements{1.32712440018e20, au, 0, 0, {1, 0, 0}, {0, 0, 1}}));
  // Sun towards -x: force +x of 1361/c * 2 N at (3, 2/3, 2/3).
  const Vector3 torque = black.torque({-au, 0, 0});
  const double force = 1361.0 / 299792458.0 * 2.0;
  EXPECT_LT((torque - Vector3(3, 2.0 / 3, 2.0 / 3).cross(Vector3(force, 0, 0))).norm(), 1e-12 * force);
  EXPECT_EQ(black.torque({au, 0, 0}).norm(), 0.0);  // from behind
  EXPECT_NEAR(black.torque({-2 * au, 0, 0}).norm(), torque.norm() / 4, 1e-12 * force);
  const Sunlight mirror(plate, {1.0, 0.0},
                        Trajectory(KeplerElements{1.32712440018e20, au, 0, 0, {1, 0, 0}, {0, 0, 1}}));
  EXPECT_LT((mirror.torque({-au, 0, 0}) - 2.0 * torque).norm(), 1e-12 * force);
  EXPECT_THROW(Sunlight(plate, {0.7, 0.7}, elements(7e6, 0)), InputError);
}

TEST(Torques, KnowWhenAPulseIsOn) {
  const Torques torques({ThrusterPulse{10.0, 5.0, {1, 0, 0}}, ThrusterPulse{12.0, 5.0, {0, 1, 0}}});
  EXPECT_EQ(torques.jumps_s(), (std::vector<double>{10, 12, 15, 17}));
  const auto on = [&](double t) -> Vector3 {
    return torques.during(t).at(t, Quaternion::Identity(), Vector3(1, 2, 3)).constant;
  };
  EXPECT_EQ(on(9.0), Vector3(0, 0, 0));
  EXPECT_EQ(on(11.0), Vector3(1, 0, 0));
  EXPECT_EQ(on(13.0), Vector3(1, 1, 0));
  EXPECT_EQ(on(16.0), Vector3(0, 1, 0));
  EXPECT_EQ(on(18.0), Vector3(0, 0, 0));
}

}  // namespace
}  // namespace polhode
