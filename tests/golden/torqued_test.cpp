// The corpus of torqued bodies (data/truth/torqued): every row within the tolerance asked for.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "polhode/motion/torqued_motion.hpp"
#include "polhode/read/case_file.hpp"

namespace polhode {
namespace {

struct Truth {
  double t_s, kappa;
  State state;
};

std::vector<Truth> truth(const std::filesystem::path& path) {
  std::vector<Truth> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string time;
    double q[4], m[3], kappa;
    words >> time >> q[0] >> q[1] >> q[2] >> q[3] >> m[0] >> m[1] >> m[2] >> kappa;
    EXPECT_FALSE(words.fail()) << path << ": " << line;
    rows.push_back({std::strtod(time.c_str(), nullptr),
                    kappa,
                    {Quaternion(q[0], q[1], q[2], q[3]).normalized(), Vector3(m[0], m[1], m[2])}});
  }
  return rows;
}

class TorquedCorpus : public ::testing::TestWithParam<double> {};

TEST_P(TorquedCorpus, EveryRowIsWithinTheTolerance) {
  const double tolerance_rad = GetParam();
  int cases = 0;
  std::string worst_row;
  double worst = 0.0;
  for (const auto& entry : std::filesystem::directory_iterator(POLHODE_DATA_DIR "/truth/torqued")) {
    if (entry.path().extension() != ".case") continue;
    ++cases;
    const CaseFile wanted = read_case_file(entry.path());
    const auto [first, last] = std::minmax_element(wanted.times_s.begin(), wanted.times_s.end());
    const TorquedMotion motion(wanted.body, wanted.torques,
                               {tolerance_rad, std::min(0.0, *first), std::max(0.0, *last)});
    EXPECT_EQ(motion.outcome(), Outcome::done) << entry.path();
    const std::vector<Truth> rows = truth(std::filesystem::path(entry.path()).replace_extension(".truth"));
    ASSERT_EQ(rows.size(), wanted.times_s.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const State state = motion.at(wanted.times_s[i]);
      const double allowed_rad = tolerance_rad * std::max(1.0, rows[i].kappa * 1e-6);
      const double error_rad = rotation_angle_rad(state.q_inertial_from_body, rows[i].state.q_inertial_from_body);
      const double error_m =
          (state.momentum_body - rows[i].state.momentum_body).norm() / rows[i].state.momentum_body.norm();
      const double ratio = std::max(error_rad, error_m) / allowed_rad;
      EXPECT_TRUE(ratio <= 1.0) << entry.path() << " t = " << rows[i].t_s << " off by " << error_rad
                                << " rad, momentum " << error_m;
      if (!(ratio <= worst)) worst = ratio, worst_row = entry.path().stem();
    }
  }
  EXPECT_GE(cases, 17);
  std::printf("worst row at %g: %.3g of what is allowed (%s)\n", tolerance_rad, worst, worst_row.c_str());
}

INSTANTIATE_TEST_SUITE_P(Tolerances, TorquedCorpus, ::testing::Values(1e-4, 1e-7, 1e-10));

}  // namespace
}  // namespace polhode
