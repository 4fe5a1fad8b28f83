#include "polhode/session/displaced_motions.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"

namespace polhode {
namespace {

constexpr double kDisplacement = 0.25;   // of a sigma: what is of third order is a sixteenth of it
constexpr double kTolerance_rad = 1e-7;  // of the motions: a part in a hundred of a sigma of 1e-5 rad

DisplacedMotion displaced(const BodyInMotion& moving, Body body, const Eigen::VectorXd& numbers, double tolerance_rad,
                          double displacement) {
  DisplacedMotion out{std::move(body), {}, nullptr, 0.0, displacement};
  out.free = free_body(out.body, moving.frame);
  PlannedMotion planned = moving.motion_of(out.free, numbers, tolerance_rad);
  out.motion = std::move(planned.motion);
  out.error_rad = planned.account.max_error_rad.value_or(0.0);
  return out;
}

}  // namespace

ParabolaWeights parabola_weights(const DisplacedMotion& one, const DisplacedMotion& other) {
  const double a = one.displacement, b = other.displacement, all = a * b * (b - a);
  return {b * b / all, -a * a / all, -b / all, a / all};
}

DisplacedMotions::DisplacedMotions(const BodyInMotion& moving) {
  if (!moving.uncertainty) throw InputError("the body has no uncertainty, and --covariance needs one");
  const Uncertainty& uncertainty = *moving.uncertainty;
  const Eigen::MatrixXd root = uncertainty.root();
  // Facets that come into the light make kinks, which may keep motions from the finer tolerances.
  double tolerance_rad = 0.0;
  for (const double finer_rad : {kTolerance_rad, 1e2 * kTolerance_rad, kAsPlanned_rad}) {
    try {
      tolerance_rad = finer_rad;
      centre = displaced(moving, moving.body, uncertainty.values(), tolerance_rad, 0.0);
      break;
    } catch (const ComputationError&) {
      if (finer_rad == kAsPlanned_rad) throw;
    }
  }
  std::vector<double> z(static_cast<std::size_t>(root.cols()), 0.0);
  for (double& part : z) {
    std::vector<DisplacedMotion> sides;
    std::string why;
    for (const double displacement : {kDisplacement, -kDisplacement, 0.5 * kDisplacement, -0.5 * kDisplacement}) {
      if (sides.size() == 2 || (sides.empty() && std::abs(displacement) < kDisplacement)) break;
      part = displacement;
      try {
        const Eigen::VectorXd numbers = uncertainty.values(root, z);
        sides.push_back(displaced(moving, uncertainty.body_with(numbers), numbers, tolerance_rad, displacement));
      } catch (const InputError& error) {
        why = error.what();
      }
    }
    part = 0.0;
    if (sides.size() < 2) {
      throw InputError(
          fmt::format("a quarter of a sigma to either side of what is given there is no such scene ({}): draw clones "
                      "with `polhode sample`",
                      why));
    }
    of_parts.push_back({std::move(sides[0]), std::move(sides[1])});
  }
}

}  // namespace polhode
