#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "polhode/motion/extrapolation.hpp"
#include "polhode/motion/motion.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/motion/variation/window.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

namespace variation {
/// For the instruction sets that this machine has, the plainest first; to compare them.
std::vector<const Kernel*> kernels();
}  // namespace variation

/// Variation of constants around the exact free motion, for torques that are small beside the inertia forces
/// (variation.md).
///
/// Over an epoch of a few turns the motion is described by what it differs from one free motion: a rotation vector
/// and a momentum, both inertial. Without torque they obey linear equations but for terms of second order, whose six
/// solutions are the derivatives of the exact motion by its constants. The coefficients of these six change by the
/// torque and by the second order alone: slowly, so that over about a turn, a window, polynomials through 24
/// Gauss-Lobatto points hold them. Picard's iteration finds the polynomials; it takes the torque at all points once or
/// twice, and what its derivative by the attitude makes of it in between. The polynomials answer at any time of the
/// window.
class Variation {
 public:
  /// From `start` at start_s to end_s, either direction. `tolerance` is the wanted error in radians, between the points
  /// and at the end alike; unless errors grow by more than time does, what comes out is a hundredth to a third of it.
  /// `torques`, in principal axes (Torques::in_principal_axes), must not jump in between. Throws InputError for
  /// impossible moments, times that are not finite, and a tolerance that is not positive; a start that is not finite is
  /// not whole.
  Variation(const FreeBody& start, double start_s, double end_s, const Torques& torques, double tolerance,
            std::size_t max_torque_evaluations);
  /// The same, with torques in principal axes.
  Variation(const Vector3& principal_moments, const ExtendedState& start, double start_s, double end_s,
            const Torques& torques, double tolerance, std::size_t max_torque_evaluations);

  /// Whether the end was reached: not if the torque is too large for this method to be worth while, the body is at
  /// rest or a sphere, or the limit of evaluations ended it.
  bool whole() const { return whole_; }
  double reached_s() const { return windows_.empty() ? start_s_ : windows_.back().first_s + windows_.back().length_s; }
  /// State at any time between the start and reached_s().
  State at(double t_high_s, double t_low_s = 0.0) const;

  /// Torques felt, at all points of all windows, those in vain included.
  std::size_t torque_evaluations() const { return evaluations_; }
  /// Derivatives of gravity gradients by the attitude, likewise.
  std::size_t gradients() const { return gradients_; }
  /// How often the places on the trajectories of the torques were asked for.
  std::size_t surroundings_found() const { return surroundings_; }
  std::size_t windows() const { return windows_.size(); }
  /// After that part, 0 to 1, of a window.
  double time_in_window_s(std::size_t i, double part) const {
    return windows_[i].first_s + part * windows_[i].length_s;
  }

 private:
  using Coefficients = Eigen::Matrix<double, variation::kCoefficients, 1>;

  /// One free motion.
  struct Epoch {
    Epoch(double t_s, const FreeBody& start, ThetaMotion::Span span);
    double base_s;
    Vector3Of<long double> momentum;      ///< inertial
    Vector3 omega;                        ///< rate at the base, inertial
    long double mean_of_inverse_moments;  ///< twice the energy over the square of the momentum
    double growth = 1.0;                  ///< by about what errors may grow, besides in proportion to time
    double distance;                      ///< from rotation about a principal axis and from the separatrix
    ThetaMotion free;
    variation::Reference reference;
  };
  struct Window {
    double first_s, length_s;  // signed length
    std::size_t epoch;
    std::size_t values;  // the first of its own: the coefficients and the shear, each at all points
  };
  class Iteration;

  /// Where one epoch ends and the next begins, in digits that roundings, hundreds of epochs long, do not reach; the
  /// momentum inertial, as it stays.
  struct Precise {
    Eigen::Quaternion<long double> q_inertial_from_body;
    Vector3Of<long double> momentum_inertial;
  };

  /// Adds one; the coefficients of its base.
  Coefficients begin_epoch(double t_s, const Precise& state);
  /// But for the shear, for some of p.since_base_s.
  void find_places(const Epoch& epoch, int points, variation::Places& p) const;
  State state(const Epoch& epoch, const variation::Places& p, const variation::AtPoints* values, int point) const;
  /// At the end of an epoch, less what the rounding of its free motion is in energy.
  Precise end_of(const Epoch& epoch, const variation::Places& p, const variation::AtPoints* values) const;

  Torques torques_, others_;  // others: without the gravity gradients
  std::vector<Torques::Pull> pulls_;
  const variation::Kernel& kernel_;
  Vector3 moments_;
  double start_s_;
  State start_;
  ThetaMotion::Span free_span_ = ThetaMotion::Span::step;
  std::deque<Epoch> epochs_;
  std::vector<Window> windows_;
  std::vector<double> values_;  // of all windows
  bool whole_ = false;
  std::size_t evaluations_ = 0, gradients_ = 0, surroundings_ = 0;
};

}  // namespace polhode
