#include "polhode/motion/methods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

const FreeBody kTumbler{{1.0, 1.7, 2.1}, {0.3, -0.2, 0.9, 0.4}, {0.5, -1.1, 0.8}};

TEST(Methods, AreListedOnceAndFoundByName) {
  std::set<std::string_view> names;
  for (const Method& m : methods()) {
    EXPECT_TRUE(names.insert(m.name).second) << m.name;
    EXPECT_EQ(method(m.name).make, m.make);
    EXPECT_NE(m.make, nullptr);
  }
  EXPECT_TRUE(names.contains("legendre"));
  EXPECT_EQ(method("auto").name, methods().front().name);
}

TEST(Methods, UnknownNameIsRefusedWithTheAllowedOnes) {
  try {
    method("runge");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'runge'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("legendre"), std::string::npos) << error.what();
  }
}

TEST(BatchThreads, GivesTheBitsOfBatchForEveryThreadCount) {
  for (const Method& m : methods()) {
    if (m.kind != "exact") continue;
    const auto motion = m.make(kTumbler);
    for (const std::size_t count : {0, 1, 511, 512, 513, 3000}) {
      std::vector<double> high(count), low(count);
      for (std::size_t i = 0; i < count; ++i) {
        high[i] = 0.37 * static_cast<double>(i);
        low[i] = 1e-18 * static_cast<double>(i);
      }
      const TimeArrays times{high, low};
      std::vector<double> q(4 * count), momentum(3 * count);
      motion->batch(times, StateArrays::of_structures(q.data(), momentum.data()));
      for (const unsigned threads : {0U, 1U, 2U, 7U}) {
        std::vector<double> q2(4 * count), momentum2(3 * count), q3(4 * count);
        batch_threads(*motion, times, StateArrays::of_structures(q2.data(), momentum2.data()), threads);
        EXPECT_EQ(q, q2) << m.name << ' ' << count << ' ' << threads;
        EXPECT_EQ(momentum, momentum2) << m.name << ' ' << count << ' ' << threads;
        batch_threads(*motion, times, StateArrays::of_structures(q3.data(), nullptr), threads);
        EXPECT_EQ(q, q3) << m.name << ' ' << count << ' ' << threads;
      }
    }
  }
}

}  // namespace
}  // namespace polhode
