#include "polhode/motion/planner.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/kicked_motion.hpp"
#include "polhode/motion/splitting.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/motion/torqued_motion.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/time/scale.hpp"
#include "rivals/extrapolated_motion.hpp"

namespace polhode {
namespace {

/// The normal turned to a right angle to the periapsis.
KeplerElements with_right_angle(KeplerElements orbit) {
  const Vector3 x = orbit.to_periapsis.normalized();
  orbit.along_normal = (orbit.along_normal - x.dot(orbit.along_normal) * x).normalized();
  return orbit;
}

constexpr double kEarth = 3.986004418e14;
const std::string kScenes = POLHODE_DATA_DIR "/scenes/";

double turned_rad(const Motion& a, const Motion& b, double t) {
  return rotation_angle_rad(a.at(t).q_inertial_from_body, b.at(t).q_inertial_from_body);
}

TEST(Planner, EverySceneStaysWithinItsAccuracyOfTheFullModel) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".toml") continue;
    ++scenes;
    const Scene scene = read_scene(entry.path());
    const FreeBody body = free_body(scene.body, scene.frame);
    // Long scenes are cut to 3000 rad, for the time the full model takes.
    const double rate = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
    const double last_s = std::min(scene.last_s, 3000.0 / rate);
    const Plan plan = plan_motion(body, scene.torques, 0.0, last_s, scene.accuracy_rad);
    const Plan full = plan_motion(body, scene.torques, 0.0, last_s, scene.accuracy_rad, true);
    ASSERT_LE(plan.error_rad, scene.accuracy_rad) << scene.name;
    EXPECT_EQ(full.dropped_rad, 0.0);
    const PlannedMotion cheap = planned_motion(plan, body, 0.0, last_s), all = planned_motion(full, body, 0.0, last_s);
    const rivals::ExtrapolatedMotion truth(body, scene.torques, {1e-10, 0.0, last_s});
    ASSERT_LE(truth.error_rad(), 1e-10) << scene.name;
    double worst = 0.0;
    for (int i = 0; i <= 20; ++i) {
      const double t_s = last_s * i / 20.0;
      worst = std::max(worst, turned_rad(*cheap.motion, *all.motion, t_s));
      for (const PlannedMotion* planned : {&cheap, &all}) {
        EXPECT_LE(turned_rad(*planned->motion, truth, t_s), *planned->account.max_error_rad + 1e-10)
            << scene.name << " by " << planned->account.method << " at " << t_s;
      }
    }
    EXPECT_LE(worst, plan.error_rad) << scene.name;
    EXPECT_LE(*cheap.account.max_error_rad, scene.accuracy_rad) << scene.name;
    if (const auto* ran = dynamic_cast<const TorquedMotion*>(all.motion.get())) {
      EXPECT_EQ(all.account.method, ran->method()) << scene.name;
      EXPECT_EQ(all.account.torque_evaluations, ran->torque_evaluations()) << scene.name;
    }
    // Where all is kept and the accuracy is high, the two differ by luck only.
    EXPECT_LE(static_cast<double>(cheap.account.torque_evaluations),
              1.2 * static_cast<double>(all.account.torque_evaluations))
        << scene.name;
    std::printf("%-62s off %.1e of %.1e rad, %zu of %zu torque evaluations\n", scene.name.c_str(), worst,
                scene.accuracy_rad, cheap.account.torque_evaluations, all.account.torque_evaluations);
    EXPECT_LE(worst, *cheap.account.max_error_rad + *all.account.max_error_rad) << scene.name;
    if (plan.torque_evaluations && *plan.torque_evaluations > 0.0) {
      const double ratio = static_cast<double>(cheap.account.torque_evaluations) / *plan.torque_evaluations;
      EXPECT_TRUE(ratio > 0.5 && ratio < 2.0) << scene.name << ": " << ratio << " of " << *plan.torque_evaluations;
    }
  }
  EXPECT_GE(scenes, 6);
}

/// An accurate run of (10,6,4) at short steps: `parts` states over the span, the start left out.
std::vector<State> accurate_states(const FreeBody& body, const Torques& torques, double last_s, int parts,
                                   double step_rad) {
  const double rate = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
  const auto steps = static_cast<int>(std::ceil(last_s / parts * rate / step_rad));
  SplittingRun run(body, 0.0, torques, kNear1064);
  std::vector<State> states;
  for (int part = 0; part < parts; ++part) {
    for (int i = 0; i < steps; ++i) run.step(last_s / parts / steps);
    states.push_back(run.state());
  }
  return states;
}

