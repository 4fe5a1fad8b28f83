#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer_dense_out.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/dense_output_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <boost/numeric/odeint/util/odeint_error.hpp>
#include <cmath>
#include <functional>
#include <utility>

#include "rivals/fixed_step.hpp"
#include "rivals/general_purpose.hpp"
#include "rivals/right_hand_side.hpp"

namespace polhode::rivals {

namespace odeint = boost::numeric::odeint;

namespace {

using Y = std::array<double, 7>;

template <class RightHandSide>
struct Counted {
  const RightHandSide& f;
  double direction = 1.0;  // -1: of the time that runs backward
  std::int64_t count = 0;
  void operator()(const Y& y, Y& dydt, double t) {
    ++count;
    f(y, dydt, direction * t);
    if (direction < 0.0) {
      for (double& component : dydt) component = -component;
    }
  }
};

using BulirschStoer = odeint::bulirsch_stoer<Y>;

/// Boost leaves the length of the last step unset, and compares with it in the first step. It is
/// private; but an explicit instantiation may name it.
template <double BulirschStoer::*last_step>
struct LastStep {
  friend void clear_last_step(BulirschStoer& stepper) { stepper.*last_step = 0.0; }
};
void clear_last_step(BulirschStoer& stepper);
template struct LastStep<&BulirschStoer::m_dt_last>;

/// A controlled stepper from instant to instant; the last step before an instant is cut to meet it, and the step after
/// it starts from the length that the cut one would have had.
template <class Stepper, class RightHandSide>
std::int64_t run_controlled(Stepper stepper, const RightHandSide& rate, const Problem& problem,
                            std::span<const double> times, ScaledState<double>* out) {
  Counted<RightHandSide> f{rate};
  Y y = pack(problem.start);
  const double direction = times.back() < 0.0 ? -1.0 : 1.0;
  double t = 0.0;
  double next = direction * std::min(problem.step, std::abs(times.back()));
  for (std::size_t i = 0; i < times.size(); ++i) {
    while (direction * (times[i] - t) > 0.0) {
      const double left = times[i] - t;
      const bool cut = std::abs(next) >= std::abs(left);
      double step = cut ? left : next;
      const auto outcome = stepper.try_step(std::ref(f), y, t, step);
      const bool accepted = outcome == odeint::success;
      if (cut && accepted) t = times[i];
      if (!cut || !accepted || std::abs(step) > std::abs(next)) next = step;
      if (!(std::abs(next) > 1e-15 * std::abs(t)) || f.count > problem.max_evaluations) {
        no_answer(out, i, times.size());
        return f.count;
      }
    }
    out[i] = unpack(y);
    if (!is_finite(out[i])) {
      no_answer(out, i, times.size());
      return f.count;
    }
  }
  return f.count;
}

/// A stepper with dense output: its own steps, interpolated at the instants. Backward in a time that runs forward:
/// Boost's Bulirsch-Stoer compares the lengths of negative steps the wrong way round, and never shortens one twice.
template <class Stepper, class RightHandSide>
std::int64_t run_dense(Stepper stepper, const RightHandSide& rate, const Problem& problem,
                       std::span<const double> times, ScaledState<double>* out) {
  const double direction = times.back() < 0.0 ? -1.0 : 1.0;
  Counted<RightHandSide> f{rate, direction};
  stepper.initialize(pack(problem.start), 0.0, problem.step);
  for (std::size_t i = 0; i < times.size(); ++i) {
    try {
      while (direction * times[i] > stepper.current_time()) {
        stepper.do_step(std::ref(f));
        if (!(std::abs(stepper.current_time_step()) > 1e-15 * std::abs(stepper.current_time())) ||
            f.count > problem.max_evaluations) {
          no_answer(out, i, times.size());
          return f.count;
        }
      }
    } catch (const odeint::odeint_error&) {  // no step is short enough
      no_answer(out, i, times.size());
      return f.count;
    }
    Y y = pack(problem.start);
    if (times[i] != 0.0) stepper.calc_state(direction * times[i], y);
    out[i] = unpack(y);
  }
  return f.count;
}

}  // namespace

std::int64_t run_dormand_prince_5(const Problem& problem, std::span<const double> times, ScaledState<double>* out) {
  return with_right_hand_side(problem, [&](const auto& rate) {
    return run_dense(odeint::make_dense_output(problem.tolerance, problem.tolerance, odeint::runge_kutta_dopri5<Y>()),
                     rate, problem, times, out);
  });
}

std::int64_t run_fehlberg_78(const Problem& problem, std::span<const double> times, ScaledState<double>* out) {
  static const odeint::runge_kutta_fehlberg78<Y> blank;  // copied with its buffers: GCC warns where they hold nothing
  return with_right_hand_side(problem, [&](const auto& rate) {
    return run_controlled(odeint::make_controlled(problem.tolerance, problem.tolerance, blank), rate, problem, times,
                          out);
  });
}

std::int64_t run_bulirsch_stoer(const Problem& problem, std::span<const double> times, ScaledState<double>* out) {
  return with_right_hand_side(problem, [&](const auto& rate) {
    // Interpolation costs a sixth more a step, and pays for itself from a few instants on.
    if (times.size() > 1) {
      return run_dense(odeint::bulirsch_stoer_dense_out<Y>(problem.tolerance, problem.tolerance), rate, problem, times,
                       out);
    }
    BulirschStoer stepper(problem.tolerance, problem.tolerance);
    clear_last_step(stepper);
    return run_controlled(std::move(stepper), rate, problem, times, out);
  });
}

}  // namespace polhode::rivals
