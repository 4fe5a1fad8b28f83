#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "polhode/motion/values/dormand_prince.hpp"
#include "polhode/torque/facet_table.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// What a step of Dormand and Prince's method gets wrong where facets come into a stream or leave it
/// (Torques::streams()) within it: its weights integrate polynomials, not a function with a kink. From where c = 0 on,
/// the torque is another one than before by plus or minus a part that begins as c does. The powers of the time since
/// then, up to the fourth, are integrated exactly; what the stages make of them is known as well.
struct EdgeCorrections {
  /// What is known at the parts 0, 1/4, 1/2, 3/4, 1 of a step, between which all is smooth.
  struct Place {
    std::vector<TorqueStream> streams;
    /// Turn a torque into the derivatives of the first four unknowns.
    Eigen::Matrix<double, 4, 3> columns;
  };

  /// Of the step's increment, and of the sums behind its error estimates (per unit of time): to be added.
  dormand_prince::Unknowns increment, fifth, third;

  /// Of a step of length h. False if no facet comes in or leaves.
  bool find(const std::array<Place, 5>& places, double h);
};

}  // namespace polhode
