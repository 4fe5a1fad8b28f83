// What the theta solution must keep whatever the body: symmetries, composition, continuity through every border of its
// charts, its equations of motion, and agreement between instruction sets, layouts and ways to call it.
#include "polhode/motion/theta.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "polhode/body/inertia.hpp"
#include "polhode/motion/state_rates.hpp"
#include "property/any_bodies.hpp"

namespace polhode {
namespace {

using test::Bodies;
using test::fastest;
using test::kEps;
using test::momentum_error;

double attitude_error(const State& a, const State& b) {
  return rotation_angle_rad(a.q_inertial_from_body, b.q_inertial_from_body);
}
/// Largest error over all cases, NaN kept, with the case that gave it.
class Worst {
 public:
  void add(double error, int which) {
    if (!(error <= worst_) && !std::isnan(worst_)) worst_ = error, which_ = which;
  }
  ~Worst() { EXPECT_LE(worst_, bound_) << "worst case " << which_; }
  explicit Worst(double bound) : bound_(bound) {}
  Worst(const Worst&) = delete;
  Worst& operator=(const Worst&) = delete;

 private:
  double worst_ = 0.0, bound_;
  int which_ = -1;
};

/// What a rounding of the momentum can grow to in time t: the angle turned at the fastest rate this body allows.
double growth(const FreeBody& b, double t) {
  return 1.0 + b.momentum_body.norm() / b.principal_moments[0] * std::abs(t);
}

TEST(ThetaProperty, TheStateAtZeroIsTheGivenOne) {
  Bodies bodies;
  Worst worst(4 * kEps);
  for (int n = 0; n < 20000; ++n) {
    const FreeBody b = bodies.next();
    const State s = ThetaMotion(b).at(0.0);
    worst.add(rotation_angle_rad(s.q_inertial_from_body, b.q_inertial_from_body.normalized()), n);
    worst.add((s.momentum_body - b.momentum_body).norm() / b.momentum_body.norm(), n);
    worst.add(std::abs(s.q_inertial_from_body.norm() - 1.0) * 2, n);
  }
}

TEST(ThetaProperty, SpansCompose) {
  Bodies bodies;
  Worst worst(16 * kEps);
  for (int n = 0; n < 5000; ++n) {
    const FreeBody b = bodies.next();
    const ThetaMotion whole(b);
    const double t1 = bodies.uniform(-2, 2) / fastest(b), t2 = bodies.uniform(-2, 2) / fastest(b);
    const State middle = whole.at(t1);
    const State end = ThetaMotion({b.principal_moments, middle.q_inertial_from_body, middle.momentum_body}).at(t2);
    const double allowed = growth(b, std::abs(t1) + std::abs(t2));
    worst.add(attitude_error(end, whole.at(t1, t2)) / allowed, n);
    worst.add(momentum_error(end, whole.at(t1, t2)) / allowed, n);
  }
}

TEST(ThetaProperty, TimeReverses) {
  Bodies bodies;
  Worst worst(16 * kEps);
  for (int n = 0; n < 5000; ++n) {
    const FreeBody b = bodies.next();
    const double t = bodies.uniform(0, 4) / fastest(b);
    const State there = ThetaMotion(b).at(t);
    const State back = ThetaMotion({b.principal_moments, there.q_inertial_from_body, -there.momentum_body}).at(t);
    const double allowed = growth(b, t);
    worst.add(rotation_angle_rad(back.q_inertial_from_body, b.q_inertial_from_body.normalized()) / allowed, n);
    worst.add((back.momentum_body + b.momentum_body).norm() / b.momentum_body.norm() / allowed, n);
  }
}

TEST(ThetaProperty, UnitsAreFree) {  // powers of two: the same bits
  Bodies bodies;
  for (int n = 0; n < 2000; ++n) {
    const FreeBody b = bodies.next();
    const int inertia_exponent = static_cast<int>(bodies.uniform(-450, 450));
    const int momentum_exponent = static_cast<int>(bodies.uniform(-450, 450));
    const FreeBody scaled{b.principal_moments * std::ldexp(1.0, inertia_exponent), b.q_inertial_from_body,
                          b.momentum_body * std::ldexp(1.0, momentum_exponent)};
    const double t = bodies.uniform(-100, 100) / fastest(b);
    const State one = ThetaMotion(b).at(t);
    const State other = ThetaMotion(scaled).at(std::ldexp(t, inertia_exponent - momentum_exponent));
    ASSERT_EQ(one.q_inertial_from_body.coeffs(), other.q_inertial_from_body.coeffs()) << n;
    ASSERT_EQ(Vector3(one.momentum_body * std::ldexp(1.0, momentum_exponent)), other.momentum_body) << n;
  }
}

TEST(ThetaProperty, AxesMayPointEitherWay) {  // the same body in axes turned by pi about each of them
  Bodies bodies;
  Worst worst(100 * kEps);
  for (int n = 0; n < 3000; ++n) {
    const FreeBody b = bodies.next();
    const double t = bodies.uniform(-5, 5) / fastest(b);
    const State one = ThetaMotion(b).at(t);
    for (int axis = 0; axis < 3; ++axis) {
      Quaternion turn(0, axis == 0, axis == 1, axis == 2);
      const State other =
          ThetaMotion({b.principal_moments, b.q_inertial_from_body * turn.conjugate(), turn * b.momentum_body}).at(t);
      worst.add(rotation_angle_rad(other.q_inertial_from_body * turn, one.q_inertial_from_body), n);
      worst.add((turn.conjugate() * other.momentum_body - one.momentum_body).norm() / one.momentum_body.norm(), n);
    }
  }
}

TEST(ThetaProperty, AxesMayBePermuted) {  // the same body with its axes named in the six orders, through the tensor
  Bodies bodies;
  Worst worst(100 * kEps);
  int compared = 0;
  for (int n = 0; n < 1000; ++n) {
    const FreeBody b = bodies.next();
    const Vector3& i = b.principal_moments;
    if (i[0] + i[1] < i[2]) continue;  // no mass distribution has this tensor
    const double t = bodies.uniform(-5, 5) / fastest(b);
    const State one = ThetaMotion(b).at(t);
    int order[3] = {0, 1, 2};
    do {
      Matrix3 named = Matrix3::Zero();  // v_named = named v_principal
      for (int k = 0; k < 3; ++k) named(order[k], k) = 1.0;
      named.row(0) *= named.determinant();
      const Vector3 moments_named = named.cwiseAbs() * i;
      const Inertia inertia = inertia_from_moments(moments_named, false);
      const Matrix3 turn = inertia.named_from_principal.transpose() * named;  // to the axes found from those of b
      const Quaternion q_turn = Quaternion(turn).normalized();
      const State other =
          ThetaMotion({inertia.principal_moments, b.q_inertial_from_body.normalized() * q_turn.conjugate(),
                       turn * b.momentum_body})
              .at(t);
      worst.add(rotation_angle_rad(other.q_inertial_from_body * q_turn, one.q_inertial_from_body), n);
      worst.add((turn.transpose() * other.momentum_body - one.momentum_body).norm() / one.momentum_body.norm(), n);
      ++compared;
    } while (std::next_permutation(order, order + 3));
  }
  EXPECT_GE(compared, 1000);
}

TEST(ThetaProperty, InertialFrameIsFree) {
  Bodies bodies;
  Worst worst(20 * kEps);
  for (int n = 0; n < 3000; ++n) {
    const FreeBody b = bodies.next();
    const Quaternion turn = Quaternion(bodies.normal(), bodies.normal(), bodies.normal(), bodies.normal()).normalized();
    const double t = bodies.uniform(-1e6, 1e6) / fastest(b);
    const State one = ThetaMotion(b).at(t);
    const State other = ThetaMotion({b.principal_moments, turn * b.q_inertial_from_body, b.momentum_body}).at(t);
    worst.add(rotation_angle_rad(turn * one.q_inertial_from_body, other.q_inertial_from_body), n);
    ASSERT_EQ(one.momentum_body, other.momentum_body) << n;
  }
}

TEST(ThetaProperty, ObeysTheEquationsOfMotion) {  // central differences of order 6
  Bodies bodies;
  Worst worst(3e-11);
  for (int n = 0; n < 3000; ++n) {
    const FreeBody b = bodies.next();
    const ThetaMotion motion(b);
    const double bound = b.momentum_body.norm() / b.principal_moments[0];  // of any rate of this body
    const double t = bodies.uniform(-10, 10) / fastest(b), h = 0.01 / bound;
    Eigen::Vector4d q_rate = Eigen::Vector4d::Zero();
    Vector3 m_rate = Vector3::Zero();
    const double weights[] = {3.0 / 4, -3.0 / 20, 1.0 / 60};
    for (int k = 1; k <= 3; ++k) {
      const State later = motion.at(t, k * h), earlier = motion.at(t, -k * h);
      q_rate +=
          weights[k - 1] * (scalar_first(later.q_inertial_from_body) - scalar_first(earlier.q_inertial_from_body)) / h;
      m_rate += weights[k - 1] * (later.momentum_body - earlier.momentum_body) / h;
    }
    const State s = motion.at(t);
    const StateRates k = state_rates(b.principal_moments, s);
    worst.add((q_rate - k.q_rate_scalar_first_s).norm() / bound, n);
    worst.add((m_rate - s.momentum_body.cross(k.omega_body_rad_s)).norm() / (bound * s.momentum_body.norm()), n);
    const Vector3 torque_free = b.principal_moments.cwiseProduct(k.omega_rate_body_rad_s2);
    worst.add((torque_free - s.momentum_body.cross(k.omega_body_rad_s)).norm() / (bound * s.momentum_body.norm()), n);
  }
}

TEST(ThetaProperty, MomentumOfRotationAboutAnAxisStaysPut) {
  for (const Vector3& moments : {Vector3(1, 2, 2.5), Vector3(1, 1, 1.5), Vector3(1, 2, 2), Vector3(2, 2, 2)}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vector3 m = Vector3::Zero();
      m[axis] = -0.7;
      const ThetaMotion motion({moments, Quaternion(1, 2, 3, 4), m});
      for (double t : {0.0, 1.0, -1e-3, 1e9, -1e17, 1e300}) {
        EXPECT_EQ(motion.at(t).momentum_body, m) << axis << " " << t;
        EXPECT_LE(std::abs(motion.at(t).q_inertial_from_body.norm() - 1), 2 * kEps);
      }
      // by the angle |omega| t about that axis
      Vector3 unit = Vector3::Zero();
      unit[axis] = 1;
      const Quaternion expected =
          Quaternion(1, 2, 3, 4).normalized() * Quaternion(Eigen::AngleAxisd(m[axis] / moments[axis] * 3.0, unit));
      EXPECT_LE(rotation_angle_rad(motion.at(3.0).q_inertial_from_body, expected), 4 * kEps);
    }
  }
  const Vector3 any(0.1, -0.2, 0.3);
  EXPECT_EQ(ThetaMotion({Vector3(3, 3, 3), Quaternion(1, 0, 0, 0), any}).at(1e6).momentum_body, any);
  EXPECT_EQ(ThetaMotion({Vector3(1, 2, 3), Quaternion(1, 0, 0, 0), Vector3::Zero()}).at(1e6).q_inertial_from_body.w(),
            1);
}

/// The two neighbouring values of a parameter between which `side` changes, by bisection.
template <class Make, class Side>
std::pair<double, double> border(double low, double high, const Make& make, const Side& side) {
  const auto at_low = side(ThetaMotion(make(low)));
  EXPECT_NE(at_low, side(ThetaMotion(make(high))));
  for (;;) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) return {low, high};
    (side(ThetaMotion(make(middle))) == at_low ? low : high) = middle;
  }
}

