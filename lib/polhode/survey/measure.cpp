#include "polhode/survey/measure.hpp"

#include <cmath>
#include <exception>
#include <limits>
#include <memory>

#include "polhode/motion/rivals/integrated_motion.hpp"

namespace polhode::survey {

using rivals::Extended;

Answers answer(const Method& method, const FreeBody& body, const StepControl& control,
               std::span<const double> times_s) {
  Answers a;
  a.q.resize(4 * times_s.size());
  a.m.resize(3 * times_s.size());
  const StateArrays out = StateArrays::of_structures(a.q.data(), a.m.data());
  try {
    const std::unique_ptr<FreeMotion> motion =
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
                     const rivals::State<Extended>& truth) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const double* q = &answers.q[4 * row];
  const double* m = &answers.m[3 * row];
  Errors e;
  Extended difference[4] = {truth.q[0], -truth.q[1], -truth.q[2], -truth.q[3]};
  rivals::multiply_quaternion(difference, Extended(q[0]), Extended(q[1]), Extended(q[2]), Extended(q[3]));
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
    e.momentum = std::hypot(e.momentum, static_cast<double>(Extended(component) - truth.m[k]));
    const double inverse = body.principal_moments[0] / body.principal_moments[k];
    energy += component * component * inverse;
    true_energy += true_component * true_component * inverse;
  }
  e.energy = true_energy > 0.0 ? std::abs(energy - true_energy) / true_energy : 0.0;
  if (!std::isfinite(d[0] + d[1] + d[2] + d[3] + energy)) e = {nan, nan, nan, nan};
  return e;
}

Errors greatest(const Errors& a, const Errors& b) {
  const auto widest = [](double x, double y) { return std::isnan(x) || y <= x ? x : y; };
  return {widest(a.attitude_rad, b.attitude_rad), widest(a.momentum, b.momentum), widest(a.energy, b.energy),
          widest(a.orthogonality, b.orthogonality)};
}

double turn_s(const FreeBody& body) {
  return 2.0 * EIGEN_PI / body.momentum_body.cwiseQuotient(body.principal_moments).stableNorm();
}

}  // namespace polhode::survey
