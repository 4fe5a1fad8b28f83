#include "polhode/motion/value_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "polhode/base/error.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/motion/values/builder.hpp"

namespace polhode {

ValueMotion::ValueMotion(const FreeBody& body, const Torques& torques, const Options& options)
    : moments_(checked(body).principal_moments) {
  if (!(options.tolerance_rad > 0.0 && std::isfinite(options.tolerance_rad))) {
    throw InputError(fmt::format("the tolerance is {}, a positive angle in radians is wanted", options.tolerance_rad));
  }
  check_span(options.first_s, options.last_s);
  Builder builder(body, torques, options);
  error_rad_ = std::numeric_limits<double>::infinity();
  const double least_share = torques.smooth()      ? 0.0
                             : torques.has_edges() ? values::Tuning::with_edges
                                                   : values::Tuning::with_kinks;
  double sum_rad = values::Tuning::first_run / std::max(1.0, 4.0 * least_share) * options.tolerance_rad;
  Path kept_forward, kept_backward;
  whole_ = builder.run(sum_rad, nullptr, nullptr, kept_forward, kept_backward);
  kept_evaluations_ = builder.evaluations();
  double before_rad = error_rad_, finer = values::Tuning::finer, gain_before = 0.0, rounding_rad = 0.0;
  bool rounding_is_known = false;
  int poor = 0;
  for (int i = 1; whole_ && i < values::Tuning::most_runs; ++i) {
    Path forward, backward;
    const std::size_t before = builder.evaluations();
    whole_ = builder.run(finer * sum_rad, &kept_forward, &kept_backward, forward, backward);
    if (!whole_) break;
    sum_rad *= finer;
    kept_evaluations_ = builder.evaluations() - before;
    kept_forward = std::move(forward), kept_backward = std::move(backward);
    const double difference = builder.difference_rad(), dense_error = builder.dense_error_rad();
    // By how much the finer run is better than the coarser one: by the known power, but by no more than usual unless
    // the runs before have shown it.
    const double expected_gain = std::pow(finer, -values::Tuning::power);
    const bool as_known = before_rad < values::Tuning::most_known_rad && before_rad > 0.5 * gain_before * difference;
    double gain = as_known ? expected_gain : std::min(expected_gain, values::Tuning::usual_gain);
    if (builder.at_rounding()) gain = values::Tuning::gain_at_rounding;
    gain_before = expected_gain;
    const double share = values::Tuning::safety / (gain - 1.0);
    double claim = difference * std::max(share, least_share);
    // Rounding is not made less by finer steps. Where it may matter, the same steps are done once more from a start
    // aside.
    claim += values::Tuning::rounding_of_rate * builder.phase_rad();
    if (i == 1) rounding_rad = std::min(difference / values::Tuning::usual_gain, values::Tuning::most_rounding_rad);
    const bool matters = rounding_rad > 0.1 * options.tolerance_rad;
    if (!rounding_is_known && matters && (i > 1 || options.tolerance_rad < values::Tuning::rounding_matters_rad)) {
      whole_ = builder.repeat(kept_forward, kept_backward);
      if (!whole_) break;
      rounding_rad = values::Tuning::safety * builder.difference_rad();
      rounding_is_known = true;
    }
    if (rounding_is_known) claim += rounding_rad;
    claim += 2.0 * dense_error;
    error_rad_ = difference < values::Tuning::comparable_rad ? claim : std::max(claim, difference);
    if (difference < values::Tuning::comparable_rad && error_rad_ <= options.tolerance_rad) break;
    poor += difference < 0.1 && !(difference < 0.5 * before_rad);
    if (poor >= 2) break;
    before_rad = difference;
    // The difference was that of the coarser run: the finer one is better already.
    const double expected = least_share > 0.0 && difference < values::Tuning::most_known_rad ? difference : claim;
    finer = std::clamp(std::pow(values::Tuning::aim * options.tolerance_rad / expected, 1.0 / values::Tuning::power),
                       1e-3, 0.25);
  }
  evaluations_ = builder.evaluations();
  first_s_ = kept_backward.back().nodes.back().t_s;
  last_s_ = kept_forward.back().nodes.back().t_s;
  for (const Path* path : {&kept_forward, &kept_backward}) {
    for (const Leg& leg : *path) steps_ += leg.nodes.size() - 1;
  }
  forward_ = std::make_shared<const Path>(std::move(kept_forward));
  backward_ = std::make_shared<const Path>(std::move(kept_backward));
}

/// One step as polynomials.
class ValueMotion::Step {
 public:
  Step(const Vector3& moments, const Place& place) : place_(place), unit_(values::unit_of(moments)) {
    const Node& from = place.leg->nodes[place.step];
    values::Unknowns y;
    y << Eigen::Map<const Eigen::Array3d>(from.momentum_inertial) / unit_, 0.0,
        Eigen::Map<const Eigen::Array4d>(from.q);
    from_s_ = from.t_s;
    if (place.leg->nodes.size() > 1) {
      const Rates rates(moments, *place.leg);
      h_ = place.leg->nodes[place.step + 1].t_s - from_s_;
      values::Unknowns k[dormand_prince::kStagesOfAll];
      k[0] = rates(from_s_, y);
      dormand_prince::stages<1, dormand_prince::kStagesOfAll>(rates, from_s_, y, h_, k);
      dense_.emplace(y, h_, k);
    } else {
      dense_.emplace(y);
    }
  }