TEST(Planner, AMonthOfEnvisatAtOneDegreeTakesAHandfulOfKicksPerTurn) {
  const Scene scene = read_scene(kScenes + "envisat-month.toml");
  const FreeBody body = free_body(scene.body, scene.frame);
  const Plan plan = plan_motion(body, scene.torques, scene.first_s, scene.last_s, scene.accuracy_rad);
  EXPECT_TRUE(plan.few_kicks);
  const PlannedMotion planned = planned_motion(plan, body, scene.first_s, scene.last_s);
  // (10,6,4) at a step of 1.5 rad is good to 0.01 deg over the month.
  const std::vector<State> exact = accurate_states(body, scene.torques, scene.last_s, 60, 1.5);
  double worst = 0.0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double t = scene.last_s * static_cast<double>(i + 1) / static_cast<double>(exact.size());
    worst =
        std::max(worst, rotation_angle_rad(planned.motion->at(t).q_inertial_from_body, exact[i].q_inertial_from_body));
  }
  EXPECT_LE(worst, plan.error_rad);
  EXPECT_EQ(planned.account.method, "splitting, few kicks per turn");
  EXPECT_LE(*planned.account.max_error_rad, plan.error_rad);
  EXPECT_LE(worst, *planned.account.max_error_rad);
  const double turns = scene.last_s * body.momentum_body.cwiseQuotient(body.principal_moments).norm() / 6.2832;
  const double per_turn = static_cast<double>(planned.account.torque_evaluations) / turns;
  EXPECT_LT(per_turn, 13.0);
  ASSERT_TRUE(plan.torque_evaluations.has_value());
  const double expected = *plan.torque_evaluations;
  EXPECT_NEAR(expected, static_cast<double>(planned.account.torque_evaluations), 0.2 * expected);
  // The full model of a fiftieth of the month; it takes the same steps all along.
  const double part_s = scene.last_s / 50.0;
  const Plan full = plan_motion(body, scene.torques, 0.0, part_s, scene.accuracy_rad, true);
  const auto in_part = static_cast<double>(planned_motion(full, body, 0.0, part_s).account.torque_evaluations);
  const double saved = 50.0 * in_part / static_cast<double>(planned.account.torque_evaluations);
  std::printf("off by %.2e rad of %.2e, %.1f torque evaluations per turn; the full model takes %.0f times as many\n",
              worst, scene.accuracy_rad, per_turn, saved);
  EXPECT_GT(saved, 8.0);
}

TEST(Planner, FewKicksKeepTheirPromiseOnRandomSatellites) {
  std::mt19937_64 random(7146);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Vector3(normal(random), normal(random), normal(random)).normalized(); };
  int served = 0, tried = 0;
  double tightest = 0.0;
  for (int n = 0; n < 30; ++n) {
    Vector3 moments(unit(random), unit(random), 0.0);
    moments = 100.0 * (moments.array() + 0.05);
    moments[2] = std::max(moments[0], moments[1]) + unit(random) * std::min(moments[0], moments[1]);
    std::sort(moments.data(), moments.data() + 3);
    const double rate = 0.03 * std::pow(10.0, unit(random));
    const FreeBody body{moments, Quaternion(Eigen::AngleAxisd(6.28 * unit(random), direction())),
                        moments.cwiseProduct(rate * direction())};
    const KeplerElements orbit =
        with_right_angle({kEarth, 7e6, 0.05 * unit(random), 1000.0 * unit(random), direction(), direction()});
    const auto beside = [&]() -> Torque {
      if (n % 3 == 0) return LinearDamping{moments * rate * 1e-7};
      return ConstantTorque{moments[2] * rate * rate * 1e-7 * direction(), ConstantTorque::Axes::body};
    };
    const Torques torques({GravityGradient(kEarth, orbit), beside()});
    const double last_s = 12000.0 / rate, tolerance_rad = std::pow(10.0, -1.0 - 2.0 * unit(random));
    ++tried;
    const auto motion = KickedMotion::make(body, torques, {tolerance_rad, 0.0, last_s});
    if (!motion) continue;
    ++served;
    EXPECT_LE(motion->error_rad(), tolerance_rad);
    const std::vector<State> exact = accurate_states(body, torques, last_s, 12, 1.2);
    double worst = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double t = last_s * static_cast<double>(i + 1) / static_cast<double>(exact.size());
      worst = std::max(worst, rotation_angle_rad(motion->at(t).q_inertial_from_body, exact[i].q_inertial_from_body));
    }
    EXPECT_LE(worst, tolerance_rad) << "satellite " << n << ", estimated " << motion->error_rad();
    tightest = std::max(tightest, worst / tolerance_rad);
  }
  std::printf("few kicks served %d of %d; the closest came to %.2f of its tolerance\n", served, tried, tightest);
  EXPECT_GT(served, 10);
}

