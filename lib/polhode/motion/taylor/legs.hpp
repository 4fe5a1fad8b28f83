#pragma once

// What SeriesMotion keeps of a run.

#include <memory>
#include <vector>

#include "polhode/motion/series_motion.hpp"
#include "polhode/motion/taylor/equations.hpp"

namespace polhode {

struct SeriesMotion::Leg {
  taylor::Equations equations;
  std::shared_ptr<const Torques> torques;  // that the equations point to
  Quaternion inertial_from_fixed;          // of the fixed axes
  std::vector<taylor::StepStart> steps;
  double end_s = 0.0;
  std::size_t steps_before = 0;  // of the legs before

  /// Of a step, in units.
  double length(std::size_t step) const {
    const taylor::StepStart& start = steps[step];
    return step + 1 < steps.size() ? (steps[step + 1].t_high - start.t_high) + (steps[step + 1].t_low - start.t_low)
                                   : (end_s / equations.unit_s - start.t_high) - start.t_low;
  }
};

struct SeriesMotion::Place {
  const Leg* leg = nullptr;
  std::size_t step = 0;
};

}  // namespace polhode
