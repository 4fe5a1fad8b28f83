// What the headers exclude is refused by InputError when something is made of it; what cannot be refused later, a time
// that is not finite, gives NaN.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/body/euler.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/body/spin_solution.hpp"
#include "polhode/elliptic/carlson.hpp"
#include "polhode/elliptic/jacobi.hpp"
#include "polhode/elliptic/legendre_forms.hpp"
#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/ephemeris/row_spacing.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/motion/conditioning.hpp"
#include "polhode/motion/events.hpp"
#include "polhode/motion/kicked_motion.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/motion/splitting.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/time/leap_seconds.hpp"
#include "rivals/celledoni.hpp"
#include "rivals/reference.hpp"
#include "rivals/registry.hpp"
#include "rivals/torqued_methods.hpp"

namespace polhode {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kEarth = 3.986004418e14;

const FreeBody kBody{{1.0, 1.7, 2.1}, {0.3, -0.2, 0.9, 0.4}, {0.5, -1.1, 0.8}};

/// Bodies that FreeBody excludes.
std::vector<FreeBody> impossible_bodies() {
  std::vector<FreeBody> bodies;
  for (const Vector3& moments : {Vector3(1.0, -2.8, 3.0), Vector3(2.0, 1.0, 3.0), Vector3(1.0, 3.0, 2.0),
                                 Vector3(0.0, 1.0, 1.0), Vector3(-1.0, 1.0, 2.0), Vector3(1.0, kNan, 3.0),
                                 Vector3(1.0, 2.0, kInf), Vector3(kNan, 2.0, 3.0), Vector3(1.0, 2.0, kNan)}) {
    bodies.push_back(kBody);
    bodies.back().principal_moments = moments;
  }
  for (const Vector3& moments : {Vector3(1e-240, 1.0, 1.0), Vector3(1e-306, 1e-306, 1e-306), Vector3(1.0, 1.0, 1e306),
                                 Vector3(1e-60, 1e50, 1e50)}) {
    bodies.push_back(kBody);
    bodies.back().principal_moments = moments;
  }
  for (const Vector3& momentum : {Vector3(1e-310, 1e-310, 0.0), Vector3(0.0, 1e-306, 0.0), Vector3(1e308, 1e308, 1e308),
                                  Vector3(0.0, 0.0, -1e306)}) {
    bodies.push_back(kBody);
    bodies.back().momentum_body = momentum;
  }
  for (const Quaternion& q :
       {Quaternion(0, 0, 0, 0), Quaternion(kNan, 0, 0, 1), Quaternion(1, 0, kInf, 0), Quaternion(1, 0, 0, kNan)}) {
    bodies.push_back(kBody);
    bodies.back().q_inertial_from_body = q;
  }
  for (int k = 0; k < 3; ++k) {
    for (const double bad : {kNan, kInf, -kInf}) {
      bodies.push_back(kBody);
      bodies.back().momentum_body[k] = bad;
    }
  }
  return bodies;
}

Torques constant_torque() { return Torques({ConstantTorque{{1e-4, 0, 0}, ConstantTorque::Axes::body}}); }

TEST(Arguments, ABodyThatIsNoneMakesNoMotion) {
  const Torques torques = constant_torque();
  for (const FreeBody& body : impossible_bodies()) {
    EXPECT_THROW(checked(body), InputError);
    for (const rivals::MeasuredMethod& method : rivals::measured_methods()) {
      EXPECT_THROW(method.make(body), InputError) << method.name;
      if (method.make_short != nullptr) {
        EXPECT_THROW(method.make_short(body), InputError) << method.name;
      }
      if (method.make_controlled != nullptr) {
        EXPECT_THROW(method.make_controlled(body, {}), InputError) << method.name;
      }
    }
    EXPECT_THROW(TorquedMotion(body, torques, {1e-6, 0.0, 10.0}), InputError);
    EXPECT_THROW(KickedMotion::make(body, torques, {1e-2, 0.0, 1e5}), InputError);
    EXPECT_THROW(KickedMotion::predicted_evaluations(body, torques, {1e-2, 0.0, 1e5}), InputError);
    EXPECT_THROW(plan_motion(body, torques, 0.0, 10.0, 1e-3), InputError);
    EXPECT_THROW(SplittingRun(body, 0.0, torques, kStrang), InputError);
    EXPECT_THROW(condition_number(body, 1.0), InputError);
    EXPECT_THROW(rivals::QuadrupleReference(rivals::in_quadruple(body), 0.0, 1.0), InputError);
    for (const rivals::TorquedMethod& method : rivals::torqued_methods()) {
      EXPECT_THROW(rivals::IntegratedMotion(body, torques, {}, method.run, method.scheme), InputError) << method.name;
    }
  }
  EXPECT_NO_THROW(checked(kBody));
  EXPECT_NO_THROW(ThetaMotion({{1.0, 1.0, 1.0}, {5, 0, 0, 0}, {0, 0, 0}}));  // a sphere at rest, any length of q
}

TEST(Arguments, SpansTolerancesAndStepsAreChecked) {
  const Torques torques = constant_torque();
  for (const auto& [first_s, last_s] :
       {std::pair{1.0, 2.0}, {-2.0, -1.0}, {0.0, kNan}, {kNan, 1.0}, {0.0, kInf}, {-kInf, 0.0}, {5.0, -5.0}}) {
    EXPECT_THROW(TorquedMotion(kBody, torques, {1e-6, first_s, last_s}), InputError);
    EXPECT_THROW(KickedMotion::make(kBody, torques, {1e-2, first_s, last_s}), InputError);
    EXPECT_THROW(plan_motion(kBody, torques, first_s, last_s, 1e-3), InputError);
    EXPECT_THROW(rivals::QuadrupleReference(rivals::in_quadruple(kBody), first_s, last_s), InputError);
  }
  for (const double tolerance : {0.0, -1e-9, kNan, kInf}) {
    EXPECT_THROW(TorquedMotion(kBody, torques, {tolerance, 0.0, 10.0}), InputError);
    EXPECT_THROW(KickedMotion::make(kBody, torques, {tolerance, 0.0, 10.0}), InputError);
    EXPECT_THROW(plan_motion(kBody, torques, 0.0, 10.0, tolerance), InputError);
  }
  for (const rivals::MeasuredMethod& method : rivals::measured_methods()) {
    if (method.make_controlled == nullptr) continue;
    for (const double bad : {-1.0, kNan, kInf}) {
      EXPECT_THROW(method.make_controlled(kBody, {.step_s = bad}), InputError) << method.name;
      EXPECT_THROW(method.make_controlled(kBody, {.tolerance = bad}), InputError) << method.name;
    }
    EXPECT_THROW(method.make_controlled(kBody, {.max_evaluations = -1}), InputError) << method.name;
  }
  for (const double bad : {-1e-3, 0.0, kNan}) {
  }
  EXPECT_THROW(free_motion_error_rad(kBody, 0.0, kInf), InputError);
  EXPECT_THROW(condition_number(kBody, kNan), InputError);
  EXPECT_THROW(next_flip_s(ThetaMotion(kBody), kNan), InputError);
  const ThetaMotion theta(kBody);
  EXPECT_THROW(next_pass(theta, kBody, Vector3::Zero(), Vector3::UnitX(), 0.1, 0.0, 1.0), InputError);
  EXPECT_THROW(next_pass(theta, kBody, Vector3::UnitX(), Vector3::UnitX(), -0.1, 0.0, 1.0), InputError);
  EXPECT_THROW(next_pass(theta, kBody, Vector3::UnitX(), Vector3::UnitX(), 0.1, 0.0, kInf), InputError);
}

/// The complaint about one torque.
std::string complaint(const Torque& torque) {
  try {
    Torques({torque});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Arguments, TorquesThatMeanNothingAreRefusedByName) {
  const KeplerElements orbit{kEarth, 7e6, 0.1, 0.0, {1, 0, 0}, {0, 0, 1}};
  const Matrix3 unit = Matrix3::Identity();
  Matrix3 lopsided = unit;
  lopsided(0, 1) = 0.1;
  const std::vector<std::pair<std::string, std::vector<Torque>>> wrong{
      {"gravity gradient: mu",
       {GravityGradient(kNan, orbit), GravityGradient(-1.0, orbit), GravityGradient(0.0, orbit)}},
      {"constant: the torque",
       {ConstantTorque{{kNan, 0, 0}}, ConstantTorque{{0, kInf, 0}, ConstantTorque::Axes::inertial}}},
      {"thruster pulse: the duration",
       {ThrusterPulse{10.0, -5.0, {1, 0, 0}}, ThrusterPulse{10.0, 0.0, {1, 0, 0}},
        ThrusterPulse{10.0, kNan, {1, 0, 0}}}},
      {"thruster pulse: the start", {ThrusterPulse{kNan, 5.0, {1, 0, 0}}}},
      {"thruster pulse: the torque", {ThrusterPulse{0.0, 5.0, {1, 0, kNan}}}},
      {"thruster pulse: a pulse", {ThrusterPulse{1e20, 5.0, {1, 0, 0}}}},
      {"linear damping: the coefficient", {LinearDamping{{1, 2, kNan}}, LinearDamping{{kInf, 2, 1}}}},
      {"eddy currents: an element", {EddyCurrents{kNan * unit, {0, 0, 1}, 7.8e15, orbit}}},
      {"eddy currents: the magnetic tensor is not symmetric", {EddyCurrents{lopsided, {0, 0, 1}, 7.8e15, orbit}}},
      {"eddy currents: the axis",
       {EddyCurrents{unit, {0, 0, 2}, 7.8e15, orbit}, EddyCurrents{unit, {0, 0, 0}, 7.8e15, orbit},
        EddyCurrents{unit, {kNan, 0, 1}, 7.8e15, orbit}}},
      {"eddy currents: the dipole is",
       {EddyCurrents{unit, {0, 0, 1}, kNan, orbit}, EddyCurrents{unit, {0, 0, 1}, -1.0, orbit}}},
      {"internal dissipation: the relaxation",
       {InternalDissipation{kNan}, InternalDissipation{-1.0}, InternalDissipation{kInf}}}};
  for (const auto& [beginning, torques] : wrong) {
    for (const Torque& torque : torques) {
      EXPECT_EQ(complaint(torque).substr(0, beginning.size()), beginning) << complaint(torque);
    }
  }
  EXPECT_EQ(complaint(ThrusterPulse{10.0, 5.0, {1, 0, 0}}), "");

  for (const double bad : {-10.0, 0.0, kNan, kInf}) {
    EXPECT_THROW(InternalDissipation::from_quality_factor(bad, {1, 2, 3}, 1.0), InputError);
    EXPECT_THROW(InternalDissipation::from_quality_factor(100.0, {1, 2, 3}, bad), InputError);
  }
  EXPECT_THROW(InternalDissipation::from_quality_factor(100.0, {1, 1, 1}, 1.0), InputError);
  EXPECT_THROW(InternalDissipation::from_quality_factor(100.0, {3, 2, 1}, 1.0), InputError);

  TriangleMesh plate;
  plate.vertices = {{3, 0, 0}, {3, 0, 2}, {3, 2, 0}};
  plate.facets = {{0, 1, 2}};
  TriangleMesh without_facets = plate, without_corner = plate, not_finite = plate;
  without_facets.facets.clear();
  without_corner.facets[0][2] = 3;
  not_finite.vertices[1][0] = kNan;
  for (const TriangleMesh& mesh : {without_facets, without_corner, not_finite}) {
    EXPECT_THROW(Sunlight(mesh, {0.0, 0.0}, orbit), InputError);
  }
  EXPECT_THROW(Sunlight(plate, {kNan, 0.0}, orbit), InputError);
}

TEST(Arguments, OrbitsThatAreNoneAreRefused) {
  const auto refused = [](double mu, double q, double e, double t, const Vector3& x, const Vector3& normal) {
    EXPECT_THROW(KeplerOrbit({mu, q, e, t, x, normal}), InputError) << mu << ' ' << q << ' ' << e << ' ' << t;
  };
  const Vector3 x(1, 0, 0), z(0, 0, 1);
  refused(kNan, 7e6, 0.1, 0.0, x, z);
  refused(kInf, 7e6, 0.1, 0.0, x, z);
  refused(kEarth, 7e6, 0.1, kNan, x, z);
  refused(kEarth, 7e6, 0.1, kInf, x, z);
  refused(kEarth, 7e6, 0.1, 0.0, {0, 0, 0}, z);
  refused(kEarth, 7e6, 0.1, 0.0, {kNan, 0, 1}, z);
  refused(kEarth, 7e6, 0.1, 0.0, x, {0, 0, 0});
  refused(kEarth, 7e6, 0.1, 0.0, x, {0, kInf, 0});
  refused(kEarth, 7e6, 0.1, 1.1e12, x, z);
  refused(kEarth, 7e6, 0.1, -1e16, x, z);
  refused(kEarth, 7e6, 0.1, 0.0, x, {3e-4, 0, 1});  // no right angle
  EXPECT_NO_THROW(KeplerOrbit({kEarth, 7e6, 0.1, 1e12, 1e-200 * x, {1e-4, 0, 1}}));
  refused(kEarth, 5e-324, 0.1, 0.0, x, z);  // no double holds the distance squared
  EXPECT_TRUE(std::isnan(KeplerOrbit({kEarth, 7e6, 0.1, 0.0, x, z}).state(kNan).position_m[0]));

  const auto table = [](double time_s, double x_m, double vx_m_s) {
    return TabulatedOrbit({OrbitTable{{0.0, time_s, 20.0},
                                      {{1e7, 0, 0}, {x_m, 0, 0}, {1e7, 0, 0}},
                                      {{0, 1, 0}, {vx_m_s, 1, 0}, {0, 1, 0}},
                                      3,
                                      {},
                                      {}}});
  };
  EXPECT_NO_THROW(table(10.0, 1e7, 0.0));
  EXPECT_THROW(table(kNan, 1e7, 0.0), InputError);
  EXPECT_THROW(table(10.0, kNan, 0.0), InputError);
  EXPECT_THROW(table(10.0, 0.0, 0.0), InputError);
  EXPECT_THROW(table(10.0, 1e7, kInf), InputError);
  EXPECT_THROW(table(10.0, 1e7, 0.0).state(kNan), InputError);
}

TEST(Arguments, ATimeThatIsNotFiniteGivesNan) {
  const std::vector<double> times{1.0, kNan, -2.0, kInf, 3.0, -kInf, 2.0};
  for (const rivals::MeasuredMethod& method : rivals::measured_methods()) {
    const auto motion = method.make(kBody);
    std::vector<double> q(4 * times.size()), m(3 * times.size());
    motion->batch({times}, StateArrays::of_structures(q.data(), m.data()));
    for (std::size_t i = 0; i < times.size(); ++i) {
      const State alone = motion->at(times[i]);
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_EQ(std::isfinite(q[4 * i + k]), std::isfinite(times[i])) << method.name;
      EXPECT_EQ(alone.q_inertial_from_body.coeffs().allFinite(), std::isfinite(times[i])) << method.name << times[i];
    }
    EXPECT_LT(rotation_angle_rad(from_scalar_first(Eigen::Map<Eigen::Vector4d>(&q[24])),
                                 motion->at(2.0).q_inertial_from_body),
              1e-2)
        << method.name;
  }
  // Beside and on the separatrix, on an axis, a symmetric body.
  for (const FreeBody& body : {FreeBody{{1.0, 2.0, 2.5}, {1, 0, 0, 0}, {0.6e-40, 1.0, 0.6e-40}},
                               FreeBody{{1.0, 2.0, 3.0}, {1, 0, 0, 0}, {1e-3, 1.0, 0.0}},
                               FreeBody{{1.0, 2.0, 3.0}, {1, 0, 0, 0}, {0.0, 0.0, 1.0}},
                               FreeBody{{1.0, 1.0, 3.0}, {1, 0, 0, 0}, {0.1, 0.2, 1.0}}}) {
    for (const char* name : {"theta", "legendre"}) {
      const auto motion = method(name).make(body);
      std::vector<double> q(4 * times.size()), m(3 * times.size());
      motion->batch({times}, StateArrays::of_structures(q.data(), m.data()));
      for (std::size_t i = 0; i < times.size(); ++i) {
        const bool good = std::isfinite(times[i]);
        EXPECT_EQ(std::isfinite(q[4 * i] + q[4 * i + 1] + q[4 * i + 2] + q[4 * i + 3]), good) << name << times[i];
        EXPECT_EQ(motion->at(times[i]).q_inertial_from_body.coeffs().allFinite(), good) << name << times[i];
      }
    }
  }
  // The low part counts too.
  EXPECT_TRUE(std::isnan(ThetaMotion(kBody).at(1.0, kNan).momentum_body[0]));
  const TorquedMotion torqued(kBody, constant_torque(), {1e-6, 0.0, 10.0});
  EXPECT_TRUE(std::isnan(torqued.at(kNan).momentum_body[0]));
  EXPECT_THROW(torqued.at(kInf), InputError);
}

TEST(Arguments, LowPartsOfTimesAreAsManyAsTheTimes) {
  const std::vector<double> high{1.0, 2.0, 3.0}, low{0.0, 0.0};
  std::vector<double> q(12), m(9);
  const StateArrays out = StateArrays::of_structures(q.data(), m.data());
  for (const rivals::MeasuredMethod& method : rivals::measured_methods()) {
    EXPECT_THROW(method.make(kBody)->batch({high, low}, out), InputError) << method.name;
    EXPECT_THROW(batch_threads(*method.make(kBody), {high, low}, out), InputError) << method.name;
  }
}

TEST(Arguments, AnUncheckedMomentumThatIsNotFiniteGivesNanAndEnds) {
  for (const theta::Target* target : [] {
         const theta::Target* all[3];
         const std::size_t count = theta::targets(all);
         return std::vector<const theta::Target*>(all, all + count);
       }()) {
    for (const auto span : {ThetaMotion::Span::any, ThetaMotion::Span::step}) {
      for (int k = 0; k < 3; ++k) {
        for (const double bad : {kNan, kInf}) {
          FreeBody body = kBody;
          body.momentum_body[k] = bad;
          const ThetaMotion motion(ThetaMotion::Unchecked{}, body, span, *target);
          EXPECT_TRUE(motion.at(1.0).q_inertial_from_body.coeffs().array().isNaN().any()) << k << bad << target->name;
        }
      }
    }
  }
}

TEST(Arguments, MotionsCanBeMovedAndKeptInAVector) {
  std::vector<ThetaMotion> free;
  std::vector<TorquedMotion> torqued;
  for (int i = 1; i <= 20; ++i) {
    FreeBody body = kBody;
    body.momentum_body *= i;
    free.emplace_back(body);
    torqued.emplace_back(body, constant_torque(), TorquedOptions{1e-9, 0.0, 5.0});
  }
  for (int i = 1; i <= 20; ++i) {
    FreeBody body = kBody;
    body.momentum_body *= i;
    const auto n = static_cast<std::size_t>(i - 1);
    EXPECT_EQ(free[n].at(4.0).momentum_body, ThetaMotion(body).at(4.0).momentum_body);
    EXPECT_EQ(torqued[n].at(4.0).momentum_body,
              TorquedMotion(body, constant_torque(), {1e-9, 0.0, 5.0}).at(4.0).momentum_body);
  }
  static_assert(std::is_nothrow_move_constructible_v<ThetaMotion> && std::is_move_assignable_v<TorquedMotion> &&
                std::is_move_constructible_v<KickedMotion> && !std::is_copy_constructible_v<Motion>);
}

TEST(Arguments, NothingPointsIntoWhatTheCallerFreed) {
  auto name = std::make_unique<std::string>("dormand-prince");
  const TorquedMotion motion(kBody, constant_torque(), {1e-6, 0.0, 5.0, *name});
  const std::string_view method = motion.method();
  name->assign("xxxxxxxxxxxxxx");  // where the name stood
  name.reset();
  EXPECT_EQ(method, "dormand-prince");
  SplittingRun run(kBody, 0.0, constant_torque(), kStrang);  // of torques that are gone
  run.step(0.1);
  EXPECT_TRUE(run.state().momentum_body.allFinite());
}

TEST(ParallelChunks, TheFirstExceptionReachesTheCallerAfterAllAreDone) {
  for (const unsigned threads : {1U, 2U, 7U}) {
    std::vector<int> done(1000, 0);
    try {
      parallel_chunks(1000, 10, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) done[i] = 1;
        throw InputError("chunk at " + std::to_string(begin));
      });
      FAIL();
    } catch (const InputError& error) {
      EXPECT_STREQ(error.what(), "chunk at 0");
    }
    EXPECT_EQ(std::count(done.begin(), done.end(), 1), 1000);
  }
}

