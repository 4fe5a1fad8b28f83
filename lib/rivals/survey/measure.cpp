#include "rivals/survey/measure.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <exception>
#include <limits>
#include <memory>

#include "rivals/integrated_motion.hpp"

namespace polhode::survey {

using rivals::Quadruple;

Answers answer(const rivals::MeasuredMethod& method, const FreeBody& body, const rivals::StepControl& control,
               std::span<const double> times_s) {
  Answers a;
  a.q = std::vector<double>(4 * times_s.size());
  a.m = std::vector<double>(3 * times_s.size());
  const StateArrays out = StateArrays::of_structures(a.q.data(), a.m.data());
  try {
    const std::unique_ptr<Motion> motion =
        method.make_controlled != nullptr ? method.make_controlled(body, control) : method.make(body);
    if (const auto* integrated = dynamic_cast<const rivals::IntegratedMotion*>(motion.get())) {
      a.evaluations = integrated->integrate({times_s}, out);
    } else {
      motion->batch({times_s}, out);
      a.evaluations = static_cast<std::int64_t>(times_s.size());
    }
  } catch (const std::exception&) {  // a method may refuse a body: that is an outcome to be charted
    a.failed = true;
  }
  return a;
}

Errors errors_of_row(const FreeBody& body, const Answers& answers, std::size_t row,
                     const rivals::ScaledState<Quadruple>& truth) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const double* q = &answers.q[4 * row];
  const double* m = &answers.m[3 * row];
  Errors e;
  Quadruple difference[4] = {truth.q[0], -truth.q[1], -truth.q[2], -truth.q[3]};
  rivals::multiply_quaternion(difference, Quadruple(q[0]), Quadruple(q[1]), Quadruple(q[2]), Quadruple(q[3]));
  const double d[4] = {static_cast<double>(difference[0]), static_cast<double>(difference[1]),
                       static_cast<double>(difference[2]), static_cast<double>(difference[3])};
  e.attitude_rad = 2.0 * std::atan2(std::hypot(d[1], d[2], d[3]), std::abs(d[0]));
  e.orthogonality = std::abs(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) - 1.0);
  const double length = body.momentum_body.stableNorm();
  // In units of |m| and of the moments' largest, whatever the user's are.
  double true_energy = 0.0, energy = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double component = length > 0.0 ? m[k] / length : m[k];
    const double true_component = static_cast<double>(truth.m[k]);
    e.momentum = std::hypot(e.momentum, static_cast<double>(Quadruple(component) - truth.m[k]));
    const double inverse = body.principal_moments[0] / body.principal_moments[k];
    energy += component * component * inverse;
    true_energy += true_component * true_component * inverse;
  }
  e.energy = true_energy > 0.0 ? std::abs(energy - true_energy) / true_energy : 0.0;
  if (!std::isfinite(d[0] + d[1] + d[2] + d[3] + energy)) e = {nan, nan, nan, nan};
  return e;
}

double greatest(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

Errors greatest(const Errors& a, const Errors& b) {
  return {greatest(a.attitude_rad, b.attitude_rad), greatest(a.momentum, b.momentum), greatest(a.energy, b.energy),
          greatest(a.orthogonality, b.orthogonality)};
}

double least_time_ns(const std::function<void()>& run) {
  constexpr int most_runs = 15;
  constexpr double enough_ns = 1e7;
  const auto now_ns = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec);
  };
  double least = std::numeric_limits<double>::infinity(), total = 0.0;
  for (int i = 0; i < most_runs && total < enough_ns; ++i) {
    const double start = now_ns();
    run();
    const double ns = now_ns() - start;
    least = std::min(least, ns);
    total += ns;
  }
  return least;
}

double turn_s(const FreeBody& body) {
  return 2.0 * EIGEN_PI / body.momentum_body.cwiseQuotient(body.principal_moments).stableNorm();
}

}  // namespace polhode::survey