  const Place& place() const { return place_; }

  State at(double t_high_s, double t_low_s) const {
    const values::Unknowns y = dense_->at(((t_high_s - from_s_) + t_low_s) / h_);
    State state;
    state.q_inertial_from_body = values::attitude(y).normalized();
    state.momentum_body = unit_ * (Rates::rotation(y).transpose() * y.head<3>().matrix());
    if (state.momentum_body.stableNorm() < kLeastMagnitude) state.momentum_body.setZero();
    return state;
  }

 private:
  Place place_;
  double unit_, from_s_ = 0.0, h_ = 1.0;
  std::optional<dormand_prince::Dense> dense_;
};

ValueMotion::Place ValueMotion::place(double t_s, const Place& before) const {
  const double away_s = std::abs(t_s);
  const Path& path = is_forward(t_s) ? *forward_ : *backward_;
  if (before.leg != nullptr && before.leg >= path.data() && before.leg < path.data() + path.size()) {
    const std::vector<Node>& nodes = before.leg->nodes;
    for (std::size_t i = before.step; i + 1 < nodes.size() && i < before.step + 4; ++i) {
      if (std::abs(nodes[i].t_s) <= away_s && away_s < std::abs(nodes[i + 1].t_s)) return {before.leg, i};
    }
  }
  const Leg& leg =
      *std::find_if(path.begin(), path.end() - 1, [&](const Leg& l) { return away_s < std::abs(l.nodes.back().t_s); });
  const auto after = std::upper_bound(leg.nodes.begin(), leg.nodes.end(), away_s,
                                      [](double t, const Node& node) { return t < std::abs(node.t_s); });
  const std::ptrdiff_t last = std::max<std::ptrdiff_t>(std::ssize(leg.nodes) - 2, 0);
  return {&leg, static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - leg.nodes.begin() - 1, 0, last))};
}

State ValueMotion::at(double t_high_s, double t_low_s) const {
  if (std::isnan(t_high_s + t_low_s)) return nan_state();
  return Step(moments_, place(t_high_s, {})).at(t_high_s, t_low_s);
}

void ValueMotion::batch(const TimeArrays& times, const StateArrays& out) const {
  check_lengths(times);
  std::optional<Step> step;
  for (std::size_t i = 0; i < times.high.size(); ++i) {
    const double t_high_s = times.high[i], t_low_s = times.low.empty() ? 0.0 : times.low[i];
    if (std::isnan(t_high_s + t_low_s)) {
      out.put(i, nan_state());
      continue;
    }
    const Place here = place(t_high_s, step ? step->place() : Place{});
    if (!step || !(step->place() == here)) step.emplace(moments_, here);
    out.put(i, step->at(t_high_s, t_low_s));
  }
}

}  // namespace polhode