TEST(ParallelChunks, AMotionThatRefusesATimeDoesSoOnAllThreads) {
  const TorquedMotion motion(kBody, constant_torque(), {1e-6, 0.0, 10.0});
  std::vector<double> times(3000, 1.0), q(12000), m(9000);
  times[700] = 11.0;  // beyond the span
  EXPECT_THROW(batch_threads(motion, {times}, StateArrays::of_structures(q.data(), m.data()), 4), InputError);
}

TEST(Arguments, AnInertiaThatIsNoneIsRefused) {
  const Vector3 m(0.1, 0.2, 1.0);
  const auto refused = [&](const Inertia& inertia) {
    EXPECT_THROW(check(inertia), InputError);
    EXPECT_THROW(spin_invariants(inertia, m), InputError);
    EXPECT_THROW(equivalent_ellipsoid_ratios(inertia), InputError);
    EXPECT_THROW(solve_periods(inertia, {AxisConvention::long_axis, 2.0, 1.0, {}}), InputError);
    EXPECT_THROW(energy_at(inertia, AxisConvention::long_axis, 0.3, 0.2), InputError);
    Body body;
    body.inertia = inertia;
    body.state = SpinState{};
    body.state->omega_named_rad_s = m;
    EXPECT_THROW(momentum_principal(body), InputError);
    EXPECT_THROW(Ephemeris({}, body, Frame::icrf, TimeGrid::with_count({}, {}, 1, TimeScale::tt),
                           [](auto, auto, double*, double*) {}),
                 InputError);
  };
  refused({{3, 2, 1}});
  refused({{1, 2, kNan}});
  refused({{0, 1, 1}});
  refused({{1, 2, 4}});  // no body has these
  refused({{2, 3, 4}, Matrix3::Zero()});
  refused({{2, 3, 4}, -Matrix3::Identity()});
  EXPECT_THROW(spin_invariants({{2, 3, 4}}, {kNan, 0, 1}), InputError);
  EXPECT_THROW(solve_periods({{2, 3, 4}}, {AxisConvention::long_axis, kInf, 1.0, {}}), InputError);
  EXPECT_THROW(state_at({{2, 3, 4}}, AxisConvention::long_axis, {}, 0.0, kNan, false), InputError);
  EXPECT_THROW(q_frame_from_momentum(kNan, 0.0), InputError);
}

