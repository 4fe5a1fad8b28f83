// Clones: the generator against published answers, parts against the whole, distributions against closed form.

#include "polhode/session/sample.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/philox.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/body_file.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

using Words = std::array<std::uint32_t, 4>;

// The known answers of Random123 1.14, tests/kat_vectors, philox4x32 with 10 rounds.
TEST(Philox, GivesThePublishedWords) {
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Philox, NormalQuantilesAreThoseOfTheErrorFunction) {
  for (const double p : {1e-300, 1e-20, 1e-3, 0.02, 0.074, 0.3, 0.5, 0.8, 0.93, 0.999}) {
    const double z = normal_quantile(p);
    EXPECT_NEAR(0.5 * std::erfc(-z / std::numbers::sqrt2) / p, 1.0, 1e-12 * (1.0 + z * z)) << p;
  }
  EXPECT_EQ(normal_quantile(0.5), 0.0);
  EXPECT_EQ(normal_quantile(0.25), -normal_quantile(0.75));
}

/// A symmetric top that spins at 10 deg/s, whose rates are known to 1e-6 of themselves; turned about x.
std::string top(const std::string& uncertainty) {
  return "name = \"top\"\n" + uncertainty +
         "[inertia]\nmoments = [1.0, 1.0, 1.5]\nunit = \"ratios\"\nlong_axis = \"x\"\nintermediate_axis = \"y\"\n"
         "short_axis = \"z\"\n"
         "[state]\nepoch = \"2020-01-01T00:00:00 TDB\"\nframe = \"ICRF\"\n"
         "[state.attitude]\neuler_angles = [0.0, 30.0, 0.0]\nsequence = \"ZXZ\"\nunit = \"deg\"\n"
         "[state.angular_velocity]\ncomponents = [2.0, 0.0, 10.0]\naxes = \"body\"\nunit = \"deg/s\"\n";
}

class SampleOfTop : public testing::Test {
 protected:
  static Sample sample(std::uint64_t count, std::vector<std::string> dates, const std::string& uncertainty) {
    const std::string path = testing::TempDir() + "polhode-sample-top.toml";
    std::FILE* file = std::fopen(path.c_str(), "w");
    const std::string text = top(uncertainty);
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
    Sample out;
    out.moving = free_motion_of(read_body(path), Frame::icrf, method("auto"));
    out.seed = 7;
    out.count = count;
    for (const std::string& date : dates) out.instants.push_back(parse_date(date, TimeScale::tdb));
    out.inputs = text;
    return out;
  }
  static SampleState all(const Sample& sample, unsigned threads = 1) {
    SampleState state = empty_state(sample, {0, sample.count});
    continue_sample(sample, state, threads);
    return state;
  }
};

constexpr const char* kOnePartIn1e6 = "period_uncertainty = 1e-6\n";
const std::vector<std::string> kTwoDates{"2020-01-02T00:00:00", "2020-01-11T00:00:00"};

