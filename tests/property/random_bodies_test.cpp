// Random bodies: the theta series against the classical closed form, which shares no formula with it. The number of
// bodies is 20,000, or what POLHODE_RANDOM_BODIES says (a million takes two minutes).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>

#include "polhode/motion/conditioning.hpp"
#include "polhode/motion/legendre.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/motion/theta.hpp"

namespace polhode {
namespace {

TEST(RandomBodies, ThetaAndLegendreAgree) {
  constexpr std::uint64_t seed = 20260718;
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto normal = [&random] { return std::normal_distribution<double>()(random); };
  const char* wanted = std::getenv("POLHODE_RANDOM_BODIES");
  const long count = wanted != nullptr ? std::atol(wanted) : 20000;
  ASSERT_GT(count, 0);

  double worst = 0.0;
  FreeBody worst_body{Vector3::Zero(), Quaternion::Identity(), Vector3::Zero()};
  double worst_t = 0.0;
  for (long n = 0; n < count; ++n) {
    Vector3 i(uniform(0.01, 1), uniform(0.01, 1), 0.0);
    i[2] = std::lerp(std::max(i[0], i[1]), i[0] + i[1], uniform(0, 1));  // a body that can exist
    std::sort(i.data(), i.data() + 3);
    const FreeBody body{i, Quaternion(normal(), normal(), normal(), normal()), Vector3(normal(), normal(), normal())};
    const double turn_s = 2 * i[1] / body.momentum_body.norm();
    const double t = std::pow(10.0, uniform(-3, 9)) * turn_s * (n % 2 == 0 ? 1 : -1);
    const State one = ThetaMotion(body).at(t), other = make_legendre(body)->at(t);
    const double error = std::max(rotation_angle_rad(one.q_inertial_from_body, other.q_inertial_from_body),
                                  (one.momentum_body - other.momentum_body).norm() / body.momentum_body.norm()) /
                         (std::numeric_limits<double>::epsilon() * condition_number(body, t));
    if (!(error <= worst)) worst = error, worst_body = body, worst_t = t;
  }
  std::printf("%ld bodies, seed %llu: worst %.2f eps kappa, I = %a %a %a, m = %a %a %a, t = %a\n", count,
              static_cast<unsigned long long>(seed), worst, worst_body.principal_moments[0],
              worst_body.principal_moments[1], worst_body.principal_moments[2], worst_body.momentum_body[0],
              worst_body.momentum_body[1], worst_body.momentum_body[2], worst_t);
  EXPECT_LE(worst, 16.0);
}

}  // namespace
}  // namespace polhode
