#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "polhode/motion/motion.hpp"
#include "polhode/read/case_file.hpp"

// The reference corpus data/truth: cases, their answers to 34 digits, and the errors of ours against them.

namespace polhode::test {

using Quad = boost::multiprecision::cpp_bin_float_quad;  // 113 bits: errors of 1e-16 keep 17 digits

struct TruthRow {
  double t_s;
  Quad q[4], m[3];
  double kappa;  // response to relative changes of the inputs
};

struct TruthCase {
  std::string name, regime;
  CaseFile question;
  std::vector<TruthRow> rows;
};

/// Errors of one row in units of eps = 2^-52; not finite where the row is not.
struct RowError {
  double attitude_eps;  // rotation angle between answer and truth
  double momentum_eps;  // |m - m_true| / |m_true|, absolute where m_true = 0
  double norm_eps;      // | |q| - 1 |
};

inline RowError row_error(const State& answer, const TruthRow& truth) {
  const Eigen::Vector4d q = scalar_first(answer.q_inertial_from_body);
  const Quad a[4] = {q[0], q[1], q[2], q[3]}, *b = truth.q;
  const Quad w = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const Quad x = -a[0] * b[1] + a[1] * b[0] - a[2] * b[3] + a[3] * b[2];
  const Quad y = -a[0] * b[2] + a[2] * b[0] - a[3] * b[1] + a[1] * b[3];
  const Quad z = -a[0] * b[3] + a[3] * b[0] - a[1] * b[2] + a[2] * b[1];
  const Quad sine = sqrt(x * x + y * y + z * z);
  Quad difference_square = 0, truth_square = 0;
  for (int i = 0; i < 3; ++i) {
    const Quad d = Quad(answer.momentum_body[i]) - truth.m[i];
    difference_square += d * d;
    truth_square += truth.m[i] * truth.m[i];
  }
  const Quad momentum = sqrt(difference_square) / (truth_square > 0 ? Quad(sqrt(truth_square)) : Quad(1));
  const Quad norm = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + a[3] * a[3]) - 1;
  constexpr double kPerEps = 0x1p52;
  return {static_cast<double>(Quad(2 * atan2(sine, Quad(abs(w))))) * kPerEps, static_cast<double>(momentum) * kPerEps,
          static_cast<double>(Quad(abs(norm))) * kPerEps};
}

/// Every case of a folder that has a truth beside it, by name.
inline std::vector<TruthCase> truth_cases(const std::string& folder) {
  std::map<std::string, TruthCase> cases;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".truth") continue;
    TruthCase c;
    c.name = entry.path().stem();
    c.question = read_case_file(std::filesystem::path(entry.path()).replace_extension(".case"));
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with('#')) {
        const std::size_t at = line.find("regime: ");
        if (at != std::string::npos) std::istringstream(line.substr(at + 8)) >> c.regime;
        continue;
      }
      std::istringstream words(line);
      std::string t, kappa, number;
      TruthRow row;
      words >> t;
      row.t_s = std::stod(t);
      for (Quad& x : row.q) words >> number, x = Quad(number);
      for (Quad& x : row.m) words >> number, x = Quad(number);
      words >> kappa;
      row.kappa = std::stod(kappa);
      if (!words) throw std::runtime_error("bad line in " + entry.path().string() + ": " + line);
      c.rows.push_back(row);
    }
    if (c.rows.size() != c.question.times_s.size() || c.regime.empty()) {
      throw std::runtime_error(entry.path().string() + " does not fit its case");
    }
    cases[c.name] = std::move(c);
  }
  std::vector<TruthCase> result;
  for (auto& [name, c] : cases) result.push_back(std::move(c));
  return result;
}

}  // namespace polhode::test
