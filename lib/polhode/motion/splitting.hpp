#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "polhode/motion/motion.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// A symmetric composition of exact free motion (A) and torque at fixed time and attitude (B, a kick): over a step h
///
///     A(a1 h) B(b1 h) A(a2 h) … B(bs h) A(a(s+1) h),     a and b the same from both ends
///
/// With torques that are small, of size eps beside the free motion, the error of a step is a sum of powers of h and
/// eps; "(10,6,4)" has h^11 eps + h^7 eps^2 + h^5 eps^3.
struct SplittingScheme {
  std::string_view name;
  std::string_view order;
  std::string_view source;
  std::size_t kicks;          ///< s, torque evaluations per step
  std::span<const double> a;  ///< the first half, the middle one included where s is even
  std::span<const double> b;  ///< the first half, the middle one included where s is odd

  double drift(std::size_t i) const { return a[i < a.size() ? i : kicks - i]; }     ///< i from 0 to s
  double kick(std::size_t i) const { return b[i < b.size() ? i : kicks - 1 - i]; }  ///< i from 0 to s - 1
};

/// The simplest scheme, and the best one for small torques: those that KickedMotion needs.
/// `rivals/splitting_schemes.hpp` of the source tree has more, to compare with.
extern const SplittingScheme kStrang, kNear1064;

/// B(length_s): the torque (in principal axes) at time t_s, at the attitude that the body has, for so long. Changes the
/// momentum (and, under internal dissipation, the attitude); returns what it has added to the momentum in inertial
/// axes. Nothing is checked: numbers that are not finite make others.
Vector3 apply_kick(FreeBody& body, double t_s, double length_s, const Torques& torques);

/// A run of steps from one state, forward or backward.
class SplittingRun {
 public:
  /// `torques`, in the axes of start.named_from_principal, must not jump during the run (Torques::during). Throws
  /// InputError for what checked() refuses, and for a time that is not finite. What `scheme` views must outlive the
  /// run.
  SplittingRun(const FreeBody& start, double start_s, const Torques& torques, const SplittingScheme& scheme)
      : torques_(torques.in_principal_axes(start.named_from_principal)),
        scheme_(scheme),
        body_(checked(start)),
        momentum_inertial_(start.q_inertial_from_body.normalized() * start.momentum_body),
        t_s_(start_s) {
    check_finite("the start of the run", start_s);
  }

  /// One step, which ends at t_s() + length_s. Nothing is checked: where a torque is not finite, the state is NaN.
  void step(double length_s);

  double t_s() const { return t_s_; }
  State state() const;
  std::size_t torque_evaluations() const { return evaluations_; }

 private:
  void kick(double t_s, double length_s);

  Torques torques_;
  SplittingScheme scheme_;
  FreeBody body_;  // after the last kick (or at the start)
  // Free motion keeps the momentum in space: carried here, with what its sums have rounded away, it does not feel the
  // rounding of the drifts.
  Vector3 momentum_inertial_, momentum_rounded_ = Vector3::Zero();
  std::optional<ThetaMotion> free_;  // the motion from there
  double since_kick_s_ = 0.0;        // how long the free motion has gone on
  double t_s_;
  std::size_t evaluations_ = 0;
};

}  // namespace polhode