TEST(Arguments, AnglesAndFramesAreChecked) {
  const EulerSequence zxz("ZXZ");
  EXPECT_THROW(q_frame_from_body(zxz, {0.0, kNan, 0.0}), InputError);
  EXPECT_THROW(omega_body_rad_s(zxz, {0.0, 1.0, 0.0}, {kInf, 0.0, 0.0}), InputError);
  EXPECT_THROW(euler_angles_rad(zxz, Quaternion(0, 0, 0, 0)), InputError);
  EXPECT_THROW(euler_angles_rad(zxz, Quaternion(kNan, 0, 0, 0)), InputError);
  EXPECT_THROW(direction_of({0, 0, 0}), InputError);
  EXPECT_THROW(direction_of({0, kNan, 0}), InputError);
  for (const EarthOrientation& earth : {EarthOrientation{kNan, 0.0, 0.0}, EarthOrientation{1e300, 0.0, 0.0},
                                        EarthOrientation{0.0, kNan, 0.0}, EarthOrientation{0.0, 0.0, 300.0}}) {
    EXPECT_THROW(q_icrf_from(Frame::itrf, {}, earth), InputError);
    EXPECT_THROW(q_icrf_from(Frame::teme, {}, earth), InputError);
  }
  EXPECT_NO_THROW(q_icrf_from(Frame::itrf, {}, {-0.2, 0.1, 0.4}));
}

