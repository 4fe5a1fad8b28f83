// Splitting schemes: their orders, and what their steps keep.
#include "polhode/motion/splitting.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>

#include "polhode/base/error.hpp"
#include "rivals/splitting_schemes.hpp"
#include "unit/satellite_under_gravity.hpp"

namespace polhode {
namespace {

using rivals::splitting_scheme;
using rivals::splitting_schemes;
using test::distance;
using test::gravity;
using test::kEarth;
using test::kRadius_m;
using test::reference;
using test::satellite;

const double kMeanMotion = std::sqrt(kEarth / (kRadius_m * kRadius_m * kRadius_m));

State run(const FreeBody& body, const Torques& torques, std::string_view scheme, double span_s, int steps) {
  SplittingRun r(body, 0.0, torques, splitting_scheme(scheme));
  for (int i = 0; i < steps; ++i) r.step(span_s / steps);
  return r.state();
}

TEST(Splitting, SchemesAreConsistentAndSymmetric) {
  for (const SplittingScheme& scheme : splitting_schemes()) {
    double a = 0.0, b = 0.0;
    for (std::size_t i = 0; i <= scheme.kicks; ++i) a += scheme.drift(i);
    for (std::size_t i = 0; i < scheme.kicks; ++i) {
      b += scheme.kick(i);
      EXPECT_EQ(scheme.kick(i), scheme.kick(scheme.kicks - 1 - i));
    }
    EXPECT_NEAR(a, 1.0, 1e-14) << scheme.name;
    EXPECT_NEAR(b, 1.0, 1e-14) << scheme.name;
  }
  EXPECT_THROW(splitting_scheme("yoshida"), InputError);
}

TEST(Splitting, EverySchemeHasItsOrder) {
  // A torque as large as the inertia forces: the order in h alone. One of 1e-4 of that: the order of its first power.
  // Steps are doubled in number; the order is the steepest fall on the way from 1e-5 (1e-7) down to near rounding.
  struct {
    const char* scheme;
    double order, order_near;
  } const wanted[] = {{"strang", 2, 2},     {"blanes-moan-4", 4, 4}, {"blanes-moan-6", 6, 6}, {"near-8-4", 4, 8},
                      {"near-10-4", 4, 10}, {"near-8-6-4", 4, 8},    {"near-10-6-4", 4, 10}};
  for (const bool near : {false, true}) {
    const FreeBody body = near ? satellite({0.004, 0.002, 0.01}) : satellite({0.001, 0.0005, 0.0012});
    const Torques torques({GravityGradient(near ? kEarth * 1e-4 : kEarth,
                                           KeplerElements{kEarth, kRadius_m, 0.1, 100.0, {1, 0, 0}, {0, 0.6, 0.8}})});
    const double span_s = 3000.0;
    const State truth = reference(body, torques, span_s);
    for (const auto& w : wanted) {
      double order = 0.0;
      double coarse = distance(run(body, torques, w.scheme, span_s, 4), truth);
      for (int steps = 8; steps <= 2048; steps *= 2) {
        const double fine = distance(run(body, torques, w.scheme, span_s, steps), truth);
        if (fine < 2e-13) break;
        if (coarse < (near ? 1e-7 : 1e-5) || steps == 2048) order = std::max(order, std::log2(coarse / fine));
        coarse = fine;
      }
      EXPECT_GT(order, (near ? w.order_near : w.order) - 0.5)
          << w.scheme << (near ? ", small torque" : ", large torque");
      EXPECT_LT(order, 13.0) << w.scheme << ": two steps only by luck so far apart";
    }
  }
}

TEST(Splitting, ForwardAndBackwardIsWhereItBegan) {
  const FreeBody body = satellite();
  const Torques torques = gravity(0.1);
  for (const SplittingScheme& scheme : splitting_schemes()) {
    SplittingRun r(body, 0.0, torques, scheme);
    for (int i = 0; i < 200; ++i) r.step(20.0);
    for (int i = 0; i < 200; ++i) r.step(-20.0);
    EXPECT_LT(distance(r.state(), {body.q_inertial_from_body, body.momentum_body}), 5e-11) << scheme.name;
  }
}

/// Energy in the frame that turns with a circular orbit, divided by that of rotation: conserved exactly by the motion.
double jacobi_integral(const FreeBody& body, const State& s, double t_s) {
  const Vector3 normal(0, 0.6, 0.8);
  const Vector3 r = KeplerOrbit({kEarth, kRadius_m, 0.0, 100.0, {1, 0, 0}, normal}).state(t_s).position_m;
  const Vector3 up = s.q_inertial_from_body.conjugate() * r.normalized();
  const Vector3& m = s.momentum_body;
  const Vector3 L = s.q_inertial_from_body * m;
  const double kinetic = 0.5 * m.dot(m.cwiseQuotient(body.principal_moments));
  return (kinetic - kMeanMotion * L.dot(normal) +
          1.5 * kMeanMotion * kMeanMotion * up.dot(body.principal_moments.cwiseProduct(up))) /
         kinetic;
}

TEST(Splitting, JacobiIntegralStaysBoundedOverAMillionTurns) {
  // Strang's scheme at a step that is far from exact: what must not grow is the error, whatever its size. 1e6 turns of
  // the body, about 15,000 orbits (a tenth of that in debugging builds, for their time); a drift in proportion to time
  // would show from the first tenth to the last.
#ifdef NDEBUG
  const int steps = 3000000;
#else
  const int steps = 300000;
#endif
  const FreeBody body = satellite({0.02, 0.01, 0.07});
  const Torques torques = gravity();
  SplittingRun r(body, 0.0, torques, splitting_scheme("strang"));
  const double start = jacobi_integral(body, r.state(), 0.0), step_s = 30.0;
  double first = 0.0, last = 0.0;
  for (int i = 1; i <= steps; ++i) {
    r.step(step_s);
    const double off = std::abs(jacobi_integral(body, r.state(), r.t_s()) - start);
    if (i <= steps / 10) first = std::max(first, off);
    if (i > steps - steps / 10) last = std::max(last, off);
  }
  const double turns =
      r.t_s() * body.momentum_body.cwiseQuotient(body.principal_moments).norm() / (2.0 * std::numbers::pi);
  std::printf("%.2e turns: Jacobi integral off by %.2e of the energy in the first tenth, %.2e in the last\n", turns,
              first, last);
  EXPECT_LT(last, 1.1 * first);
  EXPECT_LT(last, 0.05);
}

TEST(Splitting, KeepsTheMomentumInSpaceExactlyWithoutTorque) {
  const FreeBody body = satellite();
  const Torques none;
  SplittingRun r(body, 0.0, none, splitting_scheme("strang"));
  const Vector3 L = body.q_inertial_from_body * body.momentum_body;
  for (int i = 0; i < 10000; ++i) r.step(17.0);
  const State s = r.state();
  EXPECT_LT((s.q_inertial_from_body * s.momentum_body - L).norm(), 2e-15 * L.norm());
}

}  // namespace
}  // namespace polhode
