#pragma once

#include <optional>
#include <string>
#include <vector>

#include "polhode/torque/torques.hpp"

namespace polhode {

/// A number that a torque depends on: "gravity gradient 1 mu_m3_s2", by the torque's place in the list and the name
/// that it gives the number (Torque: parameters()).
struct TorqueParameter {
  std::string name;
  std::size_t torque = 0;  ///< place in Torques::list()
  std::size_t number = 0;  ///< place in what the torque lists
  double value = 0.0;
  double scale = 1.0;  ///< a size that it may have: its own, or that of the torque's others where it is 0

  bool is(std::string_view what) const { return name.ends_with(what); }
};

/// Of all torques, in their order.
std::vector<TorqueParameter> parameters_of(const Torques& torques);

/// The torques with another value. Along with mu goes the way about that mass, where it is an orbit: for every torque
/// on it, with periapsis, eccentricity and time of periapsis kept.
Torques with_parameter(const Torques& torques, const TorqueParameter& parameter, double value);

}  // namespace polhode
