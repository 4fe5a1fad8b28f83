#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "polhode/base/geometry.hpp"

namespace polhode {

/// A free rigid body at t = 0, in its principal axes. All numbers are taken as exact.
struct FreeBody {
  /// I1 <= I2 <= I3, positive, any one unit, within the limits of check_principal_moments().
  Vector3 principal_moments;
  /// v_inertial = q v_body q*, any length but 0 (normalised exactly inside).
  Quaternion q_inertial_from_body;
  /// Angular momentum in the principal axes, (unit of inertia) rad/s, within the limits of check_angular_momentum().
  /// Zero is a body at rest.
  Vector3 momentum_body;
  /// The principal axes, as columns, in the axes that torques on the body are given in: v_named = R v_principal, as in
  /// Inertia. The free motion does not depend on it.
  Matrix3 named_from_principal = Matrix3::Identity();
};

/// Returns the body. Throws InputError, naming what was found, unless it is as FreeBody says: every motion calls it
/// when it is made. (named_from_principal is checked where torques are.)
const FreeBody& checked(const FreeBody& body);

/// Throws InputError unless the span of a motion is finite and holds t = 0.
void check_span(double first_s, double last_s);

/// How far beyond a span its motion answers: rows evenly spaced in one time scale end up to 3.4 ms beyond a span that
/// was given in another (TDB swings about TT), and the motion goes on well enough for that long.
constexpr double end_room_s(double span_s) { return span_s < 0.5 ? 0.01 * span_s : 5e-3; }

/// Throws InputError for a time outside of what was propagated by more than end_room_s().
void check_within(double t_s, double first_s, double last_s);

/// Attitude and angular momentum at one instant.
struct State {
  Quaternion q_inertial_from_body;  ///< unit to 2 eps, sign continuous in time
  Vector3 momentum_body;            ///< principal axes, unit of FreeBody::momentum_body
};

/// What was done to compute a motion. Files and messages say of method, error and cost what stands here.
struct MotionAccount {
  std::string method;                   ///< that gave the states, by its name
  std::optional<double> max_error_rad;  ///< promised for the attitude anywhere in the span; absent: nothing is promised
  std::string error_meaning;            ///< what `max_error_rad` covers and how it was found, in words
  std::size_t torque_evaluations = 0;   ///< of all runs, also of those that were not kept
};

/// What a motion answers where it has no answer: NaN throughout.
State nan_state();

/// Seconds from t = 0: `high`, or high + low for callers with two parts (they may overlap). Any order, size and sign.
struct TimeArrays {
  std::span<const double> high;
  std::span<const double> low = {};  ///< empty, or as long as `high`
};

/// Throws InputError if `low` has another length. Every batch calls it once.
void check_lengths(const TimeArrays& times);

/// Where a batch writes: component k of instant i goes to q[k][i * q_stride] and m[k][i * m_stride]. Arrays of
/// structures (Eigen-mappable row-major n x 4 and n x 3) and separate arrays are the two layouts that are fast. m may
/// be all null: attitude alone.
struct StateArrays {
  double* q[4] = {};  ///< scalar first
  std::ptrdiff_t q_stride = 4;
  double* m[3] = {};
  std::ptrdiff_t m_stride = 3;

  void put(std::size_t i, const State& state) const {
    const Eigen::Vector4d scalar_first_q = scalar_first(state.q_inertial_from_body);
    const auto row = static_cast<std::ptrdiff_t>(i);
    for (int k = 0; k < 4; ++k) q[k][row * q_stride] = scalar_first_q[k];
    if (m[0] == nullptr) return;
    for (int k = 0; k < 3; ++k) m[k][row * m_stride] = state.momentum_body[k];
  }

  /// Row-major n x 4 (scalar first) and n x 3; `m` may be null.
  static StateArrays of_structures(double* q, double* m) {
    StateArrays a;
    for (int k = 0; k < 4; ++k) a.q[k] = q + k;
    for (int k = 0; k < 3; ++k) a.m[k] = m == nullptr ? nullptr : m + k;
    return a;
  }
};

/// The times from `begin` to before `end`, and where the results from `begin` on go: for work in parts.
TimeArrays part_of(const TimeArrays& times, std::size_t begin, std::size_t end);
StateArrays part_of(const StateArrays& out, std::size_t begin);

/// A motion, free or under torques, built once, answered at any time. Thread-safe: evaluation changes nothing. The
/// classes of motions can be copied, moved and kept in a vector.
class Motion {
 public:
  virtual ~Motion() = default;

  /// State at t = high + low seconds. Of an exact motion it is a state of the body at any finite t, but its phase is
  /// that of t only as far as the arithmetic goes (theta.md, Precision). Where t is NaN, or infinite and the motion has
  /// no span, the attitude is NaN, and so is the momentum unless it stays as it is; a motion that was made for a span
  /// throws InputError for other times outside of it. Batches do the same.
  virtual State at(double t_high_s, double t_low_s = 0.0) const = 0;

  /// States at many times; the default calls at() for each. Allocates nothing.
  virtual void batch(const TimeArrays& times, const StateArrays& out) const;

 protected:
  Motion() = default;
  Motion(const Motion&) = default;  // not through the base, which would cut a motion down to it
  Motion(Motion&&) = default;
  Motion& operator=(const Motion&) = default;
  Motion& operator=(Motion&&) = default;
};

/// Motion::batch on several threads, 0 meaning one per core. The results are the same bits for every thread count.
void batch_threads(const Motion& motion, const TimeArrays& times, const StateArrays& out, unsigned thread_count = 0);

}  // namespace polhode
