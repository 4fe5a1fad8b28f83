#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/body.hpp"
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
  std::vector<double> momentum_named;      ///< rows x 3, named axes; N m s if the inertia is absolute
  TimeGrid::ScaleNodes scale_nodes;
  std::vector<double> elapsed_high, elapsed_low;  ///< TT seconds from the body's epoch

  void reserve_rows(std::size_t count);
};

/// The motion of a body's principal axes, as the ephemeris asks for it: at TT seconds high + low from the body's epoch,
/// write the attitude to q (rows x 4, scalar first, v_frame = q v_principal q*, sign continuous in time) and the
/// angular momentum in principal axes, in the unit of the moments times rad/s, to m (rows x 3). Called from several
/// threads at once.
using PrincipalMotion =
    std::function<void(std::span<const double> high, std::span<const double> low, double* q, double* m)>;

/// What an ephemeris says about itself.
struct EphemerisDescription {
  std::string object;
  std::string source;                   ///< of the body's numbers
  std::string method;                   ///< of the motion
  double promised_error_rad = 0.0;      ///< of every row, and of what stands between rows if `tolerance_rad` is given
  std::optional<double> tolerance_rad;  ///< promised for the interpolation that the format's readers do
  std::string interpolation;            ///< that interpolation, in words, where one is promised
};

/// The attitude of the axes that a body's file names, at the times of a grid, computed in blocks when asked for: a
/// table of any length in constant memory. Thread-safe.
class Ephemeris {
 public:
  /// `body` has an inertia and a state; `frame` is the inertial frame of `motion` and of the rows.
  Ephemeris(EphemerisDescription description, const Body& body, Frame frame, TimeGrid times, PrincipalMotion motion);

  const EphemerisDescription& description() const { return description_; }
  EphemerisDescription& description() { return description_; }
  const Inertia& inertia() const { return inertia_; }
  Frame frame() const { return frame_; }
  const TimeGrid& times() const { return times_; }
  Instant epoch() const { return epoch_; }

  /// Rows first … first + count - 1. Throws InputError where two rows fall on one time of the resolution,
  /// ComputationError where a number is not finite.
  void fill(std::size_t first, std::size_t count, TimeResolution resolution, AttitudeBlock& block) const;

 private:
  void refuse_equal_times(std::size_t first, TimeResolution resolution, std::span<const Seconds> times) const;

  EphemerisDescription description_;
  Inertia inertia_;
  Frame frame_;
  TimeGrid times_;
  PrincipalMotion motion_;
  Instant epoch_;
  std::optional<Quaternion> q_principal_from_named_;  // absent where the axes are the same
};

}  // namespace polhode
