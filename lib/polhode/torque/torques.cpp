#include "polhode/torque/torques.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace polhode {

std::string_view torque_name(const Torque& torque) {
  constexpr std::array<std::string_view, std::variant_size_v<Torque>> names{
      "gravity gradient", "constant torque",      "thruster pulse", "linear damping",
      "eddy currents",    "internal dissipation", "sunlight"};
  return names[torque.index()];
}

double Torques::time_scale_s(double t_s) const {
  double scale_s = std::numeric_limits<double>::infinity();
  for (const Torque& torque : torques_) {
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { one.trajectory; }) {
            const OrbitState<double> orbit = one.trajectory.state(t_s);
            scale_s = std::min(scale_s, orbit.position_m.norm() / orbit.velocity_m_s.norm());
          }
        },
        torque);
  }
  return scale_s;
}

std::vector<double> Torques::jumps_s() const {
  std::vector<double> times_s;
  for (const Torque& torque : torques_) {
    if (const auto* pulse = std::get_if<ThrusterPulse>(&torque)) {
      times_s.push_back(pulse->start_s);
      times_s.push_back(pulse->end_s());
    }
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { one.trajectory; }) {
            if (one.trajectory.table() == nullptr) return;
            const std::vector<double> seams_s = one.trajectory.table()->seams_s();
            times_s.insert(times_s.end(), seams_s.begin(), seams_s.end());
          }
        },
        torque);
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
