#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "polhode/base/double_double.hpp"
#include "polhode/motion/values/edge_corrections.hpp"
#include "polhode/motion/values/rates.hpp"

namespace polhode {
namespace values {

/// Found on the torqued bodies of data/truth, on random ones and on boxes in sunlight.
struct Tuning {
  // Runs.
  static constexpr double first_run = 15.0;  // its estimated errors, all added up, in tolerances
  static constexpr double finer = 0.1;       // of the second run
  static constexpr double aim = 0.5;         // of the tolerance, of further ones
  static constexpr int most_runs = 7;
  // What is claimed.
  static constexpr double power = 8.0 / 7.0;  // of the estimated errors, by which the errors of a run fall
  static constexpr double safety = 3.0;       // of what the difference of two runs says by that power
  static constexpr double usual_gain = 14.0;  // of the second run, and of others if nothing says that the power holds
  static constexpr double gain_at_rounding = 2.0;
  static constexpr double with_edges = 1.0, with_kinks = 2.0;  // of the difference, at least
  static constexpr double comparable_rad = 1e-2;               // runs that differ by more say nothing of each other
  static constexpr double most_known_rad = 0.2;                // of differences whose power can be seen
  // Rounding.
  static constexpr double aside = 3e-16;                   // of the start of some runs
  static constexpr double rounding_of_rate = 1e-15;        // of the phase
  static constexpr double rounding_of_estimate = 1.5e-15;  // of an error, in turns
  static constexpr double rounding_matters_rad = 1e-9;     // at tolerances below, it is always measured
  static constexpr double most_rounding_rad = 2e-7;        // of bodies of which anything can be known
  // Steps.
  static constexpr double first_turn_rad = 0.1, longest_turn_rad = 2.5;
  static constexpr double time_scale_share = 0.7;  // of a step in r/v: an encounter is never stepped over
  static constexpr double small_torque = 0.1;      // beside m x omega
  static constexpr double jump_in_steps = 1e-3;    // of the usual one: only a jump makes steps so short
  static constexpr double jump_share = 1e-4;       // of all errors, that one jump may make
  static constexpr std::size_t steps_between_comparisons = 8, most_comparisons = 200;
};

}  // namespace values

/// Makes paths; what they share while they are made.
class ValueMotion::Builder {
  using Unknowns = values::Unknowns;
  using Tuning = values::Tuning;

 public:
  Builder(const FreeBody& body, const Torques& torques, const Options& options)
      : body_(body), options_(options), evaluations_for_tables_(torques.evaluations_for_tables()) {
    // What a smooth torque takes, roughly: whether it pays to make polynomials of trajectories.
    const double steps_per_rad = 0.7 * std::pow(1e-3 / std::min(options.tolerance_rad, 1e-3), 0.125);
    const double rate_rad_s = body.momentum_body.cwiseQuotient(body.principal_moments).norm();
    const double evaluations_per_s = 2.0 * dormand_prince::kStages * rate_rad_s * steps_per_rad;
    for (Path* path : {&forward_, &backward_}) {
      for (TorqueStretch& one : stretches(torques, path == &forward_ ? options.last_s : options.first_s)) {
        Leg leg{std::move(one.torques), {}, {}, {{one.from_s, {}, {}}, {one.to_s, {}, {}}}};
        const double length_s = std::abs(one.to_s - one.from_s);
        const double most = std::min(0.5 * evaluations_per_s * length_s / TrajectoryPieces::kCost, 5e4);
        for (const Trajectory& way : leg.torques.trajectories()) {
          leg.ways.emplace_back(way, std::min(one.from_s, one.to_s), std::max(one.from_s, one.to_s),
                                static_cast<std::size_t>(most));
        }
        leg.kinks_s = leg.torques.times_of_kinks_s(std::min(one.from_s, one.to_s), std::max(one.from_s, one.to_s));
        if (one.to_s < one.from_s) std::reverse(leg.kinks_s.begin(), leg.kinks_s.end());
        path->push_back(std::move(leg));
      }
    }
  }

