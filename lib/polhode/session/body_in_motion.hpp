#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/motion/methods.hpp"
#include "polhode/motion/motion.hpp"
#include "polhode/motion/planner.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/write/ephemeris_formats.hpp"

namespace polhode {

/// A tolerance for BodyInMotion::motion_of that leaves the planned one.
inline constexpr double kAsPlanned_rad = std::numeric_limits<double>::infinity();

/// A body and its motion in an inertial frame: what the program and the Python package make ephemerides of.
struct BodyInMotion {
  Body body;
  Frame frame = Frame::icrf;
  FreeBody free;  ///< the body at its epoch
  std::shared_ptr<const Motion> motion;
  /// What to say of the states between two times, seconds from the epoch.
  std::function<MotionAccount(double first_s, double last_s)> account;
  bool under_torques = false;
  std::shared_ptr<const Uncertainty> uncertainty;  ///< the body's, and behind it that of the torques; null: exact
  /// Under torques: the motion of another body at the same epoch, as planned for this one, or to a finer tolerance.
  /// `numbers` are the values of `uncertainty`. The account's error is that of the propagation alone. Throws what
  /// planned_motion() throws.
  std::function<PlannedMotion(const FreeBody&, const Eigen::VectorXd& numbers, double tolerance_rad)> motion_of;
  double first_s = 0.0, last_s = 0.0;  ///< under torques: the span that the motion was made for

  /// The same between two instants. Throws InputError where they lie outside of the span.
  MotionAccount account_between(Instant start, Instant stop, TimeScale scale) const;
};

/// The free motion of a complete body by this method. Throws what free_body() throws.
BodyInMotion free_motion_of(Body body, Frame frame, const Method& method);

/// One sigma of the attitude at the end of a scene's span by its body's uncertainties, without torques: at the end
/// where it is less, if the span has two. 0 without uncertainties.
double uncertain_at_end_rad(const Scene& scene);

/// worth_text() of a scene's body, and what says more where the torques' own numbers are uncertain: not beside a
/// covariance that says it already, unless the body's own text could be taken for all.
std::optional<std::string> scene_worth_text(const Body& body, bool torques_are_uncertain, double farthest_s,
                                            bool beside_covariance = false);

/// The plan of a scene; `full` keeps every effect.
Plan plan_of(const Scene& scene, bool full);

/// The motion of a scene as planned. Throws what free_body(), plan_motion() and planned_motion() throw;
/// `most_evaluations` is the library's choice unless given.
BodyInMotion planned_motion_of(const Scene& scene, bool full, std::optional<std::size_t> most_evaluations);

/// The covariance of the attitude of a body with uncertainties, and what to say of it.
struct CovarianceRows {
  CovarianceOfAttitude rows;
  std::optional<std::string> caution;
};

/// Between two times, seconds from the epoch. Of a free motion by its exact partial derivatives; under torques by
/// motions that are displaced by a part of a sigma both ways. Throws InputError for a body without an uncertainty.
CovarianceRows covariance_rows(const BodyInMotion& moving, double from_s, double to_s);

/// How many rows keep what the format's readers interpolate within the tolerance.
std::size_t rows_for_tolerance(const BodyInMotion& moving, Instant start, Instant stop, TimeScale scale,
                               double tolerance_rad, RowInterpolation interpolation);

/// The rows at these times, with their covariance if it is asked for. `tolerance_rad` is promised between them in this
/// format, if it is given.
Ephemeris rows_of(const BodyInMotion& moving, TimeGrid times, std::optional<double> tolerance_rad,
                  const EphemerisFormat* format, bool covariance = false);

}  // namespace polhode
