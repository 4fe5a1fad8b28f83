#include "rivals/extrapolated_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "polhode/base/error.hpp"
#include "polhode/body/inertia.hpp"

namespace polhode::rivals {
namespace {

// Bulirsch's numbers of substeps: the weights of the last column add up to 9 in absolute value, those of 2, 4, 6, … to
// 119, and with them the rounding.
constexpr int kSubsteps[] = {2, 4, 6, 8, 12, 16, 24, 32};
constexpr int kColumns = 8;
constexpr int kParts = 96;  // of a step, of which all substeps are multiples
constexpr double kLongestTurn_rad = 6.0;
constexpr double kTimeScaleShare = 0.7;  // of a step in r/v: an encounter is never stepped over
// The estimates are of two orders less than the step, and far too large.
constexpr double kLooser = 1e2, kOverestimate = 1e3;
constexpr double kRounding = 3e-18;  // of a step
constexpr double kGain = 10.0, kGainWithKinks = 0.25;
constexpr double kSafety = 5.0;
constexpr double kComparable_rad = 1e-2;  // runs that differ by more say nothing of each other
constexpr int kMostRuns = 8;

/// To the digits of long double.
double angle_rad(const Eigen::Quaternion<long double>& a, const Eigen::Quaternion<long double>& b) {
  const auto difference = a.conjugate() * b;
  return static_cast<double>(2.0L * std::atan2(difference.vec().norm(), std::abs(difference.w())));
}

}  // namespace

class ExtrapolatedMotion::Method {
 public:
  using Real = long double;
  using Values = Eigen::Matrix<Real, 7, 1>;  // q scalar first, m

  Method(const Vector3& moments, const Torques& torques) : moments_(moments.cast<Real>()), torques_(torques) {}

  /// `error`: of attitude (rad) and momentum (relative) together, from above.
  Place step(Real t_s, const Place& from, Real length_s, double* error) {
    Values start;
    start << from.q_inertial_from_body.w(), from.q_inertial_from_body.vec(), from.momentum_body;
    // Substeps of different length meet: each place is found once.
    std::array<std::optional<Torques::Surroundings<Real>>, kParts + 1> known;
    const auto surroundings = [&](int part) -> const Torques::Surroundings<Real>& {
      std::optional<Torques::Surroundings<Real>>& one = known[static_cast<std::size_t>(part)];
      if (!one) one = torques_.surroundings(t_s + length_s * part / kParts);
      return *one;
    };
    const Values start_rate = rate(surroundings(0), start);

    // Increments are extrapolated, not states: they carry less rounding.
    Values row[kColumns];
    Values previous_best = Values::Zero();
    for (int k = 0; k < kColumns; ++k) {
      const int substeps = kSubsteps[k];
      const Real h = length_s / substeps;
      Values before = Values::Zero(), now = h * start_rate;
      for (int i = 1; i < substeps; ++i) {
        const Values next = before + 2 * h * rate(surroundings(i * (kParts / substeps)), start + now);
        before = now;
        now = next;
      }
      if (k > 0) previous_best = row[k - 1];
      for (int j = 1; j <= k; ++j) {  // Aitken and Neville; row[j - 1] still belongs to the step number before
        const Real ratio = static_cast<Real>(substeps) / kSubsteps[k - j];
        const Values better = now + (now - row[j - 1]) / (ratio * ratio - 1);
        row[j - 1] = now;
        now = better;
      }
      row[k] = now;
    }
    const Values difference = row[kColumns - 1] - previous_best;
    const Values end = start + row[kColumns - 1];
    if (error != nullptr) {
      const Real scale = end.tail<3>().norm() + start.tail<3>().norm(), momentum_error = difference.tail<3>().norm();
      *error = static_cast<double>(2 * difference.head<4>().norm() +
                                   (scale > 0 ? 2 * momentum_error / scale : momentum_error));
    }
    return {Eigen::Quaternion<Real>(end[0], end[1], end[2], end[3]).normalized(), end.tail<3>()};
  }

  std::size_t evaluations() const { return evaluations_; }

