// Scores the partial derivatives on the reference corpus: data/truth/dev/*.partials, differences of the closed form in
// 150 digits (data/truth/README.md). The error of a row is that of its worst column, made free of units, over the
// larger of 1 and the column's size.

#include "polhode/motion/partials.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "polhode/read/case_file.hpp"

namespace polhode {
namespace {

struct Reference {
  std::string name;
  FreeBody body;
  std::vector<double> times_s;
  std::vector<PartialsMatrix> matrices;
};

std::vector<Reference> references() {
  std::vector<Reference> result;
  for (const auto& entry : std::filesystem::directory_iterator(POLHODE_DATA_DIR "/truth/dev")) {
    if (entry.path().extension() != ".partials") continue;
    Reference r;
    r.name = entry.path().stem();
    r.body = read_case_file(std::filesystem::path(entry.path()).replace_extension(".case")).body;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with('#')) continue;
      std::istringstream words(line);
      std::string word;
      words >> word;
      r.times_s.push_back(std::stod(word));
      PartialsMatrix& matrix = r.matrices.emplace_back();
      for (double& x : matrix.reshaped<Eigen::RowMajor>()) {
        words >> word;
        x = std::strtod(word.c_str(), nullptr);  // some are too small for a double
      }
      if (!words) throw std::runtime_error("bad line in " + entry.path().string());
    }
    result.push_back(std::move(r));
  }
  return result;
}

double row_error(const PartialsMatrix& answer, const PartialsMatrix& truth, const FreeBody& body) {
  const double g = body.momentum_body.stableNorm();
  const double unit = g > 0.0 ? g : body.principal_moments[1];
  double worst = 0.0;
  for (int k = 0; k < 9; ++k) {
    const double of_column = k < 3 ? 1.0 : k < 6 ? unit : body.principal_moments[k - 6];
    Eigen::Matrix<double, 6, 1> difference = answer.col(k) - truth.col(k), size = truth.col(k);
    for (auto* column : {&difference, &size}) {
      *column *= of_column;
      column->tail<3>() /= unit;
    }
    const double error = difference.stableNorm() / std::max(1.0, size.stableNorm());
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

/// Every instruction set, by single calls and by batches on threads: the same bits, within the bounds that the manual
/// states.
TEST(PartialsCorpus, ErrorsAreOfTheLastDigits) {
  const std::vector<Reference> all = references();
  const theta::Target* targets[3];
  const std::size_t count = theta::targets(targets);
  for (std::size_t target = 0; target < count; ++target) {
    std::vector<double> errors;
    std::string worst_row;
    for (const Reference& r : all) {
      const FreePartials partials(r.body, *targets[target]);
      const ThetaMotion motion(r.body, ThetaMotion::Span::any, *targets[target]);
      const std::size_t n = r.times_s.size();
      std::vector<double> q(4 * n), m(3 * n), matrices(54 * n);
      batch_threads(partials, {r.times_s}, StateArrays::of_structures(q.data(), m.data()), matrices, 2);
      for (std::size_t i = 0; i < n; ++i) {
        const StatePartials single = partials.at(r.times_s[i]);
        const PartialsMatrix of_batch = Eigen::Map<const PartialsMatrix>(matrices.data() + 54 * i);
        EXPECT_EQ(single.partials, of_batch) << r.name;
        const State state = motion.at(r.times_s[i]);
        EXPECT_EQ(single.state.q_inertial_from_body.coeffs(), state.q_inertial_from_body.coeffs()) << r.name;
        EXPECT_EQ(single.state.momentum_body, state.momentum_body) << r.name;
        EXPECT_EQ(Vector3(&m[3 * i]), state.momentum_body) << r.name;
        const double error = row_error(of_batch, r.matrices[i], r.body);
        if (errors.empty() || !(error <= *std::max_element(errors.begin(), errors.end()))) {
          worst_row = r.name + " t=" + std::to_string(r.times_s[i]);
        }
        errors.push_back(error);
      }
    }
    ASSERT_EQ(errors.size(), 389U);
    EXPECT_TRUE(std::none_of(errors.begin(), errors.end(), [](double e) { return std::isnan(e); }));
    std::sort(errors.begin(), errors.end());
    std::printf("%-8s median %.1e  99 %% %.1e  worst %.1e  %s\n", targets[target]->name, errors[errors.size() / 2],
                errors[errors.size() * 99 / 100], errors.back(), worst_row.c_str());
    EXPECT_LE(errors[errors.size() / 2], 1e-15) << targets[target]->name;
    EXPECT_LE(errors[errors.size() * 99 / 100], 1e-14) << targets[target]->name;
    EXPECT_LE(errors.back(), 2e-12) << targets[target]->name << ' ' << worst_row;
  }
}

}  // namespace
}  // namespace polhode
