#include <algorithm>
#include <cmath>
#include <deque>

#include "polhode/motion/taylor/legs.hpp"

namespace polhode {
namespace {

using Extended = long double;
using taylor::ParameterChange;
using taylor::StateChange;

/// Of the series in time, what a growth of the parameter by one changes; in a leg of these torques.
void set_series_change(const Torque& torque, const TorqueParameter& parameter, const Torques& of_leg, double unit_s,
                       std::deque<Torques>& kept, ParameterChange& change) {
  std::vector<Torque> concerned;
  if (const auto* pull = std::get_if<GravityGradient>(&torque)) {
    change.tide = 1.0 / pull->mu_m3_s2;
    if (const KeplerOrbit* orbit = pull->trajectory.orbit()) {
      // On an orbit of the same shape time goes as the root of mu.
      change.haste = change.own_change = 0.5 / pull->mu_m3_s2;
      change.from = orbit->elements().periapsis_time_s / unit_s;
    }
    for (const Torque& other : of_leg.list()) {
      const auto* mass = std::get_if<GravityGradient>(&other);
      const auto* field = std::get_if<EddyCurrents>(&other);
      const bool is_it = mass != nullptr && mass->trajectory == pull->trajectory;
      if (is_it || (change.haste != 0.0 && field != nullptr && field->trajectory == pull->trajectory)) {
        concerned.push_back(other);
      }
    }
  } else if (const auto* eddy = std::get_if<EddyCurrents>(&torque)) {
    if (!parameter.is("dipole_t_m3") || eddy->dipole_t_m3 == 0.0) return;
    change.field = change.own_change = 1.0 / eddy->dipole_t_m3;
    for (const Torque& other : of_leg.list()) {
      if (std::holds_alternative<EddyCurrents>(other)) concerned.push_back(other);
    }
  } else {
    return;
  }
  change.torques = &kept.emplace_back(std::move(concerned));
}

}  // namespace

class SeriesMotion::SeriesPartials final : public Partials {
 public:
  SeriesPartials(const SeriesMotion& motion, const FreeBody& body, const Torques& torques,
                 std::span<const TorqueParameter> parameters)
      : motion_(motion), columns_(9 + parameters.size()) {
    for (const bool forward : {true, false}) {
      const std::vector<Leg>& legs = forward ? *motion.forward_ : *motion.backward_;
      std::vector<std::vector<ParameterChange>> changes(legs.size(), std::vector<ParameterChange>(columns_ - 6));
      for (std::size_t l = 0; l < legs.size(); ++l) add_moments(legs[l], changes[l]);
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        const TorqueParameter& parameter = parameters[p];
        const double step = 0x1p-20 * parameter.scale, more = parameter.value + step;
        const double less = parameter.value == 0.0 ? 0.0 : parameter.value - step;
        const auto stretches_at = [&](double value) {
          return stretches(with_parameter(torques, parameter, value).in_principal_axes(body.named_from_principal),
                           forward ? motion.last_s() : motion.first_s());
        };
        const std::vector<TorqueStretch> at_more = stretches_at(more), at_less = stretches_at(less);
        for (std::size_t l = 0; l < legs.size(); ++l) {
          const double unit_s = legs[l].equations.unit_s;
          const Vector3Of<Extended> I = motion.moments_.cast<Extended>();
          ParameterChange& change = changes[l][3 + p];
          change.numbers =
              taylor::equations_of(I, at_more[l].torques, unit_s)
                  .change_from(taylor::equations_of(I, at_less[l].torques, unit_s), static_cast<Extended>(more) - less);
          set_series_change(torques.list()[parameter.torque], parameter, *legs[l].torques, unit_s, kept_, change);
        }
      }
      run(body, legs, std::move(changes), forward ? forward_ : backward_);
    }
  }