TEST(ThetaProperty, ContinuousThroughTheChangeOfChart) {
  for (double side : {0.3, 3.0}) {  // short-axis and long-axis mode
    const auto make = [side](double closeness) {
      const double separatrix = std::sqrt((2.0 - 1.0) * 2.7 / (1.0 * (2.7 - 2.0)));
      const double m1 = 1.0, m3 = separatrix * (side < 1 ? 1 + closeness : 1 - closeness);
      return FreeBody{Vector3(1, 2, 2.7), Quaternion(1, -2, 0.3, 4), Vector3(m1, 0.4, m3)};
    };
    const auto chart = [](const ThetaMotion& m) { return m.solution().chart; };
    const auto [here, there] = border(1e-6, 0.99, make, chart);
    const ThetaMotion one(make(here)), other(make(there));
    ASSERT_NE(one.solution().chart, other.solution().chart);
    for (double t : {0.0, 0.1, 1.0, -3.0, 17.0, 333.0}) {
      EXPECT_LE(attitude_error(one.at(t), other.at(t)), 16 * kEps * (1 + std::abs(t))) << t;
      EXPECT_LE(momentum_error(one.at(t), other.at(t)), 16 * kEps * (1 + std::abs(t))) << t;
      EXPECT_GT(one.at(t).q_inertial_from_body.coeffs().dot(other.at(t).q_inertial_from_body.coeffs()), 0.0) << t;
    }
  }
}