TEST(Arguments, TimesAreChecked) {
  EXPECT_THROW(Instant::from_tt_j2000({kNan, 0.0}), InputError);
  EXPECT_THROW(Instant{} + Seconds(0.0, kInf), InputError);
  EXPECT_THROW(instant_from_j2000({kInf, 0.0}, TimeScale::tdb), InputError);
  const Instant start, stop = Instant{} + Seconds{100.0, 0.0};
  EXPECT_THROW(TimeGrid::with_step(start, stop, {kNan, 0.0}, TimeScale::tt), InputError);
  EXPECT_THROW(TimeGrid::with_step(start, stop, {10.0, kNan}, TimeScale::tt), InputError);
  EXPECT_THROW(TimeGrid::with_step(start, stop, {-10.0, 0.0}, TimeScale::tt), InputError);
  EXPECT_THROW(TimeGrid::with_step(stop, start, {10.0, 0.0}, TimeScale::tt), InputError);
  EXPECT_THROW(TimeGrid::with_count(start, stop, 0, TimeScale::tt), InputError);
  const TimeGrid grid = TimeGrid::with_step(start, stop, {10.0, 0.0}, TimeScale::tt);
  EXPECT_THROW(grid.time(11, {}), InputError);
  EXPECT_THROW(grid.time(0, {TimeResolution::Kind::decimals, -1}), InputError);
  for (const double wrong : {-12.0, 12.5, 13.0, kNan}) {
    EXPECT_THROW(set_leap_seconds({{1972, 1, 10.0}, {1972, 7, 11.0}, {1973, 1, wrong}}), InputError) << wrong;
  }
  for (const TimeScale scale :
       {TimeScale::tt, TimeScale::tai, TimeScale::utc, TimeScale::tdb, TimeScale::gps, TimeScale::et}) {
    EXPECT_THROW(format_date(Instant{} + Seconds(1e300, 0.0), scale, 3), InputError) << name(scale);
    EXPECT_THROW(format_date(Instant{}, scale, -1), InputError) << name(scale);
  }
  const PrincipalMotion none = [](auto, auto, double*, double*) {};
  for (const double bad : {kNan, kInf}) {
    EXPECT_THROW(rows_for_tolerance(none, kBody.principal_moments, 0.0, bad, 1e-3, 0.0, RowInterpolation::great_circle),
                 InputError);
    EXPECT_THROW(rows_for_tolerance(none, kBody.principal_moments, 0.0, 1.0, bad, 0.0, RowInterpolation::great_circle),
                 InputError);
    EXPECT_THROW(
        rows_for_tolerance(none, kBody.principal_moments, 0.0, 1.0, 1e-3, -bad, RowInterpolation::great_circle),
        InputError);
  }
}

