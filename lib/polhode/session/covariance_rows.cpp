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
/// part of the uncertainty, both ways; one way where no body, or no torque, lies on the other side.
class DisplacedCovariance {
 public:
  explicit DisplacedCovariance(const BodyInMotion& moving) {
    if (!moving.uncertainty) throw InputError("the body has no uncertainty, and --covariance needs one");
    const Uncertainty& uncertainty = *moving.uncertainty;
    const Eigen::MatrixXd root = uncertainty.root();
    // Facets that come into the light make kinks, which may keep motions from the finer tolerances.
    double tolerance_rad = 0.0;
    for (const double finer_rad : {kTolerance_rad, 1e2 * kTolerance_rad, kAsPlanned_rad}) {
      try {
        tolerance_rad = finer_rad;
        centre_ = displaced(moving, moving.free, uncertainty.values(), tolerance_rad, 0.0);
        break;
      } catch (const ComputationError&) {
        if (finer_rad == kAsPlanned_rad) throw;
      }
    }
    std::vector<double> z(static_cast<std::size_t>(root.cols()), 0.0);
    for (double& part : z) {
      std::vector<Displaced> sides;
      std::string why;
      for (const double displacement : {kDisplacement, -kDisplacement}) {
        part = displacement;
        try {
          const Eigen::VectorXd numbers = uncertainty.values(root, z);
          const FreeBody body = free_body(uncertainty.body_with(numbers), moving.frame);
          sides.push_back(displaced(moving, body, numbers, tolerance_rad, displacement));
        } catch (const InputError& error) {
          why = error.what();
        }
      }
      part = 0.0;
      if (sides.empty()) {
        throw InputError(
            fmt::format("a quarter of a sigma to either side of what is given there is no such scene ({}): "
                        "draw clones with `polhode sample`",
                        why));
      }
      if (sides.size() == 1) sides.push_back(centre_);
      const double apart = sides[0].displacement - sides[1].displacement;
      noise_rad_ = std::hypot(noise_rad_, (sides[0].error_rad + sides[1].error_rad) / apart);
      displaced_.push_back({std::move(sides[0]), std::move(sides[1])});
    }
  }

  /// Of the first order; `bent`, if wanted, becomes by what part of SIGMA the second order changes it, about.
  Matrix3 at(double t_high_s, double t_low_s, double* bent = nullptr) const {
    const Quaternion centre = centre_.attitude(t_high_s, t_low_s).conjugate();
    Matrix3 covariance = Matrix3::Zero();
    double second = 0.0;
    for (const auto& [a, b] : displaced_) {
      const Vector3 up = rotation_vector(centre * a.attitude(t_high_s, t_low_s));
      const Vector3 down = rotation_vector(centre * b.attitude(t_high_s, t_low_s));
      const Vector3 turn = (up - down) / (a.displacement - b.displacement);
      covariance += turn * turn.transpose();
      if (b.displacement == 0.0) continue;  // nothing is known of the second order
      const double error_rad = a.error_rad + b.error_rad + 2.0 * centre_.error_rad;
      const double curved_rad = std::max(0.0, (up + down).norm() - error_rad);
      second += std::pow(curved_rad / (2.0 * kDisplacement * kDisplacement), 2);
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

  /// What the errors of the motions put into SIGMA, at most about.
  double noise_rad() const { return noise_rad_; }

 private:
  static constexpr double kDisplacement = 0.25;   // of a sigma: what is of third order is a sixteenth of it
  static constexpr double kTolerance_rad = 1e-7;  // of the motions: a part in a hundred of a sigma of 1e-5 rad

  struct Displaced {
    FreeBody body;
    std::shared_ptr<const Motion> motion;
    double error_rad = 0.0;
    double displacement = 0.0;  // sigmas
    Quaternion attitude(double t_high_s, double t_low_s) const {
      return named_state(body, motion->at(t_high_s, t_low_s)).q_inertial_from_named;
    }
  };
  static Displaced displaced(const BodyInMotion& moving, const FreeBody& body, const Eigen::VectorXd& numbers,
                             double tolerance_rad, double displacement) {
    PlannedMotion planned = moving.motion_of(body, numbers, tolerance_rad);
    return {body, std::move(planned.motion), planned.account.max_error_rad.value_or(0.0), displacement};
  }

  Displaced centre_;
  std::vector<std::pair<Displaced, Displaced>> displaced_;
  double noise_rad_ = 0.0;
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