TEST(ThetaProperty, ContinuousThroughTheSeparatrix) {
  const auto make = [](double m3) {
    return FreeBody{Vector3(1, 2, 2.7), Quaternion(1, -2, 0.3, 4), Vector3(1, 0.4, m3)};
  };
  const auto mode = [](const ThetaMotion& m) { return m.solution().long_axis_mode; };
  const auto [here, there] = border(1.0, 3.0, make, mode);
  const ThetaMotion one(make(here)), other(make(there));
  for (double t : {0.0, 0.1, -1.0, 3.0, -7.0}) {  // the tangent grows like e^t here
    EXPECT_LE(attitude_error(one.at(t), other.at(t)), 16 * kEps * std::exp(std::abs(t))) << t;
    EXPECT_LE(momentum_error(one.at(t), other.at(t)), 16 * kEps * std::exp(std::abs(t))) << t;
  }
}

TEST(ThetaProperty, ContinuousIntoSymmetricTopsAndAxes) {
  for (double tiny : {1e-8, 1e-12, 1e-15}) {
    const Quaternion q(1, -2, 0.3, 4);
    const Vector3 m(1, 0.4, 0.7);
    const auto compare = [&](const FreeBody& a, const FreeBody& b) {
      for (double t : {0.3, -2.0, 9.0}) {
        EXPECT_LE(attitude_error(ThetaMotion(a).at(t), ThetaMotion(b).at(t)), 20 * tiny + 20 * kEps)
            << tiny << " " << t;
        EXPECT_LE(momentum_error(ThetaMotion(a).at(t), ThetaMotion(b).at(t)), 20 * tiny + 20 * kEps)
            << tiny << " " << t;
      }
    };
    compare({Vector3(1, 1, 1.6), q, m}, {Vector3(1, 1 + tiny, 1.6), q, m});
    compare({Vector3(1, 1.6, 1.6), q, m}, {Vector3(1, 1.6 * (1 - tiny), 1.6), q, m});
    compare({Vector3(1.6, 1.6, 1.6), q, m}, {Vector3(1.6 * (1 - tiny), 1.6, 1.6 * (1 + tiny)), q, m});
    compare({Vector3(1, 1.3, 1.6), q, Vector3(0, 0, 1)}, {Vector3(1, 1.3, 1.6), q, Vector3(tiny, tiny, 1)});
    compare({Vector3(1, 1.3, 1.6), q, Vector3(1, 0, 0)}, {Vector3(1, 1.3, 1.6), q, Vector3(1, tiny, tiny)});
    compare({Vector3(1, 1.3, 1.6), q, Vector3(0, 1, 0)}, {Vector3(1, 1.3, 1.6), q, Vector3(tiny, 1, tiny)});
  }
}

