#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/body.hpp"
#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/ephemeris/time_grid.hpp"
#include "polhode/frames/frame.hpp"

namespace polhode {

/// Consecutive rows of an attitude ephemeris. The arrays are as long as the largest block asked for; `rows` of them
/// are filled.
struct AttitudeBlock {
  std::size_t rows = 0;
  std::vector<Seconds> time;               ///< of the ephemeris' scale, from TimeGrid::reference()
  std::vector<double> q_frame_from_named;  ///< rows x 4, scalar first, v_frame = q v_named q*, sign continuous
  std::vector<double> omega_named_rad_s;   ///< rows x 3, components in the named (body) axes
  std::vector<double> momentum_named;      ///< rows x 3, named axes; N m s if the inertia is absolute, 0 without one
  std::vector<double> sigma_rad;           ///< of an ephemeris with a covariance: root of its largest eigenvalue
  std::vector<double> covariance_rad2;     ///< rows x 6, of a small turn in the named axes: xx, xy, xz, yy, yz, zz
  TimeGrid::ScaleNodes scale_nodes;
  std::vector<double> elapsed_high, elapsed_low;  ///< TT seconds from the body's epoch, or the history's first row

  void reserve_rows(std::size_t count);
};

/// The motion of a body's principal axes, as the ephemeris asks for it: at TT seconds high + low from the body's epoch,
/// write the attitude to q (rows x 4, scalar first, v_frame = q v_principal q*, sign continuous in time) and the
/// angular momentum in principal axes, in the unit of the moments times rad/s, to m (rows x 3). Called from several
/// threads at once.
using PrincipalMotion =
    std::function<void(std::span<const double> high, std::span<const double> low, double* q, double* m)>;

/// The covariance of the attitude at the same times: `sigma_rad` and rows x 6 as AttitudeBlock has them. Called from
/// several threads at once.
using CovarianceOfAttitude = std::function<void(std::span<const double> high, std::span<const double> low,
                                                double* sigma_rad, double* covariance_rad2)>;

/// What an ephemeris says about itself.
struct EphemerisDescription {
  std::string object;
  std::string source;                             ///< of the body's numbers
  std::string method;                             ///< that the motion was computed by
  std::optional<double> promised_error_rad;       ///< of every row; absent: nothing is promised
  std::string error_meaning;                      ///< what that error covers, or why none is promised, in words
  std::optional<std::size_t> torque_evaluations;  ///< that the motion took; absent where it is none under torques
  std::vector<std::string> cautions;              ///< what a user of the rows should know besides, in words
  std::optional<double> tolerance_rad;            ///< promised for the interpolation that the format's readers do
  std::string interpolation;                      ///< that interpolation, in words, where one is promised
  std::string ccsds_interpolation;                ///< INTERPOLATION_METHOD of CCSDS, empty: none is recommended
  int ccsds_interpolation_degree = 0;
  std::string object_id;  ///< designation; empty: none, OBJECT_ID of messages is `object`
  std::string body_axes;  ///< their name in messages; empty: SC_BODY_1, or BODY in FITS
};

/// The attitude of a body's named axes at the times of a grid, computed in blocks when asked for: a table of any length
/// in constant memory. Thread-safe.
class Ephemeris {
 public:
  /// The motion of a body, of the axes that its file names. `body` has an inertia and a state; `frame` is the inertial
  /// frame of `motion` and of the rows. Throws InputError for a body without, an inertia that is none, no motion.
  Ephemeris(EphemerisDescription description, const Body& body, Frame frame, TimeGrid times, PrincipalMotion motion);

  /// A segment of an attitude history, as interpolate() has it. `times` lie between its first() and last(). The rows
  /// refer to `frame`, or if there is none to the segment's own. Throws InputError if the segment's frame cannot be led
  /// to `frame`, if it has a single row without rate, or for what checked() refuses.
  Ephemeris(EphemerisDescription description, AttitudeSegment segment, std::optional<Frame> frame, TimeGrid times);

  const EphemerisDescription& description() const { return description_; }
  EphemerisDescription& description() { return description_; }
  /// Of the body; absent for an attitude history.
  const std::optional<Inertia>& inertia() const { return inertia_; }
  const std::string& frame_name() const { return frame_name_; }
  const TimeGrid& times() const { return times_; }
  /// Rows have their covariance from then on.
  void set_covariance(CovarianceOfAttitude covariance) { covariance_ = std::move(covariance); }
  bool has_covariance() const { return covariance_ != nullptr; }

  /// Rows first … first + count - 1. Throws InputError where two rows fall on one time of the resolution,
  /// ComputationError where a number is not finite.
  void fill(std::size_t first, std::size_t count, TimeResolution resolution, AttitudeBlock& block) const;

 private:
  void refuse_equal_times(std::size_t first, TimeResolution resolution, std::span<const Seconds> times) const;

  EphemerisDescription description_;
  std::optional<Inertia> inertia_;
  std::string frame_name_;
  TimeGrid times_;
  Instant epoch_;                                                // from which `rows_` counts
  std::function<void(std::size_t count, AttitudeBlock&)> rows_;  // attitude, rate and momentum at the elapsed times
  CovarianceOfAttitude covariance_;
};

/// The largest angle between the attitudes of two ephemerides at the rows of the first, which has as many as the second
/// at the same times; what an inexact method is compared with an exact one by.
double largest_difference_rad(const Ephemeris& one, const Ephemeris& other);

}  // namespace polhode
