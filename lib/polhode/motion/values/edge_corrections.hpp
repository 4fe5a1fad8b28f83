#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "polhode/motion/values/dormand_prince.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// What a step of Dormand and Prince's method gets wrong where a part of the torque sets in or ends within it
/// (Torques::edges()): its weights integrate polynomials, not a function with a kink. Both the true integral of such a
/// part and what the stages made of it follow from its values at five places of the step, between which it is smooth.
struct EdgeCorrections {
  /// Of the step's increment, and of the sums behind its error estimates (per unit of time): to be added.
  dormand_prince::Unknowns increment, fifth, third;

  /// `edges` at the parts 0, 1/4, 1/2, 3/4, 1 of a step of length h. `columns` turn the torque of one of them at each
  /// place into the first four unknowns' derivatives. False if no part sets in or ends.
  bool find(const std::array<std::vector<Torques::Edge>, 5>& edges,
            const std::array<Eigen::Matrix<double, 4, 3>, 5>& columns, double h);
};

}  // namespace polhode