/// Equal and nearly equal moments, each component of the momentum down to 1e-300 of the largest, in any unit.
TEST(ThetaProperty, ExtremeBodiesKeepTheirStateAndTheirMotion) {
  Bodies bodies;
  Worst start(6 * kEps), later(40 * kEps);
  for (int n = 0; n < 40000; ++n) {
    const auto tiny = [&](double decades) { return std::pow(10.0, bodies.uniform(-decades, 0)); };
    const double i2 = n % 3 == 0 ? 1 + tiny(16) : bodies.uniform(1, 2);
    const double i3 = n % 5 == 0 ? i2 : n % 3 == 1 ? i2 + tiny(16) : i2 * bodies.uniform(1, 2);
    Vector3 m(bodies.normal(), bodies.normal(), bodies.normal());
    for (int k = 0; k < 3; ++k) {
      if ((n >> k) % 2 == 1) m[k] *= tiny(n % 7 == 0 ? 300 : 30);
    }
    const FreeBody b{Vector3(1, i2, i3) * tiny(140), Quaternion(1, 2, 3, 4), m * tiny(140)};
    if (b.momentum_body.stableNorm() < kLeastMagnitude) continue;
    const ThetaMotion motion(b);
    const State s = motion.at(0.0);
    start.add(rotation_angle_rad(s.q_inertial_from_body, b.q_inertial_from_body.normalized()), n);
    start.add(momentum_error(s.momentum_body, b.momentum_body), n);
    const double t = std::clamp(bodies.uniform(-3, 3) / fastest(b), -1e300, 1e300);
    const State there = motion.at(t);
    const State back = ThetaMotion({b.principal_moments, there.q_inertial_from_body, there.momentum_body}).at(-t);
    later.add(rotation_angle_rad(back.q_inertial_from_body, b.q_inertial_from_body.normalized()), n);
    later.add(momentum_error(back.momentum_body, b.momentum_body), n);
  }
}

