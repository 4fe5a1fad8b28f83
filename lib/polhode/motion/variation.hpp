#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "polhode/motion/motion.hpp"
#include "polhode/motion/theta.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

namespace variation {
struct Places;
}

/// Variation of constants around the exact free motion, for torques that are small beside the inertia forces
/// (variation.md).
///
/// Over an epoch of a turn or two the motion is described by what it differs from one free motion: a rotation vector
/// and a momentum, both inertial. Without torque they obey linear equations but for terms of second order, whose six
/// solutions are the derivatives of the exact motion by its constants. The coefficients of these six change by the
/// torque and by the second order alone: slowly, so that over about a turn, a window, polynomials of degree 24 hold
/// them. Picard's iteration on Chebyshev points finds the polynomials; a sweep costs one torque evaluation per point
/// and gains a factor of the size of the torque. The polynomials answer at any time of the window.
class Variation {
 public:
  static constexpr int kDegree = 24;           ///< of the polynomials
  static constexpr int kPoints = kDegree + 4;  ///< of a window, and a few more, to make a whole number of registers

  /// From `start` at start_s to end_s, either direction. `tolerance` is the wanted error of the six coefficients at the
  /// end, in radians, or relative to the momentum; a window may take the root of its part of the span, since errors of
  /// windows hardly add up. `torques` must not jump in between.
  Variation(const FreeBody& start, double start_s, double end_s, const Torques& torques, double tolerance,
            std::size_t max_torque_evaluations);

  /// Whether the end was reached: not if the torque is too large for this method to be worth while, the body is at
  /// rest, or the limit of evaluations ended it.
  bool whole() const { return whole_; }
  double reached_s() const { return windows_.empty() ? start_s_ : windows_.back().first_s + windows_.back().length_s; }
  /// State at any time between the start and reached_s().
  FreeState at(double t_high_s, double t_low_s = 0.0) const;

  std::size_t torque_evaluations() const { return evaluations_; }
  std::size_t windows() const { return windows_.size(); }
  /// After that part, 0 to 1, of a window.
  double time_in_window_s(std::size_t i, double part) const {
    return windows_[i].first_s + part * windows_[i].length_s;
  }

 private:
  /// Momentum deviation (3, inertial), and the coefficients of the unit vector along the momentum and of
  /// Places::by_first, by_second.
  using Coefficients = Eigen::Matrix<double, 6, 1>;
  /// Coefficient by point of a window, in order of time.
  using Values = Eigen::Matrix<double, 6, kPoints, Eigen::RowMajor>;

  /// One free motion, and neighbours that give its derivatives by the initial attitude.
  struct Epoch {
    Epoch(double t_s, const Vector3& moments, const Quaternion& q_inertial_from_body, const Vector3& momentum_inertial,
          double difference_rad);
    using Neighbours = std::array<ThetaMotion, 6>;
    double base_s;
    Vector3 momentum;  ///< inertial
    double magnitude;  ///< of the momentum
    Vector3 along;     ///< unit vector of the momentum
    Vector3 omega;     ///< rate at the base, inertial
    double across_rad_s;
    Vector3 first, second;  ///< unit vectors across the momentum; the rate has no part along `second`
    ThetaMotion free;
    Neighbours about_second;                        ///< turned at the base about `second`
    std::unique_ptr<const Neighbours> about_first;  ///< only where the rate is parallel to the momentum
  };
  struct Window {
    double first_s, length_s;  // signed length
    std::size_t epoch;
    Values coefficients;
  };

  /// For the first `count` of places.since_base_s.
  void find_places(const Epoch& epoch, int count, variation::Places& places) const;
  FreeState state(const Epoch& epoch, const variation::Places& places, int i, const Coefficients& y) const;
  /// The torque at one point; counts.
  void feel(const Epoch& epoch, const variation::Places& places, int i, const Coefficients& y,
            const Torques::Surroundings<double>& surroundings, Vector3& torque, Vector3& relaxation);

  Torques torques_;
  Vector3 moments_, inverse_moments_;
  double start_s_;
  FreeState start_;
  double difference_rad_;  // by which neighbours are turned
  std::deque<Epoch> epochs_;
  std::vector<Window> windows_;
  bool whole_ = false;
  std::size_t evaluations_ = 0;
};

}  // namespace polhode
