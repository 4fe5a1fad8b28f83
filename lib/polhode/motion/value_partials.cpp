#include <algorithm>
#include <cmath>

#include "polhode/motion/value_motion.hpp"
#include "polhode/motion/values/rates.hpp"

namespace polhode {
namespace {

using values::Unknowns;

constexpr double kRoundings = 5e-15;
constexpr double kAside = 1e-5;  // of states on either side: a turn, or of the momentum

Quaternion turned(const Vector3& turn_rad) {
  const double angle = turn_rad.norm(), half = angle > 0.0 ? std::sin(0.5 * angle) / angle : 0.5;
  return {std::cos(0.5 * angle), half * turn_rad[0], half * turn_rad[1], half * turn_rad[2]};
}

}  // namespace

class ValueMotion::ValuePartials final : public Partials {
 public:
  ValuePartials(const ValueMotion& motion, const FreeBody& body, const Torques& torques,
                std::span<const TorqueParameter> parameters)
      : motion_(motion), columns_(9 + parameters.size()) {
    for (int k = 0; k < 3; ++k) {
      const Vector3 aside = 0x1p-20 * motion.moments_[k] * Vector3::Unit(k);
      moments_.push_back({motion.moments_ + aside, motion.moments_ - aside});
    }
    for (const bool forward : {true, false}) {
      const Path& path = forward ? *motion.forward_ : *motion.backward_;
      Way& way = forward ? forward_ : backward_;
      for (const Leg& leg : path) way.sides.push_back(sides_of(leg));
      for (const TorqueParameter& parameter : parameters) {
        // Torques grow in proportion to it: the step may be large where their effect is small. But along with mu goes
        // the place on the orbit, which is turned by `orbit_rad` in all.
        const double most = largest_turn_rad(path);
        double share = std::clamp(kAside / most, 0x1p-20, 0x1p-3);
        const auto* pull = std::get_if<GravityGradient>(&torques.list()[parameter.torque]);
        if (pull != nullptr && pull->trajectory.orbit() != nullptr) {
          const KeplerElements& orbit = pull->trajectory.orbit()->elements();
          const double orbit_rad = std::sqrt(orbit.mu_m3_s2 / std::pow(orbit.periapsis_m, 3)) *
                                   std::abs(forward ? motion.last_s() : motion.first_s());
          share = std::min(share, std::cbrt(kRoundings / (most * orbit_rad * orbit_rad)));
        }
        const double step = parameter.scale * share;
        const double more = parameter.value + step, less = parameter.value == 0.0 ? 0.0 : parameter.value - step;
        std::vector<Side> added[2];
        for (const double value : {more, less}) {
          const std::vector<TorqueStretch> all =
              stretches(with_parameter(torques, parameter, value).in_principal_axes(body.named_from_principal),
                        forward ? motion.last_s() : motion.first_s());
          for (std::size_t l = 0; l < path.size(); ++l) {
            Leg leg{all[l].torques, {}, {}, {}};
            for (const Trajectory& trajectory : leg.torques.trajectories()) {
              leg.ways.emplace_back(trajectory, std::min(all[l].from_s, all[l].to_s),
                                    std::max(all[l].from_s, all[l].to_s), 0);
            }
            added[value == more ? 0 : 1].push_back({std::make_shared<const Leg>(std::move(leg)), &motion.moments_});
          }
        }
        for (std::size_t l = 0; l < path.size(); ++l) {
          way.sides[l].push_back({added[0][l], added[1][l], more - less});
        }
      }
      run(path, way);
    }
  }

  void batch(const TimeArrays& times, std::span<double> matrices) const override {
    std::vector<SmallChange> now;
    for (std::size_t i = 0; i < times.high.size(); ++i) {
      double* const matrix = &matrices[6 * columns_ * i];
      if (std::isnan(times.high[i])) {
        std::fill_n(matrix, 6 * columns_, std::nan(""));
        continue;
      }
      const Place here = motion_.place(times.high[i], {});
      const bool forward = motion_.is_forward(times.high[i]);
      const Path& path = forward ? *motion_.forward_ : *motion_.backward_;
      const Way& way = forward ? forward_ : backward_;
      const auto l = static_cast<std::size_t>(here.leg - path.data());
      std::size_t step = here.step;
      for (std::size_t before = 0; before < l; ++before) step += path[before].nodes.size() - 1;
      now.assign(&way.starts[columns_ * step], &way.starts[columns_ * step] + columns_);
      const double low_s = times.low.empty() ? 0.0 : times.low[i];
      const Node& node = here.leg->nodes[here.step];
      advance(*here.leg, node, (times.high[i] - node.t_s) + low_s, way.sides[l], now);
      for (std::size_t c = 0; c < columns_; ++c) {
        for (std::size_t k = 0; k < 3; ++k) {
          matrix[k * columns_ + c] = now[c].turn_rad[static_cast<Eigen::Index>(k)];
          matrix[(3 + k) * columns_ + c] = now[c].momentum[static_cast<Eigen::Index>(k)];
        }
      }
    }
  }

