#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/motion/attitude_covariance.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/session/body_in_motion.hpp"
#include "polhode/session/displaced_motions.hpp"
#include "polhode/time/duration_text.hpp"

namespace polhode {
namespace {

/// The covariance of a body under torques, by its displaced motions.
class DisplacedCovariance {
 public:
  explicit DisplacedCovariance(const BodyInMotion& moving) : motions_(moving) {}

  /// Of the first order; `bent`, if wanted, becomes by what part of SIGMA the second order changes it, about.
  Matrix3 at(double t_high_s, double t_low_s, double* bent = nullptr) const {
    const Quaternion centre = attitude(motions_.centre, t_high_s, t_low_s).conjugate();
    Matrix3 covariance = Matrix3::Zero();
    double second = 0.0;
    for (const auto& [one, other] : motions_.of_parts) {
      const Vector3 to_one = rotation_vector(centre * attitude(one, t_high_s, t_low_s));
      const Vector3 to_other = rotation_vector(centre * attitude(other, t_high_s, t_low_s));
      const ParabolaWeights w = parabola_weights(one, other);
      const Vector3 turn = w.first_of_one * to_one + w.first_of_other * to_other;
      covariance += turn * turn.transpose();
      const double error_rad = std::abs(w.second_of_one) * (one.error_rad + motions_.centre.error_rad) +
                               std::abs(w.second_of_other) * (other.error_rad + motions_.centre.error_rad);
      const double curved_rad = (w.second_of_one * to_one + w.second_of_other * to_other).norm() - error_rad;
      second += std::pow(std::max(0.0, curved_rad), 2);
    }
    const double variance = largest_variance(covariance);
    if (bent != nullptr) *bent = variance > 0.0 ? second / variance : 0.0;
    return covariance;
  }

  /// As linear_until_s().
  double linear_until_s(double end_s) const {
    constexpr double most_rad = 0.3, most_bent = 0.05;
    constexpr int looks = 512;
    double farthest_s = 0.0;
    for (int look = 1; look <= looks; ++look) {
      const double t_s = end_s * look / looks;
      double bent = 0.0;
      if (!(std::sqrt(largest_variance(at(t_s, 0.0, &bent))) < most_rad && bent < most_bent)) return farthest_s;
      farthest_s = t_s;
    }
    return farthest_s;
  }

  /// What the errors of the motions put into SIGMA, at most about.
  double noise_rad() const {
    double sum = 0.0;
    for (const auto& [one, other] : motions_.of_parts) {
      const ParabolaWeights w = parabola_weights(one, other);
      sum += std::pow(std::abs(w.first_of_one) * one.error_rad + std::abs(w.first_of_other) * other.error_rad +
                          std::abs(w.first_of_one + w.first_of_other) * motions_.centre.error_rad,
                      2);
    }
    return std::sqrt(sum);
  }

 private:
  static Quaternion attitude(const DisplacedMotion& of, double t_high_s, double t_low_s) {
    return named_state(of.free, of.motion->at(t_high_s, t_low_s)).q_inertial_from_named;
  }

  DisplacedMotions motions_;
};

/// Two cautions as one.
std::optional<std::string> both(const std::optional<std::string>& a, const std::optional<std::string>& b) {
  return a && b ? *a + "; " + *b : a ? a : b;
}

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
  constexpr double most_noise = 0.05;  // of SIGMA
  const double farthest_s = std::abs(from_s) > std::abs(to_s) ? from_s : to_s;
  const double farthest_sigma_rad = std::sqrt(largest_variance(covariance->at(farthest_s, 0.0)));
  std::optional<std::string> noise_caution;
  if (covariance->noise_rad() > most_noise * farthest_sigma_rad) {
    noise_caution =
        fmt::format("SIGMA and COV are differences of motions whose own errors put up to {:.1e} rad into SIGMA",
                    covariance->noise_rad());
  }
  return {[covariance](std::span<const double> high, std::span<const double> low, double* sigma_rad, double* six) {
            for (std::size_t i = 0; i < high.size(); ++i) {
              put_covariance(covariance->at(high[i], low[i]), sigma_rad[i], &six[6 * i]);
            }
          },
          both(noise_caution,
               linear_caution([&](double end_s) { return covariance->linear_until_s(end_s); }, from_s, to_s))};
}

}  // namespace polhode
