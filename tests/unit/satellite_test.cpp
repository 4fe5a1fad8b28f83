#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/value_motion.hpp"
#include "polhode/torque/torques.hpp"

// Light and thin air on the facets of a satellite, against closed forms and counts.

namespace polhode {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kEarthMu = 3.986004418e14, kEarthRadius_m = 6.378137e6;
constexpr double kAu_m = 149597870700.0, kPressure_pa = 1361.0 / 299792458.0;  // at 1 au
constexpr double kSunRadius_m = 6.957e8;

/// From the Sun, far along -x: the light comes from +x.
Trajectory far_along_x() { return KeplerElements{1.32712440018e20, kAu_m, 0.0, 0.0, {-1, 0, 0}, {0, 0, 1}}; }

Vector3 torque_of(const Torque& torque, const Quaternion& q = Quaternion::Identity(), double t_s = 0.0) {
  return Torques({torque}).at(t_s, q, Vector3(1, 2, 3)).constant;
}

/// A ball of facets with this radius.
std::vector<Facet> ball(const Vector3& centre_m, double radius_m, const Rebound& rebound) {
  std::vector<Facet> facets;
  constexpr int bands = 180, around = 360;
  for (int i = 0; i < bands; ++i) {
    const double a = kPi * (i + 0.5) / bands, area = std::cos(kPi * i / bands) - std::cos(kPi * (i + 1) / bands);
    for (int j = 0; j < around; ++j) {
      const double b = 2.0 * kPi * (j + 0.5) / around;
      const Vector3 n(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
      facets.push_back({radius_m * radius_m * area * 2.0 * kPi / around * n, centre_m + radius_m * n, rebound});
    }
  }
  return facets;
}

TEST(Sunlight, OfAPlateABallAndACube) {
  const Vector3 centre(0.3, -0.2, 0.5), normal = Vector3(2, 1, -0.5).normalized(), s = Vector3::UnitX();
  const double c = normal.dot(s), area = 1.7;
  for (const Sunlight::Surface& surface :
       {Sunlight::Surface{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {0.25, 0.5}}) {  // black, mirror, white, some of each
    const Rebound rebound = Sunlight::rebound(surface);
    // The momentum that comes, that the mirror sends on, and that Lambert's law sends out along the normal.
    const Vector3 mirrored = 2.0 * c * normal - s;  // direction of the light that leaves a mirror
    const Vector3 push = -s - surface.specular * mirrored - surface.diffuse * 2.0 / 3.0 * normal;
    const Facet plate{area * normal, centre, rebound};
    const Vector3 expected = kPressure_pa * area * c * centre.cross(push);
    EXPECT_LT((torque_of(Sunlight({plate}, far_along_x())) - expected).norm(), 1e-13 * expected.norm());
    // From behind, a plate with one side feels nothing, the other side of it does.
    const Quaternion half_turn(Eigen::AngleAxisd(kPi, Vector3::UnitZ()));
    EXPECT_EQ(torque_of(Sunlight({plate}, far_along_x()), half_turn), Vector3::Zero());
    const Facet back = other_side(plate);
    const Vector3 s_back = -s, mirrored_back = 2.0 * c * -normal - s_back;
    const Vector3 push_back = -s_back - surface.specular * mirrored_back + surface.diffuse * 2.0 / 3.0 * normal;
    EXPECT_LT((torque_of(Sunlight({plate, back}, far_along_x()), half_turn) -
               kPressure_pa * area * c * centre.cross(push_back))
                  .norm(),
              1e-13 * expected.norm());
    // A ball: pi r^2 whatever it mirrors, and 4/9 of that more for what it scatters.
    const Vector3 on_ball = -kPressure_pa * kPi * 4.0 * (1.0 + 4.0 / 9.0 * surface.diffuse) * centre.cross(s);
    EXPECT_LT((torque_of(Sunlight(ball(centre, 2.0, rebound), far_along_x())) - on_ball).norm(), 1e-4 * on_ball.norm());
  }
  // A mirror feels twice the light's momentum, along its normal.
  const Vector3 on_mirror = -2.0 * kPressure_pa * area * c * c * centre.cross(normal);
  EXPECT_LT(
      (torque_of(Sunlight({{area * normal, centre, Sunlight::rebound({1.0, 0.0})}}, far_along_x())) - on_mirror).norm(),
      1e-13 * on_mirror.norm());
  // A black cube whose centre is aside: its face towards the light alone.
  TriangleMesh cube;
  for (int i = 0; i < 8; ++i) cube.vertices.push_back(centre + Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  for (const auto& f : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}}) {
    cube.facets.push_back({f[0], f[1], f[2]});
    cube.facets.push_back({f[0], f[2], f[3]});
  }
  const Vector3 on_cube = -4.0 * kPressure_pa * centre.cross(s);
  EXPECT_LT((torque_of(Sunlight(cube, {0.0, 0.0}, far_along_x())) - on_cube).norm(), 1e-13 * on_cube.norm());
  EXPECT_THROW(Sunlight::rebound({0.7, 0.4}), InputError);
  EXPECT_THROW(Sunlight(std::vector<Facet>{}, far_along_x()), InputError);
  EXPECT_THROW(
      Torques({Sunlight({{area * normal, centre, {}}}, far_along_x(), Sunlight::Eclipsing{far_along_x(), 0.0})}),
      InputError);
}

TEST(Aerodynamic, OfAPlateABallAndAnAtmosphereThatTurns) {
  const double r = 6.8e6, v = std::sqrt(kEarthMu / r);
  const Trajectory way(KeplerElements{kEarthMu, r, 0.0, 0.0, {1, 0, 0}, {0, 0, 1}});  // at x, towards y
  const Vector3 centre(0.3, -0.2, 0.5), normal = Vector3(-0.5, 2, 1).normalized();
  const ExponentialAtmosphere air{1e-11, 6.75e6, 5e4, {0, 0, 7.292115e-5}};
  const double speed = v - 7.292115e-5 * r, pressure = 1e-11 * std::exp(-1.0) * speed * speed, c = normal.y();
  const Vector3 s = Vector3::UnitY();
  for (const Aerodynamic::Surface& surface : {Aerodynamic::Surface{1.0, 0.0}, {0.0, 0.0}, {0.9, 0.06}}) {
    const Rebound rebound = Aerodynamic::rebound(surface);
    // What comes, what is mirrored, and what leaves slowly along the normal.
    const Vector3 push = -s - (1.0 - surface.accommodation) * (2.0 * c * normal - s) -
                         surface.accommodation * surface.rebound_speed * normal;
    const Vector3 expected = pressure * 1.7 * c * centre.cross(push);
    EXPECT_LT((torque_of(Aerodynamic({{1.7 * normal, centre, rebound}}, air, way)) - expected).norm(),
              1e-12 * expected.norm());
    const Vector3 on_ball =
        -pressure * kPi * 4.0 * (1.0 + 2.0 / 3.0 * surface.accommodation * surface.rebound_speed) * centre.cross(s);
    EXPECT_LT((torque_of(Aerodynamic(ball(centre, 2.0, rebound), air, way)) - on_ball).norm(), 1e-4 * on_ball.norm());
  }
  // Over the pole the air comes from the east's side.
  const Trajectory polar(KeplerElements{kEarthMu, r, 0.0, 0.0, {1, 0, 0}, {0, -1, 0}});  // at x, towards z
  const Vector3 from = Vector3(0, -7.292115e-5 * r, v);
  const Vector3 expected = -1e-11 * std::exp(-1.0) * from.norm() * kPi * centre.cross(from);
  EXPECT_LT((torque_of(Aerodynamic(ball(centre, 1.0, {}), air, polar)) - expected).norm(), 1e-4 * expected.norm());
  const Aerodynamic plate({{normal, centre, {}}}, air, way);
  EXPECT_THROW(Torques({Aerodynamic({{normal, centre, {}}}, {-1.0, 6.7e6, 5e4, Vector3::Zero()}, way)}), InputError);
  EXPECT_THROW(Torques({Aerodynamic({{normal, centre, {}}}, {1e-11, 6.7e6, 0.0, Vector3::Zero()}, way)}), InputError);
  EXPECT_THROW(Aerodynamic::rebound({1.1, 0.0}), InputError);
  EXPECT_THROW(Aerodynamic::rebound({0.5, -0.1}), InputError);
}

/// By rays to points of the Sun's disc, of which so many do not meet the ball.
double counted_share(const Vector3& to_sun_m, const Vector3& from_ball_m, double radius_m) {
  const Vector3 z = to_sun_m.normalized(), x = z.unitOrthogonal(), y = z.cross(x);
  const double disc = std::asin(kSunRadius_m / to_sun_m.norm());
  constexpr int count = 400;
  int seen = 0, all = 0;
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      const double u = 2.0 * (i + 0.5) / count - 1.0, v = 2.0 * (j + 0.5) / count - 1.0;
      if (u * u + v * v > 1.0) continue;
      ++all;
      const Vector3 ray = (z + std::tan(disc * std::hypot(u, v)) / std::hypot(u, v) * (u * x + v * y)).normalized();
      const double along = -ray.dot(from_ball_m);  // of the ball's centre
      seen += along < 0.0 || (from_ball_m + along * ray).norm() > radius_m;
    }
  }
  return static_cast<double>(seen) / all;
}

