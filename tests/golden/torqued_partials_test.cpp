// Scores the partial derivatives under torques against data/truth/torqued/*.partials, which heyoka's variational
// equations in long double gave (tests/bench/heyoka_torqued_partials.py). The error of a row is that of its worst
// column, made free of units, over the larger of 1 and the column's size.

#include "polhode/motion/torqued_partials.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "polhode/motion/partials.hpp"
#include "polhode/read/case_file.hpp"

namespace polhode {
namespace {

double row_error(const PartialsMatrix& answer, const PartialsMatrix& truth, const FreeBody& body) {
  const double unit = body.momentum_body.norm();
  double worst = 0.0;
  for (int k = 0; k < 9; ++k) {
    const double of_column = k < 3 ? 1.0 : k < 6 ? unit : body.principal_moments[k - 6];
    Eigen::Matrix<double, 6, 1> difference = answer.col(k) - truth.col(k), size = truth.col(k);
    for (auto* column : {&difference, &size}) {
      *column *= of_column;
      column->tail<3>() /= unit;
    }
    const double error = difference.norm() / std::max(1.0, size.norm());
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

class TorquedPartialsCorpus : public ::testing::TestWithParam<const char*> {};

TEST_P(TorquedPartialsCorpus, AgreeWithVariationalEquations) {
  const std::string method = GetParam();
  int cases = 0;
  for (const auto& entry : std::filesystem::directory_iterator(POLHODE_DATA_DIR "/truth/torqued")) {
    if (entry.path().extension() != ".partials") continue;
    ++cases;
    const CaseFile wanted = read_case_file(std::filesystem::path(entry.path()).replace_extension(".case"));
    const auto [first, last] = std::minmax_element(wanted.times_s.begin(), wanted.times_s.end());
    const TorquedMotion motion(wanted.body, wanted.torques,
                               {1e-11, std::min(0.0, *first), std::max(0.0, *last), method});
    const TorquedPartials partials(motion, {});
    ASSERT_EQ(partials.columns().size(), 9U);
    std::vector<double> matrices(54 * wanted.times_s.size());
    partials.batch({wanted.times_s}, matrices);
    std::ifstream file(entry.path());
    std::size_t row = 0;
    double worst = 0.0;
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with('#')) continue;
      std::istringstream words(line);
      std::string word;
      words >> word;
      ASSERT_EQ(std::strtod(word.c_str(), nullptr), wanted.times_s[row]) << entry.path();
      PartialsMatrix truth;
      for (double& x : truth.reshaped<Eigen::RowMajor>()) words >> x;
      ASSERT_TRUE(words) << entry.path();
      const PartialsMatrix answer = Eigen::Map<const PartialsMatrix>(&matrices[54 * row]);
      EXPECT_EQ(PartialsMatrix(partials.at(wanted.times_s[row])), answer) << entry.path();
      worst = std::max(worst, row_error(answer, truth, wanted.body));
      ++row;
    }
    EXPECT_EQ(row, wanted.times_s.size());
    std::printf("%s by %s: %.1e\n", entry.path().stem().c_str(), method.c_str(), worst);
    EXPECT_LE(worst, method == "series" ? 1e-8 : 5e-6) << entry.path();
  }
  EXPECT_GE(cases, 4);
}

INSTANTIATE_TEST_SUITE_P(Methods, TorquedPartialsCorpus, ::testing::Values("series", "dormand-prince"));

/// By parameters of the torques, and about axes that are not the principal ones: differences of motions.
TEST(TorquedPartials, AreDifferencesOfMotions) {
  KeplerElements orbit;
  orbit.mu_m3_s2 = 3.986e14, orbit.periapsis_m = 7.2e6, orbit.eccentricity = 0.1, orbit.periapsis_time_s = -500.0;
  const Trajectory way(orbit);
  Matrix3 tensor;
  tensor << 2e5, 1e4, 0.0, 1e4, 3e5, 2e4, 0.0, 2e4, 1e5;
  FreeBody body{Vector3(3.0e3, 5.0e3, 6.0e3), Quaternion(0.5, -0.3, 0.7, 0.2), Vector3(20.0, 60.0, -40.0)};
  body.named_from_principal = Quaternion(0.9, 0.1, -0.3, 0.2).normalized().toRotationMatrix();
  const std::vector<Torque> sets[] = {
      {GravityGradient(orbit.mu_m3_s2, way), EddyCurrents{tensor, Vector3::UnitZ(), 7.8e15, way},
       LinearDamping(Vector3(0.1, 0.3, 0.2)), ThrusterPulse{200.0, 100.0, Vector3(0.05, -0.02, 0.01)}},
      {GravityGradient(orbit.mu_m3_s2, way), EddyCurrents{tensor, Vector3::UnitZ(), 7.8e15, way},
       InternalDissipation{2e-5}, ConstantTorque{Vector3(1e-3, 2e-3, -1e-3), ConstantTorque::Axes::inertial}},
      {InternalDissipation{2e-5}, ConstantTorque{Vector3(1e-3, 2e-3, -1e-3), ConstantTorque::Axes::inertial}}};
  const double t_s = 1500.0;
  for (const std::vector<Torque>& list : sets) {
    const Torques torques(list);
    for (const char* method : {"series", "dormand-prince"}) {
      const auto motion_of = [&](const FreeBody& one, const Torques& under) {
        return TorquedMotion(one, under, {1e-12, 0.0, t_s, method, 1'000'000'000});
      };
      const TorquedMotion motion = motion_of(body, torques);
      const std::vector<TorqueParameter> parameters = parameters_of(torques);
      const TorquedPartials partials(motion);
      ASSERT_EQ(partials.columns().size(), 9 + parameters.size());
      const TorquedPartials::Matrix matrix = partials.at(t_s);
      const Matrix3& R = body.named_from_principal;
      for (std::size_t c = 6; c < partials.columns().size(); ++c) {
        const double scale = c < 9 ? body.principal_moments[static_cast<Eigen::Index>(c) - 6] : parameters[c - 9].scale;
        const double step = (c < 9 ? 1e-4 : 1e-3) * scale;
        Eigen::Matrix<double, 6, 1> sum = sum.Zero();
        for (const auto& [k, weight] : {std::pair(-2, 1.0), {-1, -8.0}, {1, 8.0}, {2, -1.0}}) {
          FreeBody other = body;
          Torques under = torques;
          if (c < 9) {
            other.principal_moments[static_cast<Eigen::Index>(c) - 6] += k * step;
          } else {
            const double value = parameters[c - 9].value + k * step;
            under = with_parameter(torques, parameters[c - 9], value);
          }
          const State state = motion_of(other, under).at(t_s), own = motion.at(t_s);
          Quaternion turn = own.q_inertial_from_body.conjugate() * state.q_inertial_from_body;
          if (turn.w() < 0.0) turn.coeffs() *= -1.0;
          const double sine = turn.vec().norm();
          const double angle = sine > 0.0 ? 2.0 * std::atan2(sine, turn.w()) / sine : 2.0;
          sum.head<3>() += weight * angle * (R * turn.vec());
          sum.tail<3>() += weight * (R * (state.momentum_body - own.momentum_body));
        }
        const Eigen::Matrix<double, 6, 1> expected = sum / (12.0 * step);
        const Eigen::Matrix<double, 6, 1> column = matrix.col(static_cast<Eigen::Index>(c));
        const double off = (column - expected).head<3>().norm() * scale, size = expected.head<3>().norm() * scale;
        // (mu turns the orbit, too: of that, differences on either side tell less.)
        const bool turns_orbit =
            std::string_view(method) == "dormand-prince" && partials.columns()[c].ends_with("mu_m3_s2");
        const double most = turns_orbit ? 1e-3 : 3e-6;
        EXPECT_LE(off, most * size + 1e-9) << method << ' ' << partials.columns()[c];
        EXPECT_LE((column - expected).tail<3>().norm(), most * expected.tail<3>().norm() + 1e-9 / scale)
            << method << ' ' << partials.columns()[c];
      }
    }
  }
}

}  // namespace
}  // namespace polhode