 private:
  struct SmallChange {
    Vector3 turn_rad = Vector3::Zero(), momentum = Vector3::Zero();
  };
  struct Side {
    std::shared_ptr<const Leg> leg;
    const Vector3* moments;
  };
  struct Sides {
    Side more, less;
    double apart;  // of the parameter
  };
  struct Pair {
    Vector3 more, less;
  };
  struct Way {
    std::vector<std::vector<Sides>> sides;  // of each leg, for each column beyond the sixth
    std::vector<SmallChange> starts;        // [step of all legs][column]
  };

  std::vector<Sides> sides_of(const Leg& leg) const {
    std::vector<Sides> sides;
    const std::shared_ptr<const Leg> same(std::shared_ptr<const Leg>(), &leg);
    for (int k = 0; k < 3; ++k) {
      const Pair& pair = moments_[static_cast<std::size_t>(k)];
      sides.push_back({{same, &pair.more}, {same, &pair.less}, pair.more[k] - pair.less[k]});
    }
    return sides;
  }

  /// What the torques turn the body by in a step, at most and roughly.
  double largest_turn_rad(const Path& path) const {
    double most = 1e-12;
    for (const Leg& leg : path) {
      if (leg.nodes.size() < 2) continue;
      const double h = leg.nodes[1].t_s - leg.nodes[0].t_s;
      const Vector3 momentum(leg.nodes[0].momentum_inertial);
      double torque = 0.0;
      for (const Torque& one : leg.torques.list()) {
        torque += std::visit(
            [&](const auto& of) { return of.largest(leg.nodes[0].t_s, motion_.moments_, momentum.norm()); }, one);
      }
      most = std::max(most, torque * h * h / motion_.moments_[0]);
    }
    return most;
  }

  struct End {
    Quaternion q;
    Vector3 momentum;
  };
  /// The state after h from this one turned and with another momentum.
  End end_of(const Leg& leg, const Vector3& moments, const Node& from, const SmallChange& change, double h) const {
    const Quaternion q0(from.q[3], from.q[0], from.q[1], from.q[2]);
    const Vector3 momentum = q0.conjugate() * Vector3(from.momentum_inertial) + change.momentum;
    const Quaternion q = q0 * turned(change.turn_rad);
    Unknowns y;
    const double unit = values::unit_of(moments);
    y << (q * momentum).array() / unit, 0.0, q.coeffs().array();
    if (h != 0.0) {
      const Rates rates(moments, leg);
      Unknowns k[dormand_prince::kStages];
      k[0] = rates(from.t_s, y);
      dormand_prince::stages<1, dormand_prince::kStages>(rates, from.t_s, y, h, k);
      y += dormand_prince::increment(h, k);
    }
    return {values::attitude(y).normalized(), unit * (Rates::rotation(y).transpose() * y.head<3>().matrix())};
  }

  static SmallChange between(const End& more, const End& less, double apart) {
    const Quaternion turn = less.q.conjugate() * more.q;
    return {(turn.w() < 0.0 ? -2.0 : 2.0) * turn.vec() / apart, (more.momentum - less.momentum) / apart};
  }

  void advance(const Leg& leg, const Node& from, double h, const std::vector<Sides>& sides,
               std::vector<SmallChange>& columns) const {
    const double unit = std::max(Vector3(from.momentum_inertial).norm(), 1e-3 * motion_.moments_[0] / std::abs(h));
    for (std::size_t c = 0; c < columns_; ++c) {
      const double size = std::max(columns[c].turn_rad.norm(), columns[c].momentum.norm() / unit);
      if (size > 0.0) {
        const double aside = kAside / size;
        const SmallChange more{aside * columns[c].turn_rad, aside * columns[c].momentum};
        const SmallChange less{-more.turn_rad, -more.momentum};
        columns[c] = between(end_of(leg, motion_.moments_, from, more, h), end_of(leg, motion_.moments_, from, less, h),
                             2.0 * aside);
      }
      if (c < 6) continue;
      const Sides& side = sides[c - 6];
      const SmallChange own = between(end_of(*side.more.leg, *side.more.moments, from, {}, h),
                                      end_of(*side.less.leg, *side.less.moments, from, {}, h), side.apart);
      columns[c].turn_rad += own.turn_rad;
      columns[c].momentum += own.momentum;
    }
  }

  void run(const Path& path, Way& way) const {
    std::vector<SmallChange> now(columns_);
    for (int k = 0; k < 3; ++k) {
      const auto column = static_cast<std::size_t>(k);
      now[column].turn_rad[k] = 1.0;
      now[3 + column].momentum[k] = 1.0;
    }
    for (std::size_t l = 0; l < path.size(); ++l) {
      const Leg& leg = path[l];
      for (std::size_t step = 0; step + 1 < leg.nodes.size(); ++step) {
        way.starts.insert(way.starts.end(), now.begin(), now.end());
        advance(leg, leg.nodes[step], leg.nodes[step + 1].t_s - leg.nodes[step].t_s, way.sides[l], now);
      }
    }
    way.starts.insert(way.starts.end(), now.begin(), now.end());
  }

  const ValueMotion& motion_;
  std::size_t columns_;
  std::vector<Pair> moments_;
  Way forward_, backward_;
};

std::unique_ptr<const PropagatedMotion::Partials> ValueMotion::partials(
    const FreeBody& body, const Torques& torques_named, std::span<const TorqueParameter> parameters) const {
  return std::make_unique<const ValuePartials>(*this, body, torques_named, parameters);
}

}  // namespace polhode
