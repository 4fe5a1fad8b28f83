#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/body/inertia.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/time/scale.hpp"

namespace polhode {

/// A row of an attitude history.
struct AttitudeSample {
  Instant time;
  Quaternion q_frame_from_body;  ///< unit, either sign: v_frame = q v_body q*
  std::optional<Vector3> omega_body_rad_s;
};

/// How to go between rows. The words are those of CCSDS 504.0-B.
enum class AttitudeInterpolation { linear, lagrange, hermite };

/// "LINEAR", "LAGRANGE", "HERMITE".
std::string_view name(AttitudeInterpolation method);

/// Rows that belong together: no interpolation leads from one segment to the next.
struct AttitudeSegment {
  std::string frame;                 ///< the reference frame, as the file names it
  std::string body;                  ///< the body axes, as the file names them
  std::optional<Frame> known_frame;  ///< of `frame`, if it is inertial
  AttitudeInterpolation method = AttitudeInterpolation::linear;
  int degree = 1;
  bool method_stated = false;           ///< whether the file says method and degree; else they are our choice
  std::optional<Instant> usable_start;  ///< where the file says that interpolation is good, if it does
  std::optional<Instant> usable_stop;
  std::vector<AttitudeSample> samples;  ///< at least one, times increasing; rates on all of them or on none

  bool has_rates() const { return !samples.empty() && samples.front().omega_body_rad_s.has_value(); }

  /// HERMITE of degree 3 of rows with rates, else LINEAR: our choice where the file says nothing.
  void choose_method();

  /// The first and the last instant at which an attitude may be asked for: those of the rows, within the usable span.
  /// `last` is before `first` where the usable span holds no row and lies between none.
  Instant first() const;
  Instant last() const;
  /// From first() to last(), within a microsecond: two files, or two scales, round the time of one row differently.
  bool is_usable_at(Instant time) const;
};

/// An attitude given by rows.
struct AttitudeHistory {
  std::string object;
  std::string object_id;  ///< empty: none is given
  std::string source;
  TimeScale scale = TimeScale::utc;  ///< as written
  bool absolute_time = true;         ///< false: a clock of the spacecraft, only differences count
  std::vector<AttitudeSegment> segments;
  std::optional<Inertia> inertia;  ///< where the file says it
  std::vector<std::string> notes;
  std::vector<std::string> warnings;

  std::size_t rows() const;
};

/// Throws InputError, naming both, where two segments hold for a time, by their rows within their usable spans. They
/// may share an instant.
void refuse_overlaps(const AttitudeHistory& history);

/// Attitude and rate at an instant within the rows of a segment, by its method and degree:
/// - LINEAR leads from row to row by the shortest rotation, below 180 deg, at a constant rate. With rates it is the
///   mean of the two rows' rates, of any number of turns, with what lacks to the next row spread over the way.
/// - LAGRANGE of degree n is the polynomial of degree n through the n + 1 rows around the instant in each component of
///   the quaternion, then unit length: what an error that a file promises for it is about. The signs are those of the
///   shortest rotations, or with rates of the turns that they tell.
/// - HERMITE of degree n fits the rates as well, with (n + 1) / 2 rows, in the components of the quaternion relative to
///   a steady rotation at the mean rate, of any number of turns; without rates it is LAGRANGE.
/// Fewer rows if the segment is short.
///
/// Rows are met exactly, and within a nanosecond of one the rate is the row's; elsewhere it is the derivative of the
/// attitude. `time` more than 1 us outside of the rows (two files round one time differently): InputError.
AttitudeSample interpolate(const AttitudeSegment& segment, Instant time);

/// Returns the segment. Throws InputError unless it is as AttitudeSegment says: at least one row, times that increase,
/// attitudes and rates that are finite, rates on all rows or on none.
const AttitudeSegment& checked(const AttitudeSegment& segment);

/// Why interpolate() may lead to another motion than the one that the rows are of, in words, or nothing: rows more than
/// half a turn apart, by their rates, or by what goes on from the rows before, where the method takes the shortest way.
std::optional<std::string> doubt_about_interpolation(const AttitudeSegment& segment);

/// Gives the quaternions of the rows the signs with which interpolate() is continuous over the whole segment.
void make_signs_continuous(AttitudeSegment& segment);

/// Differences between two attitudes over time.
struct AttitudeDifference {
  std::size_t compared = 0;
  std::size_t outside = 0;  ///< rows of the first at whose time the second has no attitude
  double largest_rad = 0.0;
  double root_mean_square_rad = 0.0;
  Instant time_of_largest;
};

/// The angle of the rotation between the attitudes of `a` and `b` at the times of a's rows within their usable spans;
/// at an instant that two segments of `b` share, to the nearer. The body's axes are taken as the same; the reference
/// frames are led to ICRF, or must have one name. Throws InputError if the frames cannot be related, a clock cannot be,
/// no row of `a` has a counterpart, or for what refuse_overlaps() refuses.
AttitudeDifference compare(const AttitudeHistory& a, const AttitudeHistory& b);

/// The same against an attitude known at any time: v_icrf = q v_body q*.
AttitudeDifference compare(const AttitudeHistory& a, const std::function<Quaternion(Instant)>& q_icrf_from_body);

}  // namespace polhode
