#pragma once

#include <array>
#include <memory>
#include <vector>

#include "polhode/session/body_in_motion.hpp"

namespace polhode {

/// A motion whose uncertain numbers are displaced, `displacement` sigmas along one part of the uncertainty.
struct DisplacedMotion {
  Body body;
  FreeBody free;
  std::shared_ptr<const Motion> motion;
  double error_rad = 0.0;     ///< of the propagation
  double displacement = 0.0;  ///< sigmas
};

/// Of a function with the changes `one` and `other` at two displacements: its derivative at 0, and half the second, by
/// the parabola through both.
struct ParabolaWeights {
  double first_of_one, first_of_other, second_of_one, second_of_other;
};
ParabolaWeights parabola_weights(const DisplacedMotion& one, const DisplacedMotion& other);

/// Motions of a scene that start displaced by a part of one sigma of each part of its uncertainty, to both sides, or
/// twice to one side where there is no such body or torque on the other. They are propagated more closely than the
/// scene asks where its torques allow it, as their differences need it.
struct DisplacedMotions {
  /// Throws InputError for a scene without uncertainties, and where there is nothing on either side.
  explicit DisplacedMotions(const BodyInMotion& moving);

  DisplacedMotion centre;
  std::vector<std::array<DisplacedMotion, 2>> of_parts;  ///< of Uncertainty::root()
};

}  // namespace polhode