  /// Runs both ways with steps whose estimated errors add up to `sum_rad`, and compares with the paths of another run,
  /// if there are any. False if the limit of evaluations ended it.
  bool run(double sum_rad, const Path* other_forward, const Path* other_backward, Path& forward, Path& backward) {
    aside_ = other_forward == nullptr ? Tuning::aside : 0.0;
    // Limits of steps, too, get finer: or runs with the same steps would agree, whatever their errors.
    if (other_forward != nullptr) longest_ *= std::pow(sum_rad / sum_rad_, 1.0 / 7.0);
    sum_rad_ = sum_rad;
    steps_ = steps_at_rounding_ = 0;
    phase_rad_ = 0.0;
    difference_rad_ = dense_error_rad_ = 0.0;
    forward = forward_, backward = backward_;
    if (run(forward, other_forward)) return run(backward, other_backward);
    Unknowns start, low;
    begin(start, low);
    backward.resize(1);
    backward.front().nodes.assign(1, node(0.0, start));
    return false;
  }

  /// Does the steps of these paths again, from a start a rounding aside; false as above.
  bool repeat(const Path& forward, const Path& backward) {
    aside_ = Tuning::aside;
    repeats_ = true;
    difference_rad_ = 0.0;
    Path again = forward_;
    bool whole = run(again, &forward);
    again = backward_;
    whole = whole && run(again, &backward);
    repeats_ = false;
    return whole;
  }

  double difference_rad() const { return difference_rad_; }    ///< of the last run and the one it was compared with
  double dense_error_rad() const { return dense_error_rad_; }  ///< of the last run between the ends of steps
  double phase_rad() const { return phase_rad_; }              ///< turned in the last run
  /// Whether rounding kept many steps of the last run from being as fine as they should.
  bool at_rounding() const { return 10 * steps_at_rounding_ > steps_; }
  std::size_t evaluations() const { return evaluations_; }

 private:
  void begin(Unknowns& y, Unknowns& low) const {
    const auto q = body_.q_inertial_from_body.cast<long double>().normalized();
    const long double per_unit = 1.0 / values::unit_of(body_.principal_moments);
    const Vector3Of<long double> m = q * Vector3Of<long double>(body_.momentum_body.cast<long double>() * per_unit);
    Eigen::Array<long double, 8, 1> exact;
    exact << m.array(), 0.0L, q.coeffs().array();
    const long double axes[4] = {1.0L, -1.0L, 0.5L, -0.5L};
    for (int i = 0; i < 4; ++i) exact[4 + i] += aside_ * axes[i];
    exact.head<3>() *= 1.0L + aside_;
    y = exact.cast<double>();
    low = (exact - y.cast<long double>()).cast<double>();
  }

  Node node(double t_s, const Unknowns& y) const {
    const double unit = values::unit_of(body_.principal_moments);
    return {t_s, {unit * y[0], unit * y[1], unit * y[2]}, {y[4], y[5], y[6], y[7]}};
  }

  static bool end_in(Path& path, std::size_t l) {
    path.resize(l + 1);
    return false;
  }

  bool run(Path& path, const Path* other) {
    Unknowns y, low;
    begin(y, low);
    const double end_s = path.back().nodes.back().t_s;
    double wanted_s = std::abs(end_s);
    for (std::size_t l = 0; l < path.size(); ++l) {
      Leg& leg = path[l];
      if (tabulated_) leg.torques = leg.torques.with_tables();
      const double leg_end_s = leg.nodes.back().t_s;
      leg.nodes.assign(1, node(leg.nodes.front().t_s, y));
      const std::vector<Node>* others = other == nullptr ? nullptr : &(*other)[l].nodes;
      if (!run(leg, leg_end_s, end_s, others, y, low, wanted_s)) return end_in(path, l);
    }
    return true;
  }

