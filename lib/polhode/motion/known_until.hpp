#pragma once

#include <optional>
#include <string>

#include "polhode/motion/attitude_covariance.hpp"

namespace polhode {

/// Up to when the attitude is known to an angle: the first time after the epoch at which one sigma of it is larger.
struct KnownUntil {
  double angle_rad = 0.0;
  double after_s = 0.0;  ///< from the epoch: 0 if not even there, infinite if for ever
};

/// What a state is worth: how long its uncertainties leave the attitude known, and which of them is to blame. To first
/// order (AttitudeCovariance), without torques.
struct StateWorth {
  double sigma_at_epoch_rad = 0.0;
  KnownUntil degree, ten_degrees;
  KnownUntil at_all;  ///< one sigma of 180 deg

  /// The number of the largest term at `limit_s`, which is when 10 deg are reached, or the epoch if they are never or
  /// at once; the part of SIGMA squared there that would be gone were it exact; and until when 10 deg were known if it
  /// were measured ten times as well.
  std::string limit;
  double limit_s = 0.0, limit_share = 0.0;
  KnownUntil with_better_limit;
};

/// Throws what AttitudeCovariance throws.
StateWorth state_worth(const Body& body);

/// "SIGMA": the first time after the epoch at which one sigma is larger than the angle, to a part in 1e6 of it.
double known_until_s(const Body& body, const AttitudeCovariance& covariance, double angle_rad);

/// For people, on one line: what a state is worth, and whether what is wanted lies beyond, up to `farthest_s` from the
/// epoch either way. Nothing if the body has no uncertainty, or lacks what a motion needs.
std::optional<std::string> worth_text(const Body& body, double farthest_s = 0.0);

/// "for ever", "not even at the epoch", "until 3.4 d after the epoch".
std::string known_text(const KnownUntil& known);

}  // namespace polhode
