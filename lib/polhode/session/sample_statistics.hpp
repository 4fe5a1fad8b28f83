#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/base/geometry.hpp"
#include "polhode/frames/frame.hpp"

namespace polhode {

/// A sum of numbers of a size up to 1, exact to 2^-62 of each: it does not depend on their order, so that parts add up
/// to the same bits as the whole. For up to 2^60 of them.
class ExactSum {
 public:
  __extension__ using Integer = __int128;
  void add(double x);
  void add(const ExactSum& other) { sum_ += other.sum_; }
  double value() const;
  std::string text() const;
  static ExactSum of_text(std::string_view text);  ///< throws InputError

 private:
  Integer sum_ = 0;
};

/// How often numbers of each size and sign came, in 64 steps for each factor of two from 2^-44 to 2^12: quantiles to a
/// part in 100 of themselves.
class Histogram {
 public:
  static constexpr int kSteps = 64, kLeast = -44, kGreatest = 12, kHalf = (kGreatest - kLeast) * kSteps;

  Histogram() : counts_(2 * kHalf + 1) {}
  void add(double x);  ///< what is NaN is left out
  void add(const Histogram& other);
  std::uint64_t total() const;
  /// The number below which this part of them lies; NaN if there are none, infinite beyond 2^12.
  double quantile(double part) const;

  const std::vector<std::uint64_t>& counts() const { return counts_; }
  std::vector<std::uint64_t>& counts() { return counts_; }

 private:
  std::vector<std::uint64_t> counts_;  // -large ... -small, 0, small ... large
};

/// What a clone is at one time, in named axes, and the same of the body with the published numbers.
struct CloneState {
  Quaternion q_inertial_from_named;
  Vector3 momentum_inertial;  ///< direction of it
  double rate_rad_s = 0.0;
  enum class Mode { short_axis, long_axis, other } mode = Mode::other;
  double polhode_period_s = 0.0, long_axis_precession_period_s = 0.0;  ///< NaN where there is none
  Vector3 omega_named_rad_s = Vector3::Zero();
};

/// Right ascension and declination in ICRF of a direction in the frame, in degrees; NaN for the zero vector, which has
/// none.
std::array<double, 2> ra_dec_deg(const Vector3& direction, Frame frame);

/// Statistics of the clones at one time, in constant memory.
struct ClonesAtTime {
  std::uint64_t count = 0;
  std::array<std::uint64_t, 3> modes{};
  std::array<ExactSum, 10> attitude;          ///< of the products of the quaternion's components, the upper triangle
  std::array<ExactSum, 3> direction;          ///< of the momentum's unit vector
  Histogram attitude_angle, direction_angle;  ///< from the published body's
  Histogram rate, polhode_period, precession_period;  ///< the relative deviation from it

  void add(const CloneState& clone, const CloneState& published);
  void add(const ClonesAtTime& other);

  Quaternion mean_attitude() const;     ///< that minimises the mean square of sin(angle/2)
  double attitude_spread_rad() const;   ///< 2 asin of the root of that mean
  Vector3 mean_direction() const;       ///< a unit vector
  double direction_spread_rad() const;  ///< 2 asin of the root of the mean square of sin(angle/2) about it
};

/// As text, which gives the same sums again.
std::string text_of(const ClonesAtTime& clones);
/// Takes what text_of() wrote from the front of the text. Throws InputError.
ClonesAtTime take_clones(std::string_view& text);

}  // namespace polhode