TEST(Planner, FewKicksRefuseWhatTheyAreNotFor) {
  const Vector3 moments(17000, 124800, 129200), omega(-0.001, 0.0, 0.05);
  const FreeBody body{moments, Quaternion::Identity(), moments.cwiseProduct(omega)};
  const KeplerElements low{kEarth, 7.146e6, 0.0, 0.0, {1, 0, 0}, {0, 0.6, 0.8}};
  const auto serves = [](const FreeBody& b, const Torques& torques, double last_s) {
    return KickedMotion::make(b, torques, {0.01, 0.0, last_s}) != nullptr;
  };
  const Torques gravity({GravityGradient(kEarth, low)});
  EXPECT_TRUE(serves(body, gravity, 3e5));
  EXPECT_FALSE(serves(body, gravity, 3e4));  // few turns
  FreeBody near_separatrix = body;
  near_separatrix.momentum_body = {1.0, 124800 * 0.05, 1.0};
  EXPECT_FALSE(serves(near_separatrix, gravity, 3e5));
  const Torques flyby({GravityGradient(kEarth, KeplerElements{kEarth, 7e6, 3.0, 1e5, {1, 0, 0}, {0, 0.6, 0.8}})});
  FreeBody slow = body;
  slow.momentum_body *= 0.2;
  EXPECT_FALSE(serves(slow, flyby, 1e6));  // over within a turn
  EXPECT_FALSE(serves(body, Torques({GravityGradient(kEarth, low), ThrusterPulse{1e5, 1.0, {1, 0, 0}}}), 3e5));
  const auto motion = KickedMotion::make(body, gravity, {0.01, -2e5, 3e5});
  ASSERT_NE(motion, nullptr);
  EXPECT_LT(rotation_angle_rad(motion->at(0.0).q_inertial_from_body, body.q_inertial_from_body), 1e-14);
  EXPECT_THROW(motion->at(-2.1e5), InputError);
  EXPECT_THROW(motion->at(3.1e5), InputError);
  // Before t = 0 as after it.
  const TorquedMotion exact(body, gravity, {1e-5, -2e4, 0.0});
  EXPECT_LT(rotation_angle_rad(motion->at(-2e4).q_inertial_from_body, exact.at(-2e4).q_inertial_from_body), 0.01);
}

struct RandomScene {
  FreeBody body;
  Torques torques;
  double first_s, last_s;
};

/// Every kind of torque in turn, from a body that lasts `turned_rad` of rotation.
class RandomScenes {
 public:
  explicit RandomScenes(unsigned seed) : random_(seed) {}

  double log_between(double low, double high) { return low * std::pow(high / low, unit_(random_)); }

  RandomScene next(double least_rad, double most_rad) {
    const int n = count_++;
    Vector3 moments(unit_(random_), unit_(random_), 0.0);
    moments = 100.0 * (moments.array() + 0.05);
    moments[2] = std::max(moments[0], moments[1]) + unit_(random_) * std::min(moments[0], moments[1]);
    std::sort(moments.data(), moments.data() + 3);
    const double rate = log_between(1e-3, 1e-1);
    const FreeBody body{moments, Quaternion(Eigen::AngleAxisd(6.28 * unit_(random_), direction())),
                        moments.cwiseProduct(rate * direction())};
    const double last_s = log_between(least_rad, most_rad) / rate, first_s = n % 4 == 0 ? -0.5 * last_s : 0.0;
    const double momentum = body.momentum_body.norm();
    const KeplerElements orbit =
        with_right_angle({kEarth * log_between(1e-8, 1.0), log_between(7e6, 1e8), 3.0 * unit_(random_),
                          last_s * unit_(random_), direction(), direction()});
    Torque torque = GravityGradient(orbit.mu_m3_s2, orbit);
    switch (n % 6) {
      case 0:
        torque = ConstantTorque{momentum * rate * log_between(1e-10, 1e-4) * direction(),
                                n % 2 == 0 ? ConstantTorque::Axes::body : ConstantTorque::Axes::inertial};
        break;
      case 1:
        torque = LinearDamping{moments * rate * log_between(1e-10, 1e-4)};
        break;
      case 2:
        torque = ThrusterPulse{last_s * unit_(random_), last_s * unit_(random_),
                               momentum * rate * log_between(1e-10, 1e-4) * direction()};
        break;
      case 4: {  // the tensor of a hollow conductor, not in the principal axes
        const Vector3 axis = direction();
        const Matrix3 tensor = Matrix3::Identity() + axis * axis.transpose();
        torque = EddyCurrents{log_between(1e-6, 1e2) * tensor, direction(), 7.8e15, orbit};
        break;
      }
      case 3:
        torque = InternalDissipation{log_between(1e-10, 1e-4) / momentum};
        break;
      default:
        break;
    }
    return {body, Torques({torque}), first_s, last_s};
  }

