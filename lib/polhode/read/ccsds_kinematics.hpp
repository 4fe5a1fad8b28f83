#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/body/body.hpp"
#include "polhode/body/euler.hpp"

namespace polhode {

/// How a message writes an attitude and its rate: between which frames they lead, and what their numbers are.
struct CcsdsKinematics {
  enum class Attitude {
    quaternion,    ///< Q1, Q2, Q3, QC
    euler_angles,  ///< deg
    matrix,        ///< of B from A, column by column (504.0-B-2 annex B4)
    spin,          ///< right ascension and declination of the axis, spin angle and its rate, deg; has a rate itself
  };
  enum class Rate {
    none,
    unused,                     ///< three numbers that say nothing about the rate
    quaternion,                 ///< derivatives of Q1, Q2, Q3, QC, 1/s
    euler_angles,               ///< their derivatives, deg/s
    angular_velocity_in_start,  ///< of the frame `end` relative to `start`, components in `start`, deg/s
    angular_velocity_in_end,    ///< the same with components in `end`
    nutation,                   ///< of spin: angle, period and phase, deg and s
    momentum,                   ///< of spin: its direction, deg, and the rate about it, deg/s
  };

  std::string start, end;  ///< frames, in the direction of the rotation
  Attitude attitude = Attitude::quaternion;
  Rate rate = Rate::none;
  std::optional<EulerSequence> axes;             ///< where angles or their rates are given
  std::function<void(const std::string&)> tell;  ///< of what is doubtful; may be empty

  std::size_t attitude_numbers() const;
  std::size_t rate_numbers() const;

  /// The attitude and rate of these numbers, those of the rate last, turned round if need be, so that the body's axes
  /// are those that move. `block` is where they stand in the message. Throws InputError.
  StatedAttitude stated(std::span<const double> numbers, std::string_view block, const SourceLocation& where) const;

  /// The same of an attitude that is known already, and the numbers of the rate.
  StatedAttitude stated(const Quaternion& q_start_from_end, std::span<const double> rate_numbers,
                        std::string_view block, const SourceLocation& where) const;

 private:
  StatedAttitude stated(const Quaternion& q_start_from_end, const std::optional<Vector3>& omega_end_rad_s,
                        std::string_view block, const SourceLocation& where) const;
};

}  // namespace polhode