TEST(Arguments, AnAttitudeHistoryThatIsNoneMakesNoEphemeris) {
  AttitudeSegment segment;
  segment.frame = "ICRF";
  const TimeGrid grid = TimeGrid::with_count({}, {}, 1, TimeScale::tt);
  const auto refused = [&](std::vector<AttitudeSample> rows) {
    segment.samples = std::move(rows);
    EXPECT_THROW(Ephemeris({}, segment, std::nullopt, grid), InputError);
  };
  const Instant later = Instant{} + Seconds{1.0, 0.0};
  const Vector3 rate(0, 0, 1);
  const Quaternion unit = Quaternion::Identity();
  refused({});
  refused({{later, unit, rate}, {{}, unit, rate}});
  refused({{{}, unit, rate}, {later, Quaternion(0, 0, 0, 0), rate}});
  refused({{{}, unit, rate}, {later, Quaternion(kNan, 0, 0, 0), rate}});
  refused({{{}, unit, rate}, {later, unit, std::nullopt}});
  refused({{{}, unit, rate}, {later, unit, Vector3(kNan, 0, 0)}});
  segment.samples = {{{}, unit, rate}, {later, unit, rate}};
  EXPECT_NO_THROW(Ephemeris({}, segment, std::nullopt, grid));
}

TEST(Arguments, EllipticFunctionsGiveNanOutsideOfTheirRange) {
  for (const double bad : {0.0, -0.5, kNan}) {
    EXPECT_TRUE(std::isnan(Jacobi(bad).quarter_period())) << bad;
    EXPECT_TRUE(std::isnan(Jacobi(bad).at_half_period_fraction(0.1).sn)) << bad;
    EXPECT_TRUE(std::isnan(complete_integral(bad, 1.0, 1.0, 1.0))) << bad;
    EXPECT_TRUE(std::isnan(complete_integral(0.5, bad, 1.0, 1.0))) << bad;
    EXPECT_TRUE(std::isnan(carlson_rj_of_roots(1.0, 2.0, 3.0, bad))) << bad;
  }
  for (const double bad : {-0.5, kNan}) {
    EXPECT_TRUE(std::isnan(carlson_rj_of_roots(bad, 2.0, 3.0, 1.0))) << bad;
    EXPECT_TRUE(std::isnan(incomplete_f(bad, 0.5, 0.5))) << bad;
    EXPECT_TRUE(std::isnan(incomplete_f(0.5, bad, 0.5))) << bad;
    EXPECT_TRUE(std::isnan(carlson_rf_of_roots(bad, 1.0, 2.0))) << bad;
    EXPECT_TRUE(std::isnan(reciprocal_complete_k(bad))) << bad;
  }
  EXPECT_TRUE(std::isnan(carlson_rj_of_roots(0.0, 0.0, 1.0, 1.0)));
}

}  // namespace
}  // namespace polhode