TEST(ThetaProperty, ExtremeInputsStayFiniteAndUnit) {
  const double tiny = std::numeric_limits<double>::denorm_min(), huge = 1e300;
  for (const Vector3& m : {Vector3(tiny, 1, tiny), Vector3(tiny, 1, 0), Vector3(1, tiny, tiny), Vector3(tiny, tiny, 1),
                           Vector3(1e-200, 1e100, 1e-200), Vector3(huge, huge, huge), Vector3(tiny, tiny, 1e-300)}) {
    for (const Vector3& i :
         {Vector3(1, 2, 3), Vector3(1, 1, 2), Vector3(1, 2, 2), Vector3(1, 1 + kEps, 1 + 2 * kEps)}) {
      const ThetaMotion motion({i, Quaternion(1, 2, 3, 4), m});
      for (double t : {0.0, 1.0, 1e-30, -1e5, 1e18, -1e40, 1e200}) {
        const State s = motion.at(t);
        if (!std::isfinite(t * m.norm())) continue;
        EXPECT_LE(std::abs(s.q_inertial_from_body.norm() - 1), 2 * kEps) << m.transpose() << "; " << t;
        EXPECT_TRUE(s.momentum_body.allFinite());
      }
    }
  }
}

struct Rows {
  std::vector<double> q, m;
};