 private:
  Vector3 direction() { return Vector3(normal_(random_), normal_(random_), normal_(random_)).normalized(); }

  std::mt19937_64 random_;
  std::uniform_real_distribution<double> unit_{0.0, 1.0};
  std::normal_distribution<double> normal_;
  int count_ = 0;
};

TEST(Planner, BoundsHoldInAThousandRandomScenes) {
  RandomScenes scenes(20290413);
  int dropped = 0, close = 0;
  double tightest = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const auto [body, torques, first_s, last_s] = scenes.next(1.0, 60.0);
    const Plan plan = plan_motion(body, torques, first_s, last_s, 0.02);  // drops what turns it by less than 0.0075 rad
    if (plan.effects[0].kept) continue;
    ++dropped;
    const ThetaMotion free(body);
    const rivals::ExtrapolatedMotion real(body, torques,
                                          {std::min(1e-9, 0.01 * plan.dropped_rad + 1e-13), first_s, last_s});
    double worst = 0.0;
    for (int i = 1; i <= 8; ++i) {
      worst = std::max({worst, turned_rad(free, real, last_s * i / 8.0), turned_rad(free, real, first_s * i / 8.0)});
    }
    EXPECT_LE(worst, plan.dropped_rad + 1e-12) << "scene " << n << ", " << plan.effects[0].name;
    if (plan.dropped_rad > 1e-10) tightest = std::max(tightest, worst / plan.dropped_rad);
    if (worst > 0.01 * plan.dropped_rad) ++close;
  }
  std::printf("%d of 1000 dropped; the closest came to %.2f of its bound, %d above a hundredth\n", dropped, tightest,
              close);
  EXPECT_GT(dropped, 300);
  EXPECT_GT(close, dropped / 10);  // bounds, not excuses
}

/// What ran against what was expected, of scenes that are a few turns to thousands long; and the promise against a run
/// to a hundredth of it.
TEST(Planner, PredictsItsCostOrSaysThatItCannotTell) {
  RandomScenes scenes(75);
  int told = 0, kept = 0, refused = 0;
  double worst = 1.0, least_kept = 0.0;
  for (int n = 0; n < 200; ++n) {
    const auto [body, torques, first_s, last_s] = scenes.next(10.0, 5000.0);
    const double accuracy_rad = scenes.log_between(1e-7, 1e-2);
    const Plan plan = plan_motion(body, torques, first_s, last_s, accuracy_rad);
    EXPECT_LE(plan.error_rad, accuracy_rad);
    EXPECT_FALSE(plan.cost_why.empty());
    PlannedMotion planned;
    try {
      planned = planned_motion(plan, body, first_s, last_s);
    } catch (const ComputationError&) {
      ++refused;  // says so, and promises nothing
      continue;
    }
    if (plan.torque_evaluations) {
      ++told;
      const double ratio =
          (static_cast<double>(planned.account.torque_evaluations) + 1.0) / (*plan.torque_evaluations + 1.0);
      EXPECT_LT(ratio, 2.0) << "scene " << n << ", " << plan.effects[0].name << ", " << plan.cost_why;
      EXPECT_GT(ratio, 0.5) << "scene " << n << ", " << plan.effects[0].name << ", " << plan.cost_why;
      worst = std::max({worst, ratio, 1.0 / ratio});
    }
    const double promised_rad = planned.account.max_error_rad.value();
    EXPECT_LE(promised_rad, plan.error_rad) << "scene " << n;
    TorquedOptions finer{0.001 * promised_rad, first_s, last_s};
    if (finer.tolerance_rad < 1e-13) continue;
    finer.max_torque_evaluations = 20 * kMostTorqueEvaluations;
    const TorquedMotion truth(body, torques, finer);
    if (truth.outcome() != Outcome::done) continue;
    ++kept;
    for (int i = 0; i <= 40; ++i) {
      const double t_s = std::lerp(first_s, last_s, i / 40.0), off_rad = turned_rad(*planned.motion, truth, t_s);
      EXPECT_LE(off_rad, 1.01 * promised_rad)
          << "scene " << n << ", " << plan.effects[0].name << ", by " << planned.account.method << " at " << t_s;
      least_kept = std::max(least_kept, off_rad / promised_rad);
    }
  }
  std::printf(
      "cost told of %d of 200, off by a factor of %.2f at most; %d promises looked at, the closest reached %.3f of it; "
      "%d not computed\n",
      told, worst, kept, least_kept, refused);
  EXPECT_GT(told, 100);
  EXPECT_GT(kept, 150);
}

