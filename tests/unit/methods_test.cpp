#include "polhode/motion/methods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/conditioning.hpp"

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

TEST(Methods, PromiseOnlyWhatTheyKnow) {
  const auto promised = [](std::string_view name, double rate_rad_s, double last_s) {
    const FreeBody body{{1.0, 2.0, 2.5}, Quaternion::Identity(), rate_rad_s * Vector3(0.1, 0.2, 1.0)};
    const MotionAccount account = free_motion_account(method(name), body, 0.0, last_s);
    EXPECT_EQ(account.method, name);
    EXPECT_FALSE(account.error_meaning.empty());
    return account.max_error_rad;
  };
  for (const Method& m : methods()) {
    const auto error_rad = promised(m.name, 1.0, 100.0);
    ASSERT_EQ(error_rad.has_value(), m.exact_everywhere) << m.name;
    if (error_rad) {
      EXPECT_GT(*error_rad, 1e-15);
      EXPECT_LT(*error_rad, 1e-11);
    }
  }
  EXPECT_TRUE(promised("theta", 1.0, 1e10).has_value());
  // A part in 1e12 of the rate is then more than the body's phase; and no arithmetic knows the last.
  for (const double rate_rad_s : {1e4, 1e20, 1e40}) EXPECT_FALSE(promised("theta", rate_rad_s, 1e10).has_value());
}

}  // namespace
}  // namespace polhode
