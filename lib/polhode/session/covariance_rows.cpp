#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/attitude_covariance.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/session/body_in_motion.hpp"
#include "polhode/time/duration_text.hpp"

namespace polhode {
namespace {

/// The covariance of a body under torques: differences of motions that start displaced by a part of one sigma of each
/// part of the uncertainty, both ways.
class DisplacedCovariance {
 public:
  explicit DisplacedCovariance(const BodyInMotion& moving) {
    if (!moving.uncertainty) throw InputError("the body has no uncertainty, and --covariance needs one");
    const Uncertainty& uncertainty = *moving.uncertainty;
    const Eigen::MatrixXd root = uncertainty.root();
    centre_ = {moving.free, moving.motion_of(moving.free, uncertainty.values(), kTolerance_rad)};
    std::vector<double> z(static_cast<std::size_t>(root.cols()), 0.0);
    for (double& part : z) {
      for (const double displacement : {kDisplacement, -kDisplacement}) {
        part = displacement;
        const Eigen::VectorXd numbers = uncertainty.values(root, z);
        const FreeBody body = free_body(uncertainty.body_with(numbers), moving.frame);
        displaced_.push_back({body, moving.motion_of(body, numbers, kTolerance_rad)});
      }
      part = 0.0;
    }
  }

  /// Of the first order; `bent`, if wanted, becomes by what part of SIGMA the second order changes it, about.
  Matrix3 at(double t_high_s, double t_low_s, double* bent = nullptr) const {
    const Quaternion centre = centre_.attitude(t_high_s, t_low_s).conjugate();
    Matrix3 covariance = Matrix3::Zero();
    double second = 0.0;
    for (std::size_t i = 0; i < displaced_.size(); i += 2) {
      const Vector3 up = rotation_vector(centre * displaced_[i].attitude(t_high_s, t_low_s));
      const Vector3 down = rotation_vector(centre * displaced_[i + 1].attitude(t_high_s, t_low_s));
      const Vector3 turn = (up - down) / (2.0 * kDisplacement);
      covariance += turn * turn.transpose();
      second += ((up + down) / (2.0 * kDisplacement * kDisplacement)).squaredNorm();
    }
    const double variance = largest_variance(covariance);
    if (bent != nullptr) *bent = variance > 0.0 ? second / variance : 0.0;
    return covariance;
  }

  double linear_until_s(double farthest_s) const {
    constexpr double most_bent = 0.05;
    constexpr int looks = 64;
    double good_s = 0.0;
    for (int i = 0; i <= looks; ++i) {
      const double part = static_cast<double>(i) / looks, t_s = part * part * farthest_s;
      double bent = 0.0;
      const double variance = largest_variance(at(t_s, 0.0, &bent));
      if (!(variance < kLinearSigma_rad * kLinearSigma_rad && bent < most_bent)) return good_s;
      good_s = t_s;
    }
    return farthest_s;
  }

 private:
  static constexpr double kDisplacement = 0.25;   // of a sigma: what is of third order is a sixteenth of it
  static constexpr double kTolerance_rad = 1e-7;  // of the motions: a part in a hundred of a sigma of 1e-5 rad

  struct Named {
    FreeBody body;
    std::shared_ptr<const Motion> motion;
    Quaternion attitude(double t_high_s, double t_low_s) const {
      return named_state(body, motion->at(t_high_s, t_low_s)).q_inertial_from_named;
    }
  };
  Named centre_;
  std::vector<Named> displaced_;
};

}  // namespace

CovarianceRows covariance_rows(const BodyInMotion& moving, double from_s, double to_s) {
  if (!moving.under_torques) {
    const auto covariance = std::make_shared<const AttitudeCovariance>(moving.body);
    return {
        [covariance](std::span<const double> high, std::span<const double> low, double* sigma_rad, double* six) {
          covariance->batch({high, low}, {sigma_rad, high.size()}, {six, 6 * high.size()});
        },
        linear_caution([&](double end_s) { return linear_until_s(moving.body, *covariance, end_s); }, from_s, to_s)};
  }
  const auto covariance = std::make_shared<const DisplacedCovariance>(moving);
  return {[covariance](std::span<const double> high, std::span<const double> low, double* sigma_rad, double* six) {
            for (std::size_t i = 0; i < high.size(); ++i) {
              put_covariance(covariance->at(high[i], low[i]), sigma_rad[i], &six[6 * i]);
            }
          },
          linear_caution([&](double end_s) { return covariance->linear_until_s(end_s); }, from_s, to_s)};
}

}  // namespace polhode
