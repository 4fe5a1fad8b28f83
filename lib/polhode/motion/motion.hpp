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
  /// I1 <= I2 <= I3, positive and finite, any one unit.
  Vector3 principal_moments;
  /// v_inertial = q v_body q*, any length but 0 (normalised exactly inside).
  Quaternion q_inertial_from_body;
  /// Angular momentum in the principal axes, (unit of inertia) rad/s. Zero is a body at rest.
  Vector3 momentum_body;
};

/// Attitude and angular momentum at one instant.
struct FreeState {
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

/// Seconds from t = 0: `high`, or high + low for callers with two parts (they may overlap). Any order, size and sign.
struct TimeArrays {
  std::span<const double> high;
  std::span<const double> low = {};  ///< empty, or as long as `high`
};

/// Where a batch writes: component k of instant i goes to q[k][i * q_stride] and m[k][i * m_stride]. Arrays of
/// structures (Eigen-mappable row-major n x 4 and n x 3) and separate arrays are the two layouts that are fast. m may
/// be all null: attitude alone.
struct StateArrays {
  double* q[4] = {};  ///< scalar first
  std::ptrdiff_t q_stride = 4;
  double* m[3] = {};
  std::ptrdiff_t m_stride = 3;

  /// Row-major n x 4 (scalar first) and n x 3; `m` may be null.
  static StateArrays of_structures(double* q, double* m) {
    StateArrays a;
    for (int k = 0; k < 4; ++k) a.q[k] = q + k;
    for (int k = 0; k < 3; ++k) a.m[k] = m == nullptr ? nullptr : m + k;
    return a;
  }
};

/// A motion, built once, answered at any time. Thread-safe: evaluation changes nothing.
class FreeMotion {
 public:
  FreeMotion() = default;
  FreeMotion(const FreeMotion&) = delete;
  FreeMotion& operator=(const FreeMotion&) = delete;
  virtual ~FreeMotion() = default;

  /// State at t = high + low seconds.
  virtual FreeState at(double t_high_s, double t_low_s = 0.0) const = 0;

  /// States at many times; the default calls at() for each. Allocates nothing.
  virtual void batch(const TimeArrays& times, const StateArrays& out) const;
};

/// FreeMotion::batch on several threads, 0 meaning one per core. The results are the same bits for every thread count.
void batch_threads(const FreeMotion& motion, const TimeArrays& times, const StateArrays& out,
                   unsigned thread_count = 0);

}  // namespace polhode