  /// The nodes of another run that this one meets, one after the other.
  struct Meetings {
    const std::vector<Node>* nodes;
    std::size_t every = 1, next = 0;

    Meetings(const std::vector<Node>* others, bool is_repeated) : nodes(others) {
      if (nodes == nullptr) return;
      const std::size_t steps = nodes->size() - 1;
      if (!is_repeated) {
        every = std::max(std::min(Tuning::steps_between_comparisons, steps / 8), steps / Tuning::most_comparisons);
        every = std::max<std::size_t>(every, 1);
      }
      advance();
    }
    void advance() { next = std::min(next + every, nodes->size() - 1); }
    double next_s(double leg_end_s) const { return nodes == nullptr ? leg_end_s : (*nodes)[next].t_s; }
  };

  bool run(Leg& leg, double leg_end_s, double end_s, const std::vector<Node>* others, Unknowns& y, Unknowns& low,
           double& wanted_s) {
    double t_s = leg.nodes.front().t_s;
    if (t_s == leg_end_s) return true;
    Rates rates(body_.principal_moments, leg);
    Meetings meetings(others, repeats_);
    auto kink_s = leg.kinks_s.begin();
    Unknowns k[dormand_prince::kStagesOfAll];
    Vector3 m = momentum(y);
    if (rates.choose_energy(m)) set_energy(rates, m, y, low);
    k[0] = rates(t_s, y);
    const std::size_t before = evaluations_;
    std::size_t next_check = 3;
    double longest_turn_rad = 0.0, usual_s = 0.0;
    const bool has_edges = leg.torques.has_edges();
    EdgeCorrections corrections;
    bool whole = true;
    while (t_s != leg_end_s) {
      evaluations_ = before + rates.evaluations();
      if (!tabulated_ && static_cast<double>(evaluations_) > evaluations_for_tables_) tabulate(leg);
      if (evaluations_ >= options_.most_evaluations) {
        whole = false;
        break;
      }
      const Vector3& I = rates.moments();
      const double torque = k[0].head<3>().matrix().norm();
      const Vector3 omega = m.cwiseQuotient(I);
      const double rate_rad_s = std::max(omega.norm(), std::sqrt(torque / I[0]));
      const bool has_energy = torque < Tuning::small_torque * m.norm() * omega.norm();

      // Steps end where the other run is met, and at kinks.
      double stop_s = meetings.next_s(leg_end_s);
      while (kink_s != leg.kinks_s.end() && std::abs(*kink_s) <= std::abs(t_s)) ++kink_s;
      if (kink_s != leg.kinks_s.end() && std::abs(*kink_s) < std::abs(stop_s)) stop_s = *kink_s;
      const double remaining_s = std::abs(stop_s - t_s);
      double length_s = std::min(wanted_s, longest_ * Tuning::time_scale_share * rates.time_scale_s());
      if (rate_rad_s > 0.0) {
        const double turn_rad = leg.nodes.size() == 1 ? Tuning::first_turn_rad : longest_ * Tuning::longest_turn_rad;
        length_s = std::min(length_s, turn_rad / rate_rad_s);
      }
      const double free_s = length_s;
      if (length_s > 0.999 * remaining_s) {
        length_s = remaining_s;
      } else if (length_s > 0.5 * remaining_s) {
        length_s = 0.5 * remaining_s;  // no sliver at the end
      }
      if (repeats_) length_s = remaining_s;
      const double to_s = length_s == remaining_s ? stop_s : t_s + std::copysign(length_s, stop_s - t_s);
      const double h = to_s - t_s;
      if (!(std::abs(h) > 4e-16 * std::abs(t_s))) {
        whole = false;
        break;
      }

      dormand_prince::stages<1, dormand_prince::kStages>(rates, t_s, y, h, k);
      // A momentum off by a part d turns the body d omega t away in the time t that is left; but these errors swing
      // rather than add up, and what they come to is measured afterwards: the geometric mean.
      const double growth = std::sqrt(1.0 + rate_rad_s * std::abs(end_s - t_s));
      const double momentum_scale = std::max(m.norm(), I[0] * rate_rad_s);
      const double per_momentum = momentum_scale > 0.0 ? growth / momentum_scale : 0.0;
      Unknowns weights;
      weights << per_momentum, per_momentum, per_momentum, has_energy ? per_momentum * per_momentum / growth : 0.0, 2.0,
          2.0, 2.0, 2.0;
      dormand_prince::Estimates estimates(k);
      Unknowns increment = dormand_prince::increment(h, k);
      if (has_edges) {
        Unknowns end = y + increment;
        find_edges(rates, t_s, y, h, k, end);
        if (corrections.find(places_, h)) {
          increment += corrections.increment;
          estimates.fifth += corrections.fifth, estimates.third += corrections.third;
        }
      }
      const double error = estimates.error(h, weights);
      const double rounding = Tuning::rounding_of_estimate * (rate_rad_s + torque * per_momentum);
      double allowed = std::max(sum_rad_ / std::abs(end_s), rounding) * std::abs(h);
      // At a jump of the torque the error of a step and what is allowed for it shrink alike: it is stepped over.
      if (std::abs(h) < Tuning::jump_in_steps * usual_s) allowed = std::max(allowed, Tuning::jump_share * sum_rad_);
      phase_rad_ += rate_rad_s * std::abs(h);
      steps_at_rounding_ += rounding * std::abs(end_s) > sum_rad_;
      ++steps_;
      const bool good = error <= allowed || repeats_;
      const double factor = !std::isfinite(error) ? 0.1 : 0.9 * std::pow(allowed / std::max(error, 1e-300), 1.0 / 7.0);
      wanted_s = std::abs(h) * std::clamp(factor, 0.1, good ? 4.0 : 0.9);
      if (good && std::abs(h) < free_s) wanted_s = std::max(wanted_s, free_s);
      if (!good) continue;

      usual_s = std::max(std::abs(h), 0.9 * usual_s);
      const Unknowns start = y;
      add(increment, y, low);
      k[dormand_prince::kStages] = rates(to_s, y);
      // Of a longer one of the steps, now and then.
      const double turn_rad = rate_rad_s * std::abs(h);
      longest_turn_rad = std::max(turn_rad, 0.99 * longest_turn_rad);
      if (!repeats_ && leg.nodes.size() >= next_check && turn_rad > 0.9 * longest_turn_rad) {
        check_dense(rates, t_s, start, h, k);
        next_check = leg.nodes.size() + (leg.nodes.size() < 32 ? 8 : 32);
      }
      t_s = to_s;
      k[0] = k[dormand_prince::kStages];
      settle(rates, has_energy, y, low, m);
      leg.nodes.push_back(node(t_s, y));
      if (rates.choose_energy(m)) {
        set_energy(rates, m, y, low);
        k[0] = rates(t_s, y);
      }
      if (others != nullptr && t_s == meetings.next_s(leg_end_s)) {
        const Eigen::Quaterniond there(Eigen::Map<const Eigen::Vector4d>((*others)[meetings.next].q));
        const double angle = rotation_angle_rad(there.normalized(), values::attitude(y).normalized());
        if (!(angle <= difference_rad_)) difference_rad_ = angle;
        meetings.advance();
      }
    }
    evaluations_ = before + rates.evaluations();
    return whole;
  }

