#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "rivals/reference.hpp"
#include "rivals/registry.hpp"

namespace polhode::survey {

/// Greatest errors over some instants. NaN where any answer is not finite.
struct Errors {
  double attitude_rad = 0.0;   ///< angle of the rotation between answer and truth
  double momentum = 0.0;       ///< |m - m_true| / |m|
  double energy = 0.0;         ///< relative
  double orthogonality = 0.0;  ///< | |q| - 1 |
};

/// One method's answers at some instants, and what they cost.
struct Answers {
  std::vector<double> q;  ///< scalar first, 4 per instant
  std::vector<double> m;  ///< 3 per instant
  std::int64_t evaluations = 0;
  bool failed = false;  ///< threw
};

/// Builds the motion and asks for all instants in one batch. An exact method counts one evaluation per instant.
Answers answer(const rivals::MeasuredMethod& method, const FreeBody& body, const rivals::StepControl& control,
               std::span<const double> times_s);

/// Errors of row i alone.
Errors errors_of_row(const FreeBody& body, const Answers& answers, std::size_t row,
                     const rivals::ScaledState<rivals::Quadruple>& truth);

/// The greater of both, in each entry; NaN wins.
double greatest(double a, double b);
Errors greatest(const Errors& a, const Errors& b);

/// Processor time of this thread alone (what else the machine does costs it cache, but not its time): the least of
/// several runs; a long one is made once.
double least_time_ns(const std::function<void()>& run);

/// 2 pi / |omega| at t = 0.
double turn_s(const FreeBody& body);

}  // namespace polhode::survey