TEST(Shadow, IsWhatCountedRaysSay) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int partly = 0;
  for (int n = 0; n < 120; ++n) {
    // Low orbits, geostationary ones, and beyond the tip of the shadow (1.38e9 m), where a ring is left.
    const double r = n % 3 == 0 ? 7e6 : n % 3 == 1 ? 4.2e7 : 2e9;
    const Vector3 to_sun = kAu_m * Vector3(1, 0.3, -0.2).normalized();
    const double ball = std::asin(kEarthRadius_m / r), sun = kSunRadius_m / kAu_m;
    const double apart = n % 2 == 0 ? ball + sun * (2.4 * unit(random) - 1.2) : (ball + 2.0 * sun) * unit(random);
    const Vector3 across = to_sun.unitOrthogonal();
    const Vector3 from_ball = -r * (std::cos(apart) * to_sun.normalized() + std::sin(apart) * across);
    const double share = lit_share(to_sun, from_ball, kEarthRadius_m);
    const double counted = counted_share(to_sun, from_ball, kEarthRadius_m);
    EXPECT_NEAR(share, counted, 3e-3) << r << ", " << apart;
    partly += share > 0.0 && share < 1.0;
  }
  EXPECT_GT(partly, 40);
  EXPECT_EQ(lit_share({kAu_m, 0, 0}, {7e6, 0, 0}, kEarthRadius_m), 1.0);
  EXPECT_EQ(lit_share({kAu_m, 0, 0}, {-7e6, 0, 0}, kEarthRadius_m), 0.0);
}