TEST(Planner, NamesTheFreeModel) {
  const auto model = [](const Vector3& moments, const Vector3& momentum) {
    return plan_motion({moments, Quaternion::Identity(), momentum}, Torques(), 0.0, 100.0, 1e-3).model;
  };
  EXPECT_EQ(model({1, 2, 3}, {1e-5, 0, 1}), "principal-axis rotation");
  EXPECT_EQ(model({2, 2, 3}, {0.3, 0, 1}), "symmetric top");
  EXPECT_EQ(model({1, 2, 3}, {0.3, 0, 1}), "free triaxial");
  EXPECT_EQ(model({1, 2, 3}, {0, 1, 1e-6}), "free triaxial");  // beside the middle axis it does not stay
}

/// The encounter of 2029 on its hyperbola, over the phases of the tumbling at perigee, which the published periods do
/// not give. Benson et al. 2023 (arXiv:2210.13365): the short-axis mode is likely kept, but the effective spin rate
/// could halve or double; the pole likely shifts by 10 deg or more, gains in longitude and comes closer to the
/// ecliptic.
TEST(Scenes, ApophisOverTheEncounterPhase) {
  const Scene scene = read_scene(kScenes + "apophis-2029.toml");
  const FreeBody start = free_body(scene.body, scene.frame);
  const ThetaMotion before(start);
  const double deg = std::numbers::pi / 180.0;
  int moved = 0, short_axis = 0, longer = 0, closer = 0;
  double most_deg = 0.0, slowest = 10.0, fastest = 0.0;
  std::vector<double> shifts_deg;
  constexpr int count = 400;
  for (int i = 0; i < count; ++i) {  // the state of another time at the epoch: another pair of phases
    const State state = before.at(i * 3.7e4);
    const FreeBody body{start.principal_moments, state.q_inertial_from_body, state.momentum_body};
    const TorquedMotion motion(body, scene.torques, {1e-5, 0.0, scene.last_s});
    ASSERT_EQ(motion.outcome(), Outcome::done);
    const State end = motion.at(scene.last_s);
    const Vector3 L0 = state.q_inertial_from_body * state.momentum_body;
    const Vector3 L1 = end.q_inertial_from_body * end.momentum_body;
    shifts_deg.push_back(std::atan2(L0.cross(L1).norm(), L0.dot(L1)) / deg);
    const auto twice_energy = [&](const Vector3& m) { return m.dot(m.cwiseQuotient(body.principal_moments)); };
    const double rate = (twice_energy(end.momentum_body) / L1.norm()) / (twice_energy(state.momentum_body) / L0.norm());
    most_deg = std::max(most_deg, shifts_deg.back());
    slowest = std::min(slowest, rate), fastest = std::max(fastest, rate);
    moved += shifts_deg.back() >= 10.0;
    longer += std::remainder(std::atan2(L1[1], L1[0]) - std::atan2(L0[1], L0[0]), 2.0 * std::numbers::pi) > 0.0;
    closer += std::abs(L1[2]) / L1.norm() < std::abs(L0[2]) / L0.norm();
    short_axis += L1.squaredNorm() / twice_energy(end.momentum_body) > body.principal_moments[1];
  }
  std::sort(shifts_deg.begin(), shifts_deg.end());
  std::printf(
      "of %d phases: angular momentum moves by 10 deg or more in %d (median %.1f, most %.1f deg), gains in longitude "
      "in %d, "
      "comes closer to the ecliptic in %d; effective spin rate times %.2f to %.2f; short-axis mode kept in %d\n",
      count, moved, shifts_deg[count / 2], most_deg, longer, closer, slowest, fastest, short_axis);
  EXPECT_GT(moved, 2 * count / 5);
  EXPECT_GT(longer, 4 * count / 5);
  EXPECT_GT(closer, 7 * count / 10);
  EXPECT_LT(slowest, 0.65);
  EXPECT_GT(fastest, 1.5);
  EXPECT_GT(short_axis, 4 * count / 5);
}