 private:
  Values rate(const Torques::Surroundings<Real>& surroundings, const Values& y) {
    ++evaluations_;
    const Eigen::Quaternion<Real> q(y[0], y[1], y[2], y[3]);
    const Vector m = y.tail<3>(), omega = m.cwiseQuotient(moments_);
    // q leaves unit length by rounding and by the error of a substep; the torque must not feel that.
    const TorqueTerms<Real> terms =
        torques_.at(surroundings, Matrix3Of<Real>(q.normalized().toRotationMatrix()), moments_, omega);
    const Vector turning = m.cross(omega), turn = omega + terms.relaxation * turning;
    const Eigen::Quaternion<Real> dq = q * Eigen::Quaternion<Real>(0, turn[0], turn[1], turn[2]);
    Values result;
    result << dq.w() / 2, dq.x() / 2, dq.y() / 2, dq.z() / 2,
        turning + terms.torque(omega) + terms.relaxation * m.cross(turning);
    return result;
  }

  Vector moments_;
  const Torques& torques_;
  std::size_t evaluations_ = 0;
};

ExtrapolatedMotion::Place ExtrapolatedMotion::stepped(const Leg& leg, const Node& from, long double length_s,
                                                      double* error) {
  Method method(moments_, leg.torques);
  const Place to = method.step(from.t_s, from.place, length_s, error);
  evaluations_ += method.evaluations();
  return to;
}

/// False if the limit of evaluations ended it, or steps of no length: the path then ends where it did.
bool ExtrapolatedMotion::choose_steps(Path& path, double local_tolerance_rad) {
  Place place = start_;
  const double end_s = path.back().nodes.back().t_s;
  for (std::size_t l = 0; l < path.size(); ++l) {
    Leg& leg = path[l];
    const double leg_end_s = leg.nodes.back().t_s;
    leg.nodes.assign(1, {leg.nodes[0].t_s, place});
    double wanted_s = std::abs(leg_end_s - leg.nodes[0].t_s);
    while (leg.nodes.back().t_s != leg_end_s) {
      const Node from = leg.nodes.back();
      const double remaining_s = std::abs(leg_end_s - from.t_s);
      const double rate_rad_s = from.place.momentum_body.cast<double>().cwiseQuotient(moments_).norm();
      double length_s = std::min(wanted_s, kTimeScaleShare * leg.torques.time_scale_s(from.t_s));
      if (rate_rad_s > 0.0) length_s = std::min(length_s, kLongestTurn_rad / rate_rad_s);
      if (length_s > 0.999 * remaining_s) {
        length_s = remaining_s;
      } else if (length_s > 0.5 * remaining_s) {
        length_s = 0.5 * remaining_s;  // no sliver at the end
      }
      const double to_s = length_s == remaining_s ? leg_end_s : from.t_s + std::copysign(length_s, leg_end_s);
      length_s = std::abs(to_s - from.t_s);
      if (!(length_s > 4e-16 * std::abs(from.t_s)) || evaluations_ > most_evaluations_) {
        path.erase(path.begin() + static_cast<std::ptrdiff_t>(l) + 1, path.end());
        return false;
      }
      double error = 0.0;
      const Place to = stepped(leg, from, to_s - from.t_s, &error);
      // A momentum off by a part d turns the body d omega t away in the time t that is left; but these errors swing
      // rather than add up: the geometric mean.
      const double weight = std::sqrt(1.0 + rate_rad_s * std::abs(end_s - from.t_s));
      error *= weight / kOverestimate;
      const double allowed =
          std::max(local_tolerance_rad * std::sqrt(length_s / std::abs(end_s)), kRounding / kOverestimate * weight);
      const double turned_rad = length_s * to.momentum_body.cast<double>().cwiseQuotient(moments_).norm();
      const bool good = error <= allowed && turned_rad <= 2.0 * kLongestTurn_rad;
      const double factor =
          !std::isfinite(error) ? 0.1 : 0.85 * std::pow(allowed / std::max(error, 1e-300), 1.0 / 15.0);
      wanted_s = length_s * std::clamp(factor, 0.1, good ? 4.0 : 0.7);
      if (good) leg.nodes.push_back({to_s, to});
    }
    place = leg.nodes.back().place;
  }
  return true;
}

bool ExtrapolatedMotion::halve(const Path& coarse, Path& fine) {
  fine = coarse;
  Place place = start_;
  for (std::size_t l = 0; l < coarse.size(); ++l) {
    const std::vector<Node>& nodes = coarse[l].nodes;
    fine[l].nodes.assign(1, {nodes[0].t_s, place});
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      const double middle_s = 0.5 * (nodes[i - 1].t_s + nodes[i].t_s);
      for (const double to_s : {middle_s, nodes[i].t_s}) {
        const Node from = fine[l].nodes.back();
        fine[l].nodes.push_back({to_s, stepped(fine[l], from, to_s - from.t_s, nullptr)});
      }
      if (evaluations_ > most_evaluations_) return false;
    }
    place = fine[l].nodes.back().place;
  }
  return true;
}