TEST(Shadow, ItsEdgesAreFound) {
  const Trajectory from_sun(KeplerElements{1.32712440018e20, 1.471e11, 0.0167, 0.0, {1, 0, 0}, {0, -0.4, 0.917}});
  for (const double e : {0.0, 0.6}) {
    for (const Vector3& normal : {Vector3(0, -0.3, 0.95), Vector3(0, 0.9, 0.43), Vector3(1, 0.1, 0.2)}) {
      const Trajectory way(KeplerElements{kEarthMu, 7.2e6, e, 300.0, normal.unitOrthogonal(), normal});
      const double first_s = -20000.0, last_s = 120000.0;
      const std::vector<double> found = shadow_edges_s(from_sun, way, kEarthRadius_m, first_s, last_s);
      EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
      const auto kind = [&](double t_s) {
        const double share = lit_share(-from_sun.state(t_s).position_m, way.state(t_s).position_m, kEarthRadius_m);
        return share == 1.0 ? 2 : share > 0.0 ? 1 : 0;
      };
      std::vector<double> looked;
      int before = kind(first_s);
      for (double t_s = first_s + 0.5; t_s < last_s; t_s += 0.5) {
        const int now = kind(t_s);
        if (now != before) looked.push_back(t_s - 0.25);
        EXPECT_LE(std::abs(now - before), 1) << t_s;
        before = now;
      }
      ASSERT_EQ(found.size(), looked.size()) << e << " " << normal.transpose();
      for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], looked[i], 0.2501);
    }
  }
}

/// A box with a wing of two sides.
std::vector<Facet> small_satellite(const Rebound& rebound) {
  std::vector<Facet> facets;
  for (int k = 0; k < 3; ++k) {
    for (const double side : {1.0, -1.0})
      facets.push_back({side * Vector3::Unit(k), 0.5 * side * Vector3::Unit(k), rebound});
  }
  const Facet wing{3.0 * Vector3(0.2, 0.1, 1.0).normalized(), {0.1, 2.0, 0.2}, rebound};
  facets.push_back(wing);
  facets.push_back(other_side(wing));
  return facets;
}