TEST_F(SampleOfTop, PartsAndThreadsGiveTheSameBits) {
  const Sample what = sample(50'000, kTwoDates, kOnePartIn1e6);
  const std::string whole = all(what).text();
  EXPECT_EQ(all(what, 2).text(), whole);
  EXPECT_EQ(all(what, 3).text(), whole);
  std::vector<SampleState> parts;
  for (const std::uint64_t i : {3, 1, 7, 2, 6, 5, 4}) {
    SampleState part = empty_state(what, part_of_sample(what.count, i, 7));
    continue_sample(what, part, 2);
    parts.push_back(SampleState::of_text(part.text()));
  }
  EXPECT_EQ(joined(parts).text(), whole);
  parts.pop_back();
  EXPECT_THROW(joined(parts), InputError);
}

TEST_F(SampleOfTop, GoesOnWhereItWasStopped) {
  const Sample what = sample(500'000, kTwoDates, kOnePartIn1e6);
  SampleState state = empty_state(what, {0, what.count});
  std::string saved;
  struct Stop {};
  EXPECT_THROW(continue_sample(what, state, 2,
                               [&](const SampleState& now) {
                                 saved = now.text();
                                 if (now.next > 60'000) throw Stop{};
                               }),
               Stop);
  SampleState again = SampleState::of_text(saved);
  ASSERT_GT(again.next, 0U);
  ASSERT_LT(again.next, what.count);
  EXPECT_THROW(joined({again}), InputError);
  continue_sample(what, again, 1);
  EXPECT_EQ(again.text(), all(what).text());
}

/// The rate is 1/(1 + e), e normal with sigma s: the whole motion runs at another pace, so that after the time t the
/// clone is where the body is at t/(1 + e). For a top this is a turn of psi_rate e t about its axis and one of phi_rate
/// e t about the momentum: q = exp(L phi/2) q0 exp(k psi/2), whose mean and quantiles are those of normal angles.
TEST_F(SampleOfTop, AnglesAreThoseOfClosedForm) {
  const Sample what = sample(200'000, kTwoDates, kOnePartIn1e6);
  const SampleState state = all(what, 2);
  const FreeBody body = what.moving.free;
  const double momentum = body.momentum_body.norm(), i1 = body.principal_moments[0], i3 = body.principal_moments[2];
  const double phi_rate = momentum / i1, psi_rate = body.momentum_body[2] * (1.0 / i3 - 1.0 / i1);
  const double cosine = body.momentum_body[2] / momentum;
  for (std::size_t j = 0; j < 2; ++j) {
    const double t = (what.instants[j] - what.moving.body.state->epoch).high;
    // For small angles the vector sum of both turns: its size is |e| t |phi_rate L + psi_rate k|, that of omega.
    const double one_sigma =
        1e-6 * t * std::sqrt(phi_rate * phi_rate + psi_rate * psi_rate + 2.0 * phi_rate * psi_rate * cosine);
    ASSERT_LT(one_sigma, 0.3);
    const ClonesAtTime& clones = state.at[j];
    ASSERT_EQ(clones.count, what.count);
    const double several = 4.0 / std::sqrt(static_cast<double>(what.count));
    EXPECT_NEAR(clones.attitude_angle.quantile(0.682689492137) / one_sigma, 1.0, several + 0.01);
    EXPECT_NEAR(clones.attitude_angle.quantile(0.954499736104) / one_sigma, 2.0, 2.0 * several + 0.02);
    EXPECT_NEAR(clones.attitude_spread_rad() / one_sigma, 1.0, several + 0.01);
    EXPECT_EQ(clones.modes[0], what.count);
    // The momentum keeps its direction, and the rate is normal.
    EXPECT_LT(clones.direction_angle.quantile(1.0), 1e-14);
    EXPECT_NEAR(clones.rate.quantile(0.841344746069), 1e-6, 2e-8);
    EXPECT_NEAR(clones.rate.quantile(0.158655253931), -1e-6, 2e-8);
    EXPECT_NEAR(clones.rate.quantile(0.5), 0.0, 2e-8);
    EXPECT_NEAR(clones.polhode_period.quantile(0.841344746069), 1e-6, 2e-8);
  }
}

/// Against the covariance of the attitude by first order, where that holds.
TEST_F(SampleOfTop, SmallAnglesAreThoseOfTheLinearCovariance) {
  const Sample what = sample(100'000, {"2020-01-02T00:00:00"}, kOnePartIn1e6);
  const SampleState state = all(what, 2);
  const double t = (what.instants[0] - what.moving.body.state->epoch).high;
  const std::vector<double> high{t}, low{0.0};
  double sigma_rad = 0.0, covariance[6] = {};
  covariance_rows(what.moving, 0.0, t).rows(high, low, &sigma_rad, covariance);
  EXPECT_NEAR(state.at[0].attitude_spread_rad() / std::sqrt(covariance[0] + covariance[3] + covariance[5]), 1.0, 0.02);
  EXPECT_NEAR(state.at[0].attitude_angle.quantile(0.682689492137) / sigma_rad, 1.0, 0.03);
}

TEST_F(SampleOfTop, APhaseThatIsNotKnownIsAnywhere) {
  Sample what = sample(100'000, {"2020-01-01T00:00:00"}, "");
  const std::string with_sigma = "euler_angles_sigma = [0.0, 0.0, 1.0]\n";
  std::string text = top("");
  text.insert(text.find("sequence"), with_sigma);
  const std::string path = testing::TempDir() + "polhode-sample-phase.toml";
  std::FILE* file = std::fopen(path.c_str(), "w");
  std::fwrite(text.data(), 1, text.size(), file);
  std::fclose(file);
  what.moving = free_motion_of(read_body(path), Frame::icrf, method("auto"));
  std::string name;
  for (const PublishedNumber& number : what.moving.body.uncertainty->numbers) name = number.name;
  what.uniform = {{name, 360.0}};
  const SampleState state = all(what, 2);
  // Angles about z spread evenly over the turn: from the published one by 0 to pi alike.
  for (const double part : {0.1, 0.5, 0.9}) {
    EXPECT_NEAR(state.at[0].attitude_angle.quantile(part), part * std::numbers::pi, 0.03);
  }
  what.uniform = {{"no such number", 1.0}};
  EXPECT_THROW(all(what), InputError);
}

TEST(SampleStatistics, HistogramsGiveQuantilesOfEitherSign) {
  Histogram histogram;
  for (int i = -1000; i <= 1000; ++i) histogram.add(i / 1000.0);
  for (const double part : {0.05, 0.25, 0.5, 0.75, 0.95}) {
    EXPECT_NEAR(histogram.quantile(part), 2.0 * part - 1.0, 0.01 * std::abs(2.0 * part - 1.0) + 2e-3) << part;
  }
  EXPECT_EQ(histogram.total(), 2001U);
  histogram.add(std::nan(""));
  EXPECT_EQ(histogram.total(), 2001U);
  EXPECT_TRUE(std::isnan(Histogram().quantile(0.5)));
}

TEST(SampleStatistics, SumsDoNotDependOnTheirOrder) {
  ExactSum one, other;
  for (int i = 0; i < 1000; ++i) one.add(std::sin(i));
  for (int i = 999; i >= 0; --i) other.add(std::sin(i));
  EXPECT_EQ(one.text(), other.text());
  EXPECT_EQ(ExactSum::of_text(one.text()).value(), one.value());
  ExactSum negative;
  negative.add(-0.75);
  EXPECT_EQ(ExactSum::of_text(negative.text()).value(), -0.75);
  EXPECT_THROW(ExactSum::of_text("1"), InputError);
}

}  // namespace
}  // namespace polhode