  /// From here on the torques are by their tables. These give the same values.
  void tabulate(Leg& leg) {
    tabulated_ = true;
    leg.torques = leg.torques.with_tables();
  }

  /// At five places of a step, whose attitudes between the ends are those of the cubic polynomial by values and rates.
  void find_edges(const Rates& rates, double t_s, const Unknowns& y, double h, const Unknowns* k, const Unknowns& end) {
    rates.streams(t_s, y, places_[0]);
    rates.streams(t_s + h, end, places_[4]);
    const Unknowns end_rate = rates(t_s + h, end);
    for (std::size_t i = 1; i < 4; ++i) {
      const double x = 0.25 * static_cast<double>(i), rest = 1.0 - x;
      const Unknowns between =
          rest * rest * ((1.0 + 2.0 * x) * y + x * h * k[0]) + x * x * ((1.0 + 2.0 * rest) * end - rest * h * end_rate);
      rates.streams(t_s + x * h, between, places_[i]);
    }
  }

  static Vector3 momentum(const Unknowns& y) { return Rates::rotation(y).transpose() * y.head<3>().matrix(); }

  static void add(const Unknowns& increment, Unknowns& y, Unknowns& low) {
    for (int i = 0; i < 8; ++i) {
      const DoubleDouble sum = two_sum(y[i], low[i] + increment[i]);
      y[i] = sum.high, low[i] = sum.low;
    }
  }

