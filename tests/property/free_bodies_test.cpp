// Many bodies side by side, held to the motions of one.

#include "polhode/motion/free_bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

constexpr double kEps = 0x1p-52;

struct Bodies {
  std::vector<double> moments, q, momentum;

  std::size_t size() const { return moments.size() / 3; }
  BodyArrays arrays(std::size_t begin = 0, std::size_t end = SIZE_MAX) const {
    return BodyArrays::of_structures(&moments[3 * begin], &q[4 * begin], &momentum[3 * begin],
                                     std::min(end, size()) - begin);
  }
  void add(const Vector3& i, const Vector3& m, const Eigen::Vector4d& attitude) {
    moments.insert(moments.end(), i.begin(), i.end());
    momentum.insert(momentum.end(), m.begin(), m.end());
    q.insert(q.end(), attitude.begin(), attitude.end());
  }
};

/// Plates, needles, tops, bodies in any units, and each seventh of a kind that is built alone.
Bodies random_bodies(std::size_t count) {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> normal;
  Bodies bodies;
  for (std::size_t n = 0; n < count; ++n) {
    const double least = std::pow(10.0, -2.0 * uniform(random));
    const double middle = std::max(1.0 - least, least + (1.0 - least) * uniform(random));
    Vector3 i(least, std::clamp(middle, least, 1.0), 1.0);
    if (n % 10 == 3) i[1] = i[0];
    if (n % 10 == 4) i[1] = i[2];
    Vector3 m(normal(random), normal(random), normal(random));
    if (n % 14 == 6) m = Vector3(0.0, 0.0, normal(random));
    if (n % 14 == 13) m = Vector3(1e-9 * normal(random), 1.0, 1e-9 * normal(random));
    const Eigen::Vector4d q(normal(random), normal(random), normal(random), normal(random));
    bodies.add(i * std::exp2(std::floor(40.0 * normal(random))), m * std::exp2(std::floor(40.0 * normal(random))), q);
  }
  return bodies;
}

/// A time after so many radians at the rate of the largest moment.
double after(const FreeBody& body, double angle_rad) {
  return angle_rad * body.principal_moments[2] / body.momentum_body.norm();
}

TEST(FreeBodies, StatesAreThoseOfEachBodyAlone) {
  const Bodies bodies = random_bodies(4000);
  const theta::Target* targets[3];
  const std::size_t count = theta::targets(targets);
  for (std::size_t target = 0; target < count; ++target) {
    const FreeBodies many(bodies.arrays(), {}, *targets[target]);
    EXPECT_EQ(many.short_forms(), 0U);
    EXPECT_GT(many.built_alone(), bodies.size() / 14);
    EXPECT_LT(many.built_alone(), bodies.size() / 4);
    double worst_attitude = 0.0, worst_momentum = 0.0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const FreeBody body = bodies.arrays().at(i);
      const ThetaMotion one(body, ThetaMotion::Span::any, *targets[target]);
      for (const double angle : {0.0, -3.0, 1e3, 1e11}) {
        const double t = after(body, angle);
        const State a = many.at(i, t), b = one.at(t);
        const double attitude = rotation_angle_rad(a.q_inertial_from_body, b.q_inertial_from_body) / kEps;
        const double momentum = (a.momentum_body - b.momentum_body).norm() / body.momentum_body.norm() / kEps;
        ASSERT_LE(attitude, 4.0) << targets[target]->name << " body " << i << " angle " << angle;  // measured 3.0
        ASSERT_LE(momentum, 4.0) << targets[target]->name << " body " << i << " angle " << angle;  // measured 2.9
        ASSERT_GT(a.q_inertial_from_body.dot(b.q_inertial_from_body), 0.0);
        worst_attitude = std::max(worst_attitude, attitude);
        worst_momentum = std::max(worst_momentum, momentum);
      }
    }
    std::printf("%s: attitude %.2f, momentum %.2f eps\n", targets[target]->name, worst_attitude, worst_momentum);
  }
}

TEST(FreeBodies, TheShortFormIsAsFarOffAsItSaysAtMost) {
  const Bodies bodies = random_bodies(4000);
  for (const double longest_rad : {1.0, 1e3, 1e6}) {
    for (std::size_t i = 0; i + 1 < bodies.size(); i += 2) {
      const FreeBody body = bodies.arrays().at(i);
      const BodiesOptions options{after(body, longest_rad), 1e-9, 1};
      const FreeBodies brief(bodies.arrays(i, i + 2), options);
      const State a = brief.at(0, options.longest_s), b = ThetaMotion(body).at(options.longest_s);
      ASSERT_LE(rotation_angle_rad(a.q_inertial_from_body, b.q_inertial_from_body), 1e-9) << i;
    }
  }
  BodiesOptions options{1e-300, 1e-9, 1};
  const FreeBodies brief(bodies.arrays(), options);
  EXPECT_EQ(brief.short_forms() + brief.built_alone(), bodies.size());
  options.tolerance_rad = 4.0 * kEps;  // of which the short form keeps nothing
  EXPECT_EQ(FreeBodies(bodies.arrays(), options).short_forms(), 0U);
}