ExtrapolatedMotion::ExtrapolatedMotion(const FreeBody& body, const Torques& torques_named, const Options& options)
    : moments_(checked(body).principal_moments),
      start_{body.q_inertial_from_body.cast<long double>().normalized(), body.momentum_body.cast<long double>()},
      most_evaluations_(options.most_evaluations) {
  check_span(options.first_s, options.last_s);
  const Torques torques = torques_named.in_principal_axes(body.named_from_principal);
  for (Path* path : {&forward_, &backward_}) {
    for (TorqueStretch& one : stretches(torques, path == &forward_ ? options.last_s : options.first_s)) {
      path->push_back({std::move(one.torques), {{one.from_s, start_}, {one.to_s, start_}}});
    }
  }
  const double gain = torques.smooth() ? kGain : kGainWithKinks, safety = torques.smooth() ? kSafety : 1.0;
  error_rad_ = std::numeric_limits<double>::infinity();
  const double local_tolerance_rad = kLooser * options.tolerance_rad;
  whole_ = choose_steps(forward_, local_tolerance_rad) && choose_steps(backward_, local_tolerance_rad);
  double before_rad = error_rad_;
  int poor = 0;  // runs that gained little
  for (int run = 0; whole_ && run < kMostRuns && poor < 2; ++run) {
    Path forward, backward;
    const std::size_t before = evaluations_;
    whole_ = halve(forward_, forward) && halve(backward_, backward);
    if (!whole_) break;
    double difference_rad = 0.0;
    for (const auto& [coarse, fine] : {std::pair{&forward_, &forward}, std::pair{&backward_, &backward}}) {
      for (std::size_t l = 0; l < coarse->size(); ++l) {
        for (std::size_t i = 0; i < (*coarse)[l].nodes.size(); ++i) {
          const double angle = angle_rad((*coarse)[l].nodes[i].place.q_inertial_from_body,
                                         (*fine)[l].nodes[2 * i].place.q_inertial_from_body);
          if (!(angle <= difference_rad)) difference_rad = angle;
        }
      }
    }
    forward_ = std::move(forward), backward_ = std::move(backward);
    kept_evaluations_ = evaluations_ - before;
    error_rad_ = difference_rad / gain;
    if (difference_rad <= std::min(gain * options.tolerance_rad / safety, kComparable_rad)) break;
    poor += difference_rad < 0.1 && !(difference_rad < 0.5 * before_rad);
    before_rad = difference_rad;
  }
  first_s_ = backward_.back().nodes.back().t_s;
  last_s_ = forward_.back().nodes.back().t_s;
  for (const Path* path : {&forward_, &backward_}) {
    for (const Leg& leg : *path) steps_ += leg.nodes.size() - 1;
  }
}

State ExtrapolatedMotion::at(double t_high_s, double t_low_s) const {
  if (std::isnan(t_high_s + t_low_s)) return nan_state();
  const Path& path = is_forward(t_high_s) ? forward_ : backward_;
  const double away_s = std::abs(t_high_s);
  const Leg& leg =
      *std::find_if(path.begin(), path.end() - 1, [&](const Leg& l) { return away_s <= std::abs(l.nodes.back().t_s); });
  const auto after = std::upper_bound(leg.nodes.begin(), leg.nodes.end(), away_s,
                                      [](double t, const Node& node) { return t < std::abs(node.t_s); });
  const Node& node = *(after == leg.nodes.begin() ? after : after - 1);
  const long double length_s = (static_cast<long double>(t_high_s) - node.t_s) + t_low_s;
  const Place place =
      length_s == 0.0L ? node.place : Method(moments_, leg.torques).step(node.t_s, node.place, length_s, nullptr);
  State state{place.q_inertial_from_body.cast<double>(), place.momentum_body.cast<double>()};
  // A momentum that damping has made less than a FreeBody may have is none.
  if (state.momentum_body.stableNorm() < kLeastMagnitude) state.momentum_body.setZero();
  return state;
}

}  // namespace polhode::rivals
