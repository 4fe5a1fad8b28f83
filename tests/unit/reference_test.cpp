// The quadruple-precision reference that measures the rival integrators, against the tabulated truth.
#include "rivals/reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "polhode/read/case_file.hpp"
#include "unit/quadruple_angle.hpp"

namespace polhode::rivals {
namespace {

using test::angle_between;
using test::as_double;

/// 34 decimal digits.
Quadruple parse(const std::string& text) {
  std::size_t i = 0;
  const bool negative = text[i] == '-';
  if (negative) ++i;
  Quadruple value = 0;
  int exponent = 0;
  for (bool fraction = false; i < text.size() && text[i] != 'e'; ++i) {
    if (text[i] == '.') {
      fraction = true;
      continue;
    }
    value = value * Quadruple(10) + Quadruple(text[i] - '0');
    if (fraction) --exponent;
  }
  if (i < text.size()) exponent += std::stoi(text.substr(i + 1));
  Quadruple scale = 1;
  for (int n = std::abs(exponent); n > 0; --n) scale *= Quadruple(10);
  value = exponent < 0 ? value / scale : value * scale;
  return negative ? -value : value;
}

CaseFile case_file(const std::string& name) { return read_case_file(POLHODE_DATA_DIR "/truth/dev/" + name + ".case"); }

QuadrupleReference reference_of(const CaseFile& wanted) {
  const auto [first, last] = std::minmax_element(wanted.times_s.begin(), wanted.times_s.end());
  return QuadrupleReference(in_quadruple(wanted.body), std::min(*first, 0.0), std::max(*last, 0.0));
}

/// Rows of a truth file: q, m, kappa.
struct TruthRow {
  double t;
  Quadruple q[4];
  Quadruple m[3];
  double kappa;
};

std::vector<TruthRow> truth_of(const std::string& name) {
  std::ifstream file(POLHODE_DATA_DIR "/truth/dev/" + name + ".truth");
  std::vector<TruthRow> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    std::string word[9];
    for (std::string& w : word) fields >> w;
    TruthRow row;
    row.t = std::strtod(word[0].c_str(), nullptr);
    for (int i = 0; i < 4; ++i) row.q[i] = parse(word[1 + i]);
    for (int i = 0; i < 3; ++i) row.m[i] = parse(word[5 + i]);
    row.kappa = std::stod(word[8]);
    rows.push_back(row);
  }
  return rows;
}

TEST(QuadrupleReference, AgreesWithTheTabulatedTruthToItsLastDigits) {
  constexpr double units_in_the_last_place = 1e4;
  double worst = 0.0;
  std::string where = "nowhere";
  int rows = 0, undetermined = 0;
  for (const auto& entry : std::filesystem::directory_iterator(POLHODE_DATA_DIR "/truth/dev")) {
    if (entry.path().extension() != ".case") continue;
    const std::string name = entry.path().stem().string();
    const CaseFile wanted = case_file(name);
    const QuadrupleReference reference = reference_of(wanted);
    for (const TruthRow& row : truth_of(name)) {
      if (row.kappa > 1e16) {  // a double of the inputs determines nothing
        ++undetermined;
        continue;
      }
      ++rows;
      const ScaledState<Quadruple> y = reference.at(row.t);
      double error = angle_between(row.q, y.q);
      Quadruple square = 0;
      const Quadruple scale = std::max(1e-300, wanted.body.momentum_body.cwiseAbs().maxCoeff());
      for (const Quadruple& m : row.m) square += (m / scale) * (m / scale);
      const Quadruple momentum = square > Quadruple(0) ? square_root(square) * scale : Quadruple(1);
      for (int i = 0; i < 3; ++i) error = std::max(error, std::abs(as_double(row.m[i] / momentum - y.m[i])));
      const double scaled = error / (quadruple_epsilon * std::max(1.0, row.kappa));
      if (!(scaled <= worst)) {
        worst = scaled;
        where = name + " t " + std::to_string(row.t);
        ASSERT_FALSE(std::isnan(scaled)) << where;
      }
    }
  }
  std::printf("%d rows, %d undetermined, worst %.3g units at %s\n", rows, undetermined, worst, where.c_str());
  EXPECT_GT(rows, 1000);
  EXPECT_LE(worst, units_in_the_last_place) << where;
}

TEST(QuadrupleReference, ConditionNumbersAreThoseOfTheTruth) {
  for (const std::string name : {"sam-01", "lam-02", "nearsep-03", "nearprin2-04", "needle-01", "nearsphere-03"}) {
    const CaseFile wanted = case_file(name);
    const std::vector<double> kappas = condition_numbers(wanted.body, wanted.times_s);
    const std::vector<TruthRow> truth = truth_of(name);
    ASSERT_EQ(kappas.size(), truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (truth[i].kappa > 1e13) continue;  // differences are no longer small
      EXPECT_NEAR(std::log10(kappas[i] / truth[i].kappa), 0.0, 0.2) << name << " row " << i;
    }
  }
}

}  // namespace
}  // namespace polhode::rivals
