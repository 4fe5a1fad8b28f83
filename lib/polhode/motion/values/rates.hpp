#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "polhode/motion/value_motion.hpp"
#include "polhode/motion/values/dormand_prince.hpp"
#include "polhode/motion/values/edge_corrections.hpp"
#include "polhode/torque/trajectory_pieces.hpp"

namespace polhode {

/// What ValueMotion's steps integrate. The unknowns: angular momentum in inertial axes (3), the rest of the energy (1),
/// attitude x, y, z, w (4).
namespace values {

namespace dp = dormand_prince;
using dp::Unknowns;

/// A power of two near the largest moment: in it the numbers are near 1.
inline double unit_of(const Vector3& moments) { return std::exp2(std::floor(std::log2(moments[2]))); }

inline Eigen::Quaterniond attitude(const Unknowns& y) { return Eigen::Quaterniond(y.tail<4>().matrix()); }

}  // namespace values

struct ValueMotion::Node {
  double t_s;
  double momentum_inertial[3];
  double q[4];  // x, y, z, w
};

struct ValueMotion::Leg {
  Torques torques;
  std::vector<TrajectoryPieces> ways;  // of torques.trajectories()
  std::vector<double> kinks_s;         // within it, on the way: steps end there
  std::vector<Node> nodes;
};

/// The derivatives of the unknowns.
class ValueMotion::Rates {
 public:
  Rates(const Vector3& moments, const Leg& leg)
      : given_moments_(moments), per_unit_(1.0 / values::unit_of(moments)), moments_(moments * per_unit_), leg_(leg) {}

  values::Unknowns operator()(double t_s, const values::Unknowns& y) const {
    ++evaluations_;
    for (std::size_t i = 0; i < leg_.ways.size(); ++i) around_.orbits[i] = leg_.ways[i].state(t_s, piece_[i]);
    around_.t_s = t_s;
    const Matrix3 R = rotation(y);
    const Vector3 m = R.transpose() * y.head<3>().matrix();
    Vector3 omega = m.cwiseQuotient(moments_);
    const TorqueTerms<double> terms = leg_.torques.at(around_, R, given_moments_, omega);
    const Vector3 torque = per_unit_ * terms.torque(omega);
    double energy_rate = 2.0 * torque.dot(m.cwiseProduct(energy_weights_));
    if (terms.relaxation != 0.0) {
      const Vector3 turn = terms.relaxation / per_unit_ * m.cross(omega);
      energy_rate += 2.0 * m.cross(turn).dot(m.cwiseProduct(energy_weights_));
      omega += turn;
    }
    values::Unknowns rate;
    rate.head<3>() = R * torque;
    rate[3] = energy_rate;
    const double x = y[4], y_ = y[5], z = y[6], w = y[7];
    rate[4] = 0.5 * (w * omega[0] + y_ * omega[2] - z * omega[1]);
    rate[5] = 0.5 * (w * omega[1] + z * omega[0] - x * omega[2]);
    rate[6] = 0.5 * (w * omega[2] + x * omega[1] - y_ * omega[0]);
    rate[7] = -0.5 * (x * omega[0] + y_ * omega[1] + z * omega[2]);
    return rate;
  }

  /// Of q of any length but 0.
  static Matrix3 rotation(const values::Unknowns& u) {
    const double x = u[4], y = u[5], z = u[6], w = u[7];
    const double s = 2.0 / (x * x + y * y + z * z + w * w);
    Matrix3 R;
    R << 1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y), s * (x * y + w * z),
        1.0 - s * (x * x + z * z), s * (y * z - w * x), s * (x * z - w * y), s * (y * z + w * x),
        1.0 - s * (x * x + y * y);
    return R;
  }

  /// The unknown in the energy's place is sum of weights m_i^2: of 2 E I3 - m^2, or of m^2 - 2 E I1, whichever is
  /// small near the axis that the body turns about, so that it keeps its digits. True if they are others than before.
  bool choose_energy(const Vector3& m) {
    const double about_short = weights(true).dot(m.cwiseAbs2()), about_long = weights(false).dot(m.cwiseAbs2());
    const bool is_short = about_short < (is_short_ ? 2.0 : 0.5) * about_long;
    if (is_short == is_short_ && chosen_) return false;
    is_short_ = is_short, chosen_ = true;
    energy_weights_ = weights(is_short);
    return true;
  }
  const Vector3& energy_weights() const { return energy_weights_; }
  const Vector3& moments() const { return moments_; }
  double per_unit() const { return per_unit_; }
  std::size_t evaluations() const { return evaluations_; }

  /// The streams on facets (Torques::streams()), and what turns a torque there into the rates of the first unknowns.
  void streams(double t_s, const values::Unknowns& y, EdgeCorrections::Place& place) const {
    for (std::size_t i = 0; i < leg_.ways.size(); ++i) around_.orbits[i] = leg_.ways[i].state(t_s, piece_[i]);
    around_.t_s = t_s;
    const Matrix3 R = rotation(y);
    const Vector3 m = R.transpose() * y.head<3>().matrix();
    leg_.torques.streams(around_, R, place.streams);
    place.columns.topRows<3>() = per_unit_ * R;
    place.columns.row(3) = 2.0 * per_unit_ * m.cwiseProduct(energy_weights_).transpose();
  }

  /// As Torques::time_scale_s(), of where it was last asked for the derivatives.
  double time_scale_s() const {
    double scale_s = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < leg_.ways.size(); ++i) {
      scale_s = std::min(scale_s, around_.orbits[i].position_m.norm() / around_.orbits[i].velocity_m_s.norm());
    }
    return scale_s;
  }

 private:
  Vector3 weights(bool is_short) const {
    const Vector3& I = moments_;
    return is_short ? Vector3((I[2] - I[0]) / I[0], (I[2] - I[1]) / I[1], 0.0)
                    : Vector3(0.0, (I[1] - I[0]) / I[1], (I[2] - I[0]) / I[2]);
  }

  const Vector3& given_moments_;
  double per_unit_;
  Vector3 moments_, energy_weights_ = Vector3::Zero();
  bool is_short_ = true, chosen_ = false;
  const Leg& leg_;
  mutable Torques::Surroundings<double> around_;
  mutable std::size_t piece_[Torques::kMostTrajectories] = {};
  mutable std::size_t evaluations_ = 0;
};

}  // namespace polhode