  static void set_energy(const Rates& rates, const Vector3& m, Unknowns& y, Unknowns& low) {
    y[3] = rates.energy_weights().dot(m.cwiseAbs2());
    low[3] = 0.0;
  }

  /// Makes q a unit again, and turns the body by the least angle that gives it the energy it should have.
  static void settle(const Rates& rates, bool has_energy, Unknowns& y, Unknowns& low, Vector3& m) {
    Unknowns change = Unknowns::Zero();
    change.tail<4>() = -0.5 * (y.tail<4>().square().sum() - 1.0) * y.tail<4>();
    m = momentum(y);
    if (has_energy) {
      const Vector3 weighed = rates.energy_weights().cwiseProduct(m);
      const Vector3 slope = 2.0 * weighed.cross(m);  // of the energy, by a turn in body axes
      const double slope2 = slope.squaredNorm(), missing = y[3] - weighed.dot(m);
      if (slope2 > 0.0) {
        const Vector3 turn = missing / slope2 * slope;
        if (turn.squaredNorm() < 1e-6) {
          const Vector3 half = 0.5 * turn;
          const double x = y[4], y_ = y[5], z = y[6], w = y[7];
          change[4] += w * half[0] + y_ * half[2] - z * half[1];
          change[5] += w * half[1] + z * half[0] - x * half[2];
          change[6] += w * half[2] + x * half[1] - y_ * half[0];
          change[7] -= x * half[0] + y_ * half[1] + z * half[2];
          m += m.cross(turn);
        }
      }
    }
    add(change, y, low);
  }

  /// The continuous extension beside a shorter step.
  void check_dense(const Rates& rates, double t_s, const Unknowns& y, double h, Unknowns* k) {
    dormand_prince::stages<dormand_prince::kStages + 1, dormand_prince::kStagesOfAll>(rates, t_s, y, h, k);
    constexpr double part = 0.8;  // near which the difference is largest
    const Unknowns dense = dormand_prince::Dense(y, h, k).at(part);
    Unknowns shorter[dormand_prince::kStages];
    shorter[0] = k[0];
    dormand_prince::stages<1, dormand_prince::kStages>(rates, t_s, y, part * h, shorter);
    const Unknowns whole = y + dormand_prince::increment(part * h, shorter);
    const double angle = rotation_angle_rad(values::attitude(dense).normalized(), values::attitude(whole).normalized());
    if (!(angle <= dense_error_rad_)) dense_error_rad_ = angle;
  }

  const FreeBody& body_;
  const Options& options_;
  double sum_rad_ = 0.0, phase_rad_ = 0.0;
  double longest_ = 1.0;  // of the limits of steps
  std::size_t steps_ = 0, steps_at_rounding_ = 0;
  double aside_ = 0.0;
  bool repeats_ = false;
  std::array<EdgeCorrections::Place, 5> places_;
  double evaluations_for_tables_;
  bool tabulated_ = false;
  Path forward_, backward_;  // legs with their two ends as nodes
  double difference_rad_ = 0.0, dense_error_rad_ = 0.0;
  std::size_t evaluations_ = 0;
};

}  // namespace polhode
