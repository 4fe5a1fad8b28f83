// The charts' measurements, at tiny sizes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "rivals/survey/speed_accuracy.hpp"
#include "rivals/survey/stability.hpp"
#include "rivals/survey/torqued_accuracy.hpp"
#include "rivals/torqued_methods.hpp"

namespace polhode::survey {
namespace {

Subject tumbling_subject() {
  Subject subject;
  subject.name = "tumbling";
  subject.body = {{0.6, 1.0, 1.3}, from_scalar_first({0.5, -0.5, 0.5, 0.5}), {0.48, 0.6, 0.64}};
  subject.span_s = 10.0 * turn_s(subject.body);
  return subject;
}

TEST(SpeedAccuracy, EveryMethodIsThereAndTheExactOnesAreExact) {
  const std::vector<SpeedAccuracyRow> rows = speed_accuracy(tumbling_subject(), 20, 2e4);
  std::map<std::string_view, double> best;
  for (const SpeedAccuracyRow& row : rows) {
    ASSERT_TRUE(std::isfinite(row.errors.attitude_rad)) << row.method;
    EXPECT_GT(row.ns_per_instant, 0.0);
    EXPECT_GE(row.evaluations_per_instant, 1.0);
    const auto [known, fresh] = best.try_emplace(row.method, row.errors.attitude_rad);
    if (!fresh) known->second = std::min(known->second, row.errors.attitude_rad);
  }
  for (const rivals::MeasuredMethod& method : rivals::measured_methods())
    EXPECT_EQ(best.count(method.name), 1U) << method.name;
  EXPECT_LT(best.at("theta"), 2e-15);
  for (const std::string_view name : {"dmv-10", "top-rotation-8", "taylor", "fehlberg-78"}) {
    EXPECT_LT(best.at(name), 5e-9) << name;
    EXPECT_GT(best.at(name), best.at("theta")) << name;
  }
  EXPECT_GT(best.at("quaternion-1"), 1e-4);
}

TEST(SpeedAccuracy, OnlyTheTimesChangeFromRunToRun) {
  const std::vector<SpeedAccuracyRow> a = speed_accuracy(tumbling_subject(), 10, 3e3);
  const std::vector<SpeedAccuracyRow> b = speed_accuracy(tumbling_subject(), 10, 3e3);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].errors.attitude_rad, b[i].errors.attitude_rad) << a[i].method;
    EXPECT_EQ(a[i].evaluations_per_instant, b[i].evaluations_per_instant) << a[i].method;
  }
}

TEST(TorquedAccuracy, EveryMethodIsThereAndAccurateAgainstTheReference) {
  TorquedSubject subject;
  subject.name = "satellite";
  const Vector3 moments(17000.0, 124800.0, 129200.0);
  subject.body = {moments, Quaternion(0.3, -0.5, 0.7, 0.2).normalized(),
                  moments.cwiseProduct(Vector3(0.02, 0.01, 0.04))};
  subject.torques =
      Torques({GravityGradient(3.986e14, KeplerElements{3.986e14, 7.146e6, 0.0, 100.0, {1, 0, 0}, {0, 0.6, 0.8}})});
  subject.span_s = 3.0 * turn_s(subject.body);
  const TorquedAccuracy result = torqued_accuracy(subject, 5, 3e3);
  EXPECT_EQ(result.reference.outcome, "done");
  EXPECT_LE(result.reference.error_rad, 1e-14);
  std::map<std::string, double> best;
  for (const TorquedRow& row : result.rows) {
    EXPECT_TRUE(std::isfinite(row.attitude_rad)) << row.method;
    EXPECT_GT(row.time_ns, 0.0);
    EXPECT_GE(row.evaluations, row.kept_evaluations) << row.method;
    EXPECT_GE(row.kept_evaluations, 1.0) << row.method;
    const auto [known, fresh] = best.try_emplace(row.method, row.attitude_rad);
    if (!fresh) known->second = std::min(known->second, row.attitude_rad);
  }
  for (const rivals::TorquedMethod& method : rivals::torqued_methods()) {
    EXPECT_LT(best.at(std::string(method.name)), method.name.ends_with("strang") ? 1e-4 : 1e-5) << method.name;
  }
  EXPECT_LT(best.at("auto"), 1e-11);
  EXPECT_LT(best.at("dormand-prince"), 1e-11);
}

TEST(Stability, ThetaIsBlankOfTroubleAndOthersAreNot) {
  const std::vector<StabilityRow> rows = stability(0.1, 2e4);
  std::set<std::string_view> maps;
  std::map<std::string_view, int> troubled;  // failed, or six digits lost
  double worst = -HUGE_VAL;
  int answered = 0;
  for (const StabilityRow& row : rows) {
    maps.insert(row.map);
    const bool trouble = row.outcome == "failed" || (row.outcome == "answered" && row.digits_lost > 6.0);
    troubled[row.method] += trouble ? 1 : 0;
    if (row.method != "theta") continue;
    EXPECT_TRUE(row.outcome == "answered" || row.outcome == "undetermined") << row.map << ' ' << row.x << ' ' << row.y;
    if (row.outcome != "answered") continue;
    ++answered;
    worst = std::max(worst, row.digits_lost);
    EXPECT_LT(row.digits_lost, 1.0) << row.map << ' ' << row.x << ' ' << row.y << " kappa " << row.kappa;
  }
  std::printf("theta: %d cells, at worst %.2f digits lost\n", answered, worst);
  EXPECT_EQ(maps.size(), stability_maps().size());
  EXPECT_GT(answered, 50);
  EXPECT_EQ(troubled["theta"], 0);
  for (const std::string_view name : {"rk4", "quaternion-1", "three-rotations", "implicit-midpoint"}) {
    EXPECT_GT(troubled[name], 0) << name;
  }
}

}  // namespace
}  // namespace polhode::survey