/// d/dt (kinetic energy) = torque . omega: the energy at the end is that at the start and the work done between.
TEST(Satellite, EnergyIsThatOfTheWorkDone) {
  const Trajectory way(KeplerElements{kEarthMu, 6.7e6, 0.02, 0.0, {1, 0, 0}, {0, 0.5, 0.8}});
  const Trajectory from_sun(KeplerElements{1.32712440018e20, 1.471e11, 0.0167, 0.0, {1, 0, 0}, {0, -0.4, 0.917}});
  const ExponentialAtmosphere air{3e-13, 6.7e6, 4e4, {0, 0, 7.292115e-5}};
  const FreeBody body{{40.0, 70.0, 90.0}, Quaternion(0.3, -0.5, 0.7, 0.2).normalized(), {0.3, 0.9, 1.1}};
  for (const Torque& torque : {Torque(Sunlight(small_satellite(Sunlight::rebound({0.3, 0.4})), from_sun,
                                               Sunlight::Eclipsing{way, kEarthRadius_m})),
                               Torque(Aerodynamic(small_satellite(Aerodynamic::rebound({0.9, 0.06})), air, way))}) {
    const Torques torques({torque});
    constexpr double last_s = 12000.0;
    const ValueMotion motion(body, torques, {1e-5, 0.0, last_s});
    ASSERT_LE(motion.error_rad(), 1e-5);
    const auto energy = [&](const State& s) {
      return 0.5 * s.momentum_body.dot(s.momentum_body.cwiseQuotient(body.principal_moments));
    };
    constexpr int count = 24000;  // trapezoids, since the power has kinks
    double work = 0.0, size = 0.0;
    for (int i = 0; i <= count; ++i) {
      const double t_s = last_s * i / count;
      const State s = motion.at(t_s);
      const double power = torques.at(t_s, s.q_inertial_from_body, body.principal_moments)
                               .constant.dot(s.momentum_body.cwiseQuotient(body.principal_moments));
      const double weight = (i == 0 || i == count ? 0.5 : 1.0) * last_s / count;
      work += weight * power;
      size += weight * std::abs(power);
    }
    const double gained = energy(motion.at(last_s)) - energy(motion.at(0.0));
    std::printf("%s: energy gained %.6e J, work %.6e J (of %.1e back and forth)\n",
                std::string(torque_name(torque)).c_str(), gained, work, size);
    EXPECT_NEAR(gained, work, 1e-4 * size);
    EXPECT_GT(std::abs(gained), 1e-3 * size);
  }
}

TEST(Satellite, EclipsesKeepTheirPromise) {
  const Trajectory way(KeplerElements{kEarthMu, 6.9e6, 0.001, 0.0, {1, 0, 0}, {0, 0.5, 0.8}});
  const Trajectory from_sun(KeplerElements{1.32712440018e20, 1.471e11, 0.0167, 0.0, {1, 0, 0}, {0, -0.4, 0.917}});
  const Torques torques(
      {Sunlight(small_satellite(Sunlight::rebound({0.3, 0.4})), from_sun, Sunlight::Eclipsing{way, kEarthRadius_m}),
       GravityGradient(kEarthMu, way)});
  const FreeBody body{{40.0, 70.0, 90.0}, Quaternion(0.3, -0.5, 0.7, 0.2).normalized(), {0.3, 0.9, 1.1}};
  constexpr double first_s = -9000.0, last_s = 30000.0;
  EXPECT_EQ(torques.times_of_kinks_s(first_s, last_s).size(), 28u);  // seven eclipses
  const ValueMotion truth(body, torques, {2e-9, first_s, last_s});
  ASSERT_LE(truth.error_rad(), 2e-9);
  for (const double tolerance_rad : {1e-3, 1e-5, 1e-7}) {
    const ValueMotion motion(body, torques, {tolerance_rad, first_s, last_s});
    double worst = 0.0;
    for (double t_s = first_s; t_s <= last_s; t_s += 50.0) {
      worst =
          std::max(worst, rotation_angle_rad(motion.at(t_s).q_inertial_from_body, truth.at(t_s).q_inertial_from_body));
    }
    std::printf("with eclipses to %g rad: off by %.1e, claimed %.1e\n", tolerance_rad, worst, motion.error_rad());
    EXPECT_LE(motion.error_rad(), tolerance_rad);
    EXPECT_LE(worst, motion.error_rad() + truth.error_rad());
  }
}

}  // namespace
}  // namespace polhode