  void batch(const TimeArrays& times, std::span<double> matrices) const override {
    constexpr std::size_t most_at_once = 64;
    const std::size_t count = times.high.size();
    std::vector<StateChange> now;
    std::vector<double> since;
    for (std::size_t i = 0; i < count;) {
      if (std::isnan(times.high[i])) {
        std::fill_n(&matrices[6 * columns_ * i++], 6 * columns_, std::nan(""));
        continue;
      }
      const Place here = motion_.place(times.high[i]);
      const Leg& leg = *here.leg;
      const taylor::StepStart& start = leg.steps[here.step];
      const double unit_s = leg.equations.unit_s;
      std::size_t end = i;
      since.clear();
      do {
        const double low_s = times.low.empty() ? 0.0 : times.low[end];
        since.push_back((times.high[end] / unit_s - start.t_high) + (low_s / unit_s - start.t_low));
        ++end;
      } while (end < count && end < i + most_at_once && motion_.is_in(here, times.high[end]));
      const bool forward = motion_.is_forward(times.high[i]);
      const std::vector<Leg>& legs = forward ? *motion_.forward_ : *motion_.backward_;
      const Way& way = forward ? forward_ : backward_;
      const std::size_t step = leg.steps_before - legs.front().steps_before + here.step;
      now.resize(columns_ * since.size());
      taylor::best_kernel().vary(leg.equations, start, std::abs(leg.length(here.step)),
                                 way.changes[static_cast<std::size_t>(&leg - legs.data())],
                                 &way.starts[columns_ * step], since, now.data());
      for (std::size_t k = 0; i < end; ++i, ++k) {
        const double low_s = times.low.empty() ? 0.0 : times.low[i];
        put(&now[columns_ * k], motion_.at(times.high[i], low_s).momentum_body, unit_s, &matrices[6 * columns_ * i]);
      }
    }
  }

 private:
  struct Way {
    std::vector<std::vector<ParameterChange>> changes;  // of each leg
    std::vector<StateChange> starts;                    // [step of all legs][column]
  };

  void add_moments(const Leg& leg, std::vector<ParameterChange>& changes) const {
    for (int k = 0; k < 3; ++k) {
      Vector3Of<Extended> more = motion_.moments_.cast<Extended>(), less = more;
      more[k] *= 1 + 0x1p-21L, less[k] *= 1 - 0x1p-21L;
      changes[static_cast<std::size_t>(k)].numbers =
          taylor::equations_of(more, *leg.torques, leg.equations.unit_s)
              .change_from(taylor::equations_of(less, *leg.torques, leg.equations.unit_s), more[k] - less[k]);
    }
  }

  void run(const FreeBody& body, const std::vector<Leg>& legs, std::vector<std::vector<ParameterChange>> changes,
           Way& way) const {
    way.changes = std::move(changes);
    std::vector<StateChange> now(columns_), next(columns_);
    const double unit_s = legs.front().equations.unit_s;
    for (int k = 0; k < 3; ++k) {
      const double I = body.principal_moments[k];
      const auto column = static_cast<std::size_t>(k);
      now[column].turn_rad[k] = 1.0;
      now[3 + column].rate[k] = unit_s / I;
      now[6 + column].rate[k] = -body.momentum_body[k] / I / I * unit_s;
    }
    for (std::size_t l = 0; l < legs.size(); ++l) {
      const Leg& leg = legs[l];
      for (std::size_t step = 0; step < leg.steps.size(); ++step) {
        way.starts.insert(way.starts.end(), now.begin(), now.end());
        const double length = leg.length(step);
        taylor::best_kernel().vary(leg.equations, leg.steps[step], std::abs(length), way.changes[l], now.data(),
                                   {&length, 1}, next.data());
        now.swap(next);
      }
    }
  }

  void put(const StateChange* columns, const Vector3& momentum, double unit_s, double* matrix) const {
    for (std::size_t c = 0; c < columns_; ++c) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        matrix[k * columns_ + c] = columns[c].turn_rad[k];
        matrix[(3 + k) * columns_ + c] = motion_.moments_[axis] * columns[c].rate[k] / unit_s +
                                         (c == 6 + k ? momentum[axis] / motion_.moments_[axis] : 0.0);
      }
    }
  }

  const SeriesMotion& motion_;
  std::size_t columns_;
  std::deque<Torques> kept_;  // that changes point to
  Way forward_, backward_;
};

std::unique_ptr<const PropagatedMotion::Partials> SeriesMotion::partials(
    const FreeBody& body, const Torques& torques_named, std::span<const TorqueParameter> parameters) const {
  return std::make_unique<const SeriesPartials>(*this, body, torques_named, parameters);
}

}  // namespace polhode