/// Beside the middle axis whole periods are taken out of a phase that may be of any size.
TEST(ThetaProperty, SmallestDoublesBesideAnAxisDoNotVanish) {  // they do where they are brought to units of the others
  constexpr double least = std::numeric_limits<double>::denorm_min();
  const Vector3 moments(8, 13, 18);
  for (const int axis : {0, 2}) {  // the middle one is left after some time
    for (const double others : {least, -3.0 * least, 1e-310}) {
      Vector3 m(others, -others, others);
      m[axis] = 9.0;
      const FreeBody body{moments, Quaternion(1.0, 2.0, -3.0, 0.5), m};
      const ThetaMotion motion(body);
      for (const double t : {0.0, 10.0, -1e4}) {
        const Eigen::AngleAxisd turn(9.0 / moments[axis] * t, Vector3::Unit(axis));
        const Quaternion exact = body.q_inertial_from_body.normalized() * Quaternion(turn);
        ASSERT_LE(rotation_angle_rad(motion.at(t).q_inertial_from_body, exact), 1e-11) << axis << " " << others;
        ASSERT_LE((motion.at(t).momentum_body - 9.0 * Vector3::Unit(axis)).norm(), 1e-14) << axis << " " << others;
      }
    }
  }
}

TEST(ThetaProperty, AnyTimeHasAStateOfTheBody) {
  const FreeBody b{{2.28588, 5.27858, 9.97223}, Quaternion(1, 2, 3, 4), {-2.34919e-6, 0.059748, 1.29618e-6}};
  const double energy = b.momentum_body.dot(b.momentum_body.cwiseQuotient(b.principal_moments));
  const theta::Target* targets[3];
  const std::size_t count = theta::targets(targets);
  Bodies bodies;
  for (std::size_t k = 0; k < count; ++k) {
    const ThetaMotion motion(b, ThetaMotion::Span::any, *targets[k]);
    ASSERT_EQ(motion.solution().chart, theta::Chart::hyperbolic);
    Worst unit(2 * kEps), kept(1e-14);
    for (int n = 0; n < 20000; ++n) {
      const double t = std::pow(10.0, bodies.uniform(10, 40)) * (n % 2 == 0 ? 1 : -1);
      const State s = motion.at(t);
      unit.add(std::abs(s.q_inertial_from_body.norm() - 1.0), n);
      kept.add(std::abs(s.momentum_body.norm() / b.momentum_body.norm() - 1.0), n);
      kept.add(std::abs(s.momentum_body.dot(s.momentum_body.cwiseQuotient(b.principal_moments)) / energy - 1.0), n);
    }
  }
}

Rows rows(const theta::Target& target, const theta::Solution& s, const std::vector<double>& t) {
  Rows r{std::vector<double>(4 * t.size()), std::vector<double>(3 * t.size())};
  target.batch(s,
               {t.data(), nullptr, t.size(), {&r.q[0], &r.q[1], &r.q[2], &r.q[3]}, 4, {&r.m[0], &r.m[1], &r.m[2]}, 3});
  return r;
}

TEST(ThetaProperty, TargetsAgree) {
  const theta::Target* targets[3];
  const std::size_t count = theta::targets(targets);
  if (count < 2) GTEST_SKIP() << "one instruction set only";
  Bodies bodies;
  Worst worst(4 * kEps);
  for (int n = 0; n < 2000; ++n) {
    const FreeBody b = bodies.next();
    const theta::Solution s = ThetaMotion(b).solution();
    std::vector<double> t(13);
    for (double& x : t) x = bodies.uniform(-1e6, 1e6) / fastest(b);
    const Rows first = rows(*targets[0], s, t);
    for (std::size_t k = 1; k < count; ++k) {
      const Rows other = rows(*targets[k], s, t);
      for (std::size_t j = 0; j < first.q.size(); ++j) worst.add(std::abs(first.q[j] - other.q[j]), n);
      for (std::size_t j = 0; j < first.m.size(); ++j) {
        worst.add(std::abs(first.m[j] - other.m[j]) / b.momentum_body.norm(), n);
      }
    }
  }
}