/// The radar images of 2008-11-23 (Takahashi et al. 2013) against the state of 1992 carried there. Without torques the
/// axes are 29, 122 and 131 deg off, as in Principia's test; what the torques change is the point, and that the
/// published digits do not fix the attitude sixteen years on.
TEST(Scenes, ToutatisFrom1992To2008) {
  const Scene scene = read_scene(kScenes + "toutatis-1992-2008.toml");
  const FreeBody body = free_body(scene.body, scene.frame);
  const double deg = std::numbers::pi / 180.0;
  const double t = (parse_date("2008-11-23T10:45:00", TimeScale::utc) - scene.body.state->epoch).high;
  ASSERT_LE(t, scene.last_s);
  const auto turn = [](double angle, const Vector3& axis) { return Quaternion(Eigen::AngleAxisd(angle, axis)); };
  const Quaternion seen = turn(86.2 * deg, Vector3::UnitZ()) * turn(85.0 * deg, Vector3::UnitX()) *
                          turn(0.3 * deg, Vector3::UnitZ());  // frame from their axes: intermediate, short, long
  const Matrix3 named_from_principal = scene.body.inertia->named_from_principal;
  const auto axes_off_deg = [&](const State& state) {  // long, intermediate, short
    const Matrix3 frame_from_principal = state.q_inertial_from_body.toRotationMatrix();
    Vector3 off;
    for (int i = 0; i < 3; ++i) {
      const Vector3 a = frame_from_principal.col(i), b = seen * named_from_principal.col(i);
      off[i] = std::atan2(a.cross(b).norm(), a.dot(b)) / deg;
    }
    return off;
  };
  const Vector3 free_off = axes_off_deg(ThetaMotion(body).at(t));
  EXPECT_NEAR(free_off[0], 29.0, 1.0);
  EXPECT_NEAR(free_off[1], 122.0, 1.0);
  EXPECT_NEAR(free_off[2], 131.0, 1.0);

  const TorquedMotion motion(body, scene.torques, {1e-4, 0.0, scene.last_s});
  ASSERT_EQ(motion.outcome(), Outcome::done);
  const State end = motion.at(t);
  const Vector3 torqued_off = axes_off_deg(end);
  const Vector3 L0 = body.q_inertial_from_body * body.momentum_body, L1 = end.q_inertial_from_body * end.momentum_body;
  const double moved_deg = std::atan2(L0.cross(L1).norm(), L0.dot(L1)) / deg;
  const double apart_deg =
      rotation_angle_rad(end.q_inertial_from_body, ThetaMotion(body).at(t).q_inertial_from_body) / deg;
  const double longitude_deg = std::atan2(L1[1], L1[0]) / deg, latitude_deg = std::asin(L1[2] / L1.norm()) / deg;
  // The flyby of 2004: relative change of the momentum, as a rate of the 105 deg/day at which the body turns.
  const double flyby = (parse_date("2004-09-29T13:37:00", TimeScale::utc) - scene.body.state->epoch).high,
               day = 86400.0;
  const double before = motion.at(flyby - 20 * day).momentum_body.norm(),
               after = motion.at(flyby + 20 * day).momentum_body.norm();
  const double changed_deg_day = (after / before - 1.0) * 105.0;
  std::printf(
      "2008: axes off by %.0f, %.0f, %.0f deg without torques, %.0f, %.0f, %.0f with; the two are %.0f deg apart\n"
      "angular momentum moved by %.2f deg, to ecliptic (%.2f, %.2f), grew by %.1e; in the flyby of 2004 by %.3f "
      "deg/day\n",
      free_off[0], free_off[1], free_off[2], torqued_off[0], torqued_off[1], torqued_off[2], apart_deg, moved_deg,
      longitude_deg < 0 ? longitude_deg + 360.0 : longitude_deg, latitude_deg, L1.norm() / L0.norm() - 1.0,
      changed_deg_day);
  EXPECT_NEAR(apart_deg, 17.0, 5.0);
  EXPECT_NEAR(moved_deg, 0.99, 0.1);
  EXPECT_NEAR(changed_deg_day, 0.076, 0.01);  // Busch et al. 2012 (AGU): 0.08 at most
}

}  // namespace
}  // namespace polhode