TEST(FreeBodies, ABodyIsTheSameBitsWhateverItsNeighboursAndThreads) {
  const Bodies bodies = random_bodies(203);
  const std::vector<double> times{0.0, 1.5, -2e9, 1e18};
  for (const double tolerance_rad : {0.0, 1e-9}) {
    const BodiesOptions options{2e9, tolerance_rad, 1};
    BodiesOptions threads = options;
    threads.thread_count = 3;
    const std::size_t rows = bodies.size() * times.size();
    std::vector<double> q(4 * rows), m(3 * rows), q_part(4 * rows), m_part(3 * rows), q_kept(4 * rows),
        m_kept(3 * rows);
    const GridRows grid{4, 1};
    free_body_states(bodies.arrays(), {times}, StateArrays::of_structures(q.data(), m.data()), grid, options);
    for (const std::size_t part : {1U, 5U, 16U}) {
      for (std::size_t begin = 0; begin < bodies.size(); begin += part) {
        free_body_states(bodies.arrays(begin, begin + part), {times},
                         StateArrays::of_structures(&q_part[16 * begin], &m_part[12 * begin]), grid, options);
      }
      EXPECT_EQ(std::memcmp(q.data(), q_part.data(), q.size() * sizeof(double)), 0) << part;
      EXPECT_EQ(std::memcmp(m.data(), m_part.data(), m.size() * sizeof(double)), 0) << part;
    }
    FreeBodies(bodies.arrays(), threads)
        .grid({times}, StateArrays::of_structures(q_kept.data(), m_kept.data()), {1, 203}, 2);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      for (std::size_t j = 0; j < times.size(); ++j) {
        EXPECT_EQ(std::memcmp(&q[4 * (4 * i + j)], &q_kept[4 * (203 * j + i)], 4 * sizeof(double)), 0);
        EXPECT_EQ(std::memcmp(&m[3 * (4 * i + j)], &m_kept[3 * (203 * j + i)], 3 * sizeof(double)), 0);
      }
    }
  }
}

TEST(FreeBodies, ManyTimesOfABodyAreThoseAskedForOneByOne) {
  const Bodies bodies = random_bodies(203);
  std::vector<double> times;
  for (std::size_t j = 0; j < FreeBodies::kManyTimes + 5; ++j)
    times.push_back(1e7 * std::sin(3.0 * static_cast<double>(j)));
  const std::size_t rows = bodies.size() * times.size();
  for (const double tolerance_rad : {0.0, 1e-3}) {
    const FreeBodies many(bodies.arrays(), {1e7, tolerance_rad, 1});
    std::vector<double> q(4 * rows), m(3 * rows), q_across(4 * rows), q_alone(4 * times.size());
    const auto count = static_cast<std::ptrdiff_t>(bodies.size());
    many.grid({times}, StateArrays::of_structures(q.data(), m.data()), {static_cast<std::ptrdiff_t>(times.size()), 1});
    many.grid({times}, StateArrays::of_structures(q_across.data(), nullptr), {1, count}, 2);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      many.batch(i, {times}, StateArrays::of_structures(q_alone.data(), nullptr));
      for (std::size_t j = 0; j < times.size(); ++j) {
        const std::size_t row = i * times.size() + j;
        const State one = many.at(i, times[j]);
        const Eigen::Vector4d off = Eigen::Map<Eigen::Vector4d>(&q[4 * row]) - scalar_first(one.q_inertial_from_body);
        ASSERT_LE(off.norm(), 2.0 * kEps) << i << " at " << times[j];
        ASSERT_LE((Eigen::Map<Vector3>(&m[3 * row]) - one.momentum_body).norm(), 4.0 * kEps * one.momentum_body.norm());
        ASSERT_EQ(std::memcmp(&q[4 * row], &q_alone[4 * j], 4 * sizeof(double)), 0);
        ASSERT_EQ(std::memcmp(&q[4 * row], &q_across[4 * (j * bodies.size() + i)], 4 * sizeof(double)), 0);
      }
    }
  }
}

TEST(FreeBodies, WhatIsRefusedIsNamedByItsNumber) {
  Bodies bodies = random_bodies(30);
  const auto message = [&] {
    try {
      FreeBodies(bodies.arrays(), {});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing was refused");
  };
  EXPECT_EQ(message(), "nothing was refused");
  for (const std::size_t place : {17U, 29U}) {
    const Bodies good = bodies;
    bodies.q[4 * place + 1] = std::nan("");
    EXPECT_NE(message().find("body " + std::to_string(place) + ": the attitude"), std::string::npos) << message();
    bodies = good;
    std::swap(bodies.moments[3 * place], bodies.moments[3 * place + 2]);
    EXPECT_NE(message().find("body " + std::to_string(place) + ": the principal moments"), std::string::npos);
    bodies = good;
    bodies.momentum[3 * place + 2] = std::nan("");
    EXPECT_NE(message().find("body " + std::to_string(place) + ": the angular momentum"), std::string::npos);
    bodies = good;
  }
}

}  // namespace
}  // namespace polhode