TEST(ThetaProperty, BatchIsTheSameInEveryLayoutAndAsSingleCalls) {
  Bodies bodies;
  for (std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{1000}, std::size_t{90001}}) {
    const FreeBody b = bodies.next();
    const ThetaMotion motion(b);
    std::vector<double> t(count), low(count);
    for (std::size_t i = 0; i < count; ++i) {
      t[i] = bodies.uniform(-1e6, 1e6);
      low[i] = t[i] * kEps * bodies.uniform(-0.5, 0.5);
    }
    std::vector<double> q(4 * count), m(3 * count);
    motion.batch({t, low}, StateArrays::of_structures(q.data(), m.data()));

    // a misaligned copy, attitude alone
    std::vector<double> shifted(4 * count + 1);
    motion.batch({t, low}, StateArrays::of_structures(shifted.data() + 1, nullptr));
    EXPECT_TRUE(std::equal(q.begin(), q.end(), shifted.begin() + 1));

    // separate arrays, and rows with room between them
    std::vector<double> separate(7 * count), wide(10 * count, -7.0);
    StateArrays arrays, spread;
    arrays.q_stride = arrays.m_stride = 1;
    spread.q_stride = spread.m_stride = 10;
    for (std::size_t k = 0; k < 7; ++k) {
      (k < 4 ? arrays.q[k] : arrays.m[k - 4]) = separate.data() + k * count;
      (k < 4 ? spread.q[k] : spread.m[k - 4]) = wide.data() + k;
    }
    motion.batch({t, low}, arrays);
    motion.batch({t, low}, spread);
    for (std::size_t i = 0; i < count; ++i) {
      const State s = motion.at(t[i], low[i]);
      const Eigen::Vector4d sq = scalar_first(s.q_inertial_from_body);
      for (std::size_t k = 0; k < 7; ++k) {
        const double expected = k < 4 ? q[4 * i + k] : m[3 * i + k - 4];
        ASSERT_EQ(separate[k * count + i], expected) << i;
        ASSERT_EQ(wide[10 * i + k], expected) << i;
        const auto component = static_cast<Eigen::Index>(k < 4 ? k : k - 4);
        ASSERT_EQ(k < 4 ? sq[component] : s.momentum_body[component], expected) << i;
      }
      ASSERT_EQ(wide[10 * i + 7], -7.0);
    }
  }
}

/// Phases beyond 2^44 quarter turns are reduced in another way, in a batch all lanes together.
TEST(ThetaProperty, TimesOfAllSizesInOneBatchAsInSingleCalls) {
  const theta::Target* targets[3];
  const std::size_t count = theta::targets(targets);
  for (std::size_t k = 0; k < count; ++k) {
    Bodies bodies;
    Worst worst(4 * kEps);
    for (int n = 0; n < 1000; ++n) {
      const FreeBody b = bodies.next();
      if (fastest(b) == 0.0) continue;  // at rest: no time is long
      const ThetaMotion motion(b, ThetaMotion::Span::any, *targets[k]);
      std::vector<double> t(21);
      for (double& x : t) {
        x = std::clamp(bodies.uniform(-1, 1) * std::pow(10.0, bodies.uniform(0, 22)) / fastest(b), -1e300, 1e300);
      }
      const Rows batch = rows(*targets[k], motion.solution(), t);
      for (std::size_t i = 0; i < t.size(); ++i) {
        const State s = motion.at(t[i]);
        worst.add((scalar_first(s.q_inertial_from_body) - Eigen::Map<const Eigen::Vector4d>(&batch.q[4 * i])).norm(),
                  n);
        worst.add(momentum_error(Eigen::Map<const Vector3>(&batch.m[3 * i]), s.momentum_body), n);
      }
    }
  }
}

TEST(ThetaProperty, ShortBuildLosesNothingOverAStep) {
  Bodies bodies;
  Worst worst(60 * kEps);
  for (int n = 0; n < 20000; ++n) {
    const FreeBody b = bodies.next();
    const ThetaMotion exact(b), brief(b, ThetaMotion::Span::step);
    const double t = bodies.uniform(-1, 1) / fastest(b);
    worst.add(attitude_error(brief.at(t), exact.at(t)), n);
    worst.add(momentum_error(brief.at(t), exact.at(t)), n);
  }
}

}  // namespace
}  // namespace polhode
