#include "polhode/torque/torques.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "polhode/base/error.hpp"

namespace polhode {

std::string_view torque_name(const Torque& torque) {
  constexpr std::array<std::string_view, std::variant_size_v<Torque>> names{
      "gravity gradient", "constant torque",      "thruster pulse", "linear damping",
      "eddy currents",    "internal dissipation", "sunlight"};
  return names[torque.index()];
}

Torques::Torques(std::vector<Torque> torques) : torques_(std::move(torques)), orbit_of_torque_(torques_.size(), 0) {
  for (std::size_t i = 0; i < torques_.size(); ++i) {
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { one.trajectory; }) {
            const auto known = std::find(trajectories_.begin(), trajectories_.end(), one.trajectory);
            orbit_of_torque_[i] = static_cast<std::size_t>(known - trajectories_.begin());
            if (known == trajectories_.end()) trajectories_.push_back(one.trajectory);
          }
        },
        torques_[i]);
  }
  if (trajectories_.size() > kMostTrajectories) {
    throw InputError(fmt::format("the torques have {} different trajectories, at most {} are allowed",
                                 trajectories_.size(), kMostTrajectories));
  }
}

double Torques::time_scale_s(double t_s) const {
  double scale_s = std::numeric_limits<double>::infinity();
  for (const Trajectory& trajectory : trajectories_) {
    const OrbitState<double> orbit = trajectory.state(t_s);
    scale_s = std::min(scale_s, orbit.position_m.norm() / orbit.velocity_m_s.norm());
  }
  return scale_s;
}

bool Torques::smooth() const {
  return std::none_of(torques_.begin(), torques_.end(),
                      [](const Torque& torque) { return std::holds_alternative<Sunlight>(torque); });
}

double Torques::cost_of_evaluation() const {
  constexpr double facets_per_gradient = 50.0;
  double cost = 1.0;
  for (const Torque& torque : torques_) {
    if (const auto* sunlight = std::get_if<Sunlight>(&torque)) {
      cost += static_cast<double>(sunlight->facet_count()) / facets_per_gradient;
    }
  }
  return cost;
}

std::vector<Torques::Pull> Torques::pulls() const {
  std::vector<Pull> pulls;
  for (std::size_t i = 0; i < torques_.size(); ++i) {
    if (const auto* gravity = std::get_if<GravityGradient>(&torques_[i])) {
      pulls.push_back({gravity->mu_m3_s2, orbit_of_torque_[i]});
    }
  }
  return pulls;
}

Torques Torques::without_pulls() const {
  Torques others;
  others.trajectories_ = trajectories_;
  for (std::size_t i = 0; i < torques_.size(); ++i) {
    if (std::holds_alternative<GravityGradient>(torques_[i])) continue;
    others.torques_.push_back(torques_[i]);
    others.orbit_of_torque_.push_back(orbit_of_torque_[i]);
  }
  return others;
}

std::vector<double> Torques::jumps_s() const {
  std::vector<double> times_s;
  for (const Torque& torque : torques_) {
    if (const auto* pulse = std::get_if<ThrusterPulse>(&torque)) {
      times_s.push_back(pulse->start_s);
      times_s.push_back(pulse->end_s());
    }
  }
  for (const Trajectory& trajectory : trajectories_) {
    if (trajectory.table() == nullptr) continue;
    const std::vector<double> seams_s = trajectory.table()->seams_s();
    times_s.insert(times_s.end(), seams_s.begin(), seams_s.end());
  }
  std::sort(times_s.begin(), times_s.end());
  times_s.erase(std::unique(times_s.begin(), times_s.end()), times_s.end());
  return times_s;
}

Torques Torques::during(double inside_s) const {
  std::vector<Torque> on;
  for (const Torque& torque : torques_) {
    const auto* pulse = std::get_if<ThrusterPulse>(&torque);
    if (pulse == nullptr) {
      on.push_back(torque);
    } else if (pulse->start_s < inside_s && inside_s < pulse->end_s()) {
      on.push_back(ConstantTorque{pulse->torque_body, ConstantTorque::Axes::body});
    }
  }
  return Torques(std::move(on));
}

}  // namespace polhode
