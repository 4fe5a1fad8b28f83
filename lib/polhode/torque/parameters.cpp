#include "polhode/torque/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace polhode {

std::vector<TorqueParameter> parameters_of(const Torques& torques) {
  std::vector<TorqueParameter> all;
  for (std::size_t i = 0; i < torques.list().size(); ++i) {
    const std::size_t first = all.size();
    Torque torque = torques.list()[i];
    std::visit(
        [&](auto& one) {
          one.parameters([&](std::string_view name, const double& value, double* /*other*/ = nullptr) {
            all.push_back({fmt::format("{} {} {}", one.name, i + 1, name), i, all.size() - first, value, 1.0});
          });
        },
        torque);
    // (A dipole is no scale for a tensor.)
    double largest = 0.0;
    for (std::size_t k = first; k < all.size(); ++k) {
      if (!all[k].is("dipole_t_m3")) largest = std::max(largest, std::abs(all[k].value));
    }
    for (std::size_t k = first; k < all.size(); ++k) {
      if (all[k].value != 0.0) {
        all[k].scale = std::abs(all[k].value);
      } else if (largest > 0.0 && !all[k].is("dipole_t_m3")) {
        all[k].scale = largest;
      }
    }
  }
  return all;
}

Torques with_parameter(const Torques& torques, const TorqueParameter& parameter, double value) {
  std::vector<Torque> changed = torques.list();
  std::visit(
      [&](auto& one) {
        std::size_t number = 0;
        one.parameters([&](std::string_view /*name*/, double& own, double* other = nullptr) {
          if (number++ != parameter.number) return;
          own = value;
          if (other != nullptr) *other = value;
        });
      },
      changed[parameter.torque]);
  const auto* pull = std::get_if<GravityGradient>(&changed[parameter.torque]);
  if (pull != nullptr && pull->trajectory.orbit() != nullptr) {
    const Trajectory before = pull->trajectory;
    KeplerElements elements = before.orbit()->elements();
    elements.mu_m3_s2 = value;
    const Trajectory after(elements);
    for (Torque& torque : changed) {
      std::visit(
          [&](auto& one) {
            if constexpr (requires { one.trajectory; }) {
              if (one.trajectory == before) one.trajectory = after;
            }
            if constexpr (requires { one.second_trajectory; }) {
              if (one.second_trajectory == before) one.second_trajectory = after;
            }
          },
          torque);
    }
  }
  return Torques(std::move(changed));
}

}  // namespace polhode
