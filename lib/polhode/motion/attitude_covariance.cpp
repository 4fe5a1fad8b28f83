#include "polhode/motion/attitude_covariance.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/time/duration_text.hpp"

namespace polhode {
namespace {

const Uncertainty& uncertainty_of(const Body& body) {
  if (!body.uncertainty) {
    throw InputError(
        "body '" + body.name +
        "' has no uncertainty: a covariance needs _sigma keys, a table [uncertainty] or period_uncertainty");
  }
  return *body.uncertainty;
}

/// Whether a change of the published numbers turns the principal axes in the body.
bool turns_axes(const Body& body) {
  const Matrix3& axes = body.inertia->named_from_principal;
  return std::any_of(body.uncertainty->numbers.begin(), body.uncertainty->numbers.end(),
                     [&](const PublishedNumber& number) {
                       Matrix3 tensor = axes.transpose() * number.change.tensor * axes;
                       tensor.diagonal().setZero();
                       return !tensor.isZero(0.0);
                     });
}

/// The body whose motion is differentiated: moments that products of inertia may turn are apart.
Body differentiated(const Body& body) {
  uncertainty_of(body);
  free_body(body);  // says what it lacks
  Body out = body;
  if (turns_axes(body)) out.inertia = separate_moments(*body.inertia);
  return out;
}

constexpr double kRounding_rad = 1e-12;  // displaced by less, motions show their rounding

/// The body's motion, and those that are displaced by a sigma of each part of the uncertainty.
class OneSigmaMotions {
 public:
  explicit OneSigmaMotions(const Body& body) : centre_(body) {
    const Uncertainty& uncertainty = *body.uncertainty;
    const Eigen::MatrixXd root = uncertainty.root();
    const auto parts = static_cast<std::size_t>(root.cols());
    std::vector<double> z(parts, 0.0);
    for (std::size_t part = 0; part < parts; ++part) {
      for (const double sign : {1.0, -1.0}) {
        z[part] = sign;
        try {
          displaced_.emplace_back(uncertainty.clone(root, z));
        } catch (const InputError&) {  // no body has these numbers
          impossible_ = true;
        }
      }
      z[part] = 0.0;
    }
  }

  /// By what part of itself SIGMA changes, about, by the second and third order. Of a number that is off by x sigmas
  /// the turn is a x + b x^2 + c x^3, of variance a^2 + 2 b^2 + 6 a c + 15 c^2.
  double change_of_sigma(const AttitudeCovariance& covariance, double t_s) const {
    if (impossible_) return 1.0;
    const double sigma_rad = covariance.sigma_rad(t_s);
    if (sigma_rad < kRounding_rad) return 0.0;
    const Eigen::Matrix3Xd turns = covariance.turns_at(t_s);
    const Quaternion centre = centre_.attitude(t_s).conjugate();
    double more = 0.0;
    for (std::size_t part = 0; 2 * part < displaced_.size(); ++part) {
      const Vector3 a = turns.col(static_cast<Eigen::Index>(part));
      const Vector3 up = rotation_vector(centre * displaced_[2 * part].attitude(t_s));
      const Vector3 down = rotation_vector(centre * displaced_[2 * part + 1].attitude(t_s));
      const Vector3 b = 0.5 * (up + down), c = 0.5 * (up - down) - a;
      more += 2.0 * b.squaredNorm() + 6.0 * std::abs(a.dot(c)) + 15.0 * c.squaredNorm();
    }
    return 0.5 * more / (sigma_rad * sigma_rad);
  }

 private:
  struct Named {
    FreeBody body;
    ThetaMotion motion;
    explicit Named(const Body& of) : body(free_body(of)), motion(body) {}
    Quaternion attitude(double t_s) const { return named_state(body, motion.at(t_s)).q_inertial_from_named; }
  };
  Named centre_;
  std::vector<Named> displaced_;
  bool impossible_ = false;
};

}  // namespace

double largest_variance(const Matrix3& covariance) {
  Eigen::SelfAdjointEigenSolver<Matrix3> solver;
  solver.computeDirect(covariance, Eigen::EigenvaluesOnly);
  return std::max(solver.eigenvalues()[2], 0.0);
}

void put_covariance(const Matrix3& covariance, double& sigma_rad, double* covariance_rad2) {
  sigma_rad = std::sqrt(largest_variance(covariance));
  for (int i = 0; i < 3; ++i) {
    for (int k = i; k < 3; ++k) *covariance_rad2++ = covariance(i, k);
  }
}

Vector3 rotation_vector(const Quaternion& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0, length = q.vec().norm();
  if (length == 0.0) return Vector3::Zero();
  return sign * 2.0 * std::atan2(length, sign * q.w()) / length * q.vec();
}

AttitudeCovariance::AttitudeCovariance(const Body& body) : AttitudeCovariance(body, uncertainty_of(body).covariance) {}

AttitudeCovariance::AttitudeCovariance(const Body& body, const Eigen::MatrixXd& covariance)
    : partials_(free_body(differentiated(body))), named_from_principal_(body.inertia->named_from_principal) {
  const Body apart = differentiated(body);
  Uncertainty uncertainty = *body.uncertainty;
  uncertainty.covariance = covariance;
  const auto count = static_cast<Eigen::Index>(uncertainty.numbers.size());
  Eigen::Matrix<double, 12, Eigen::Dynamic> changes(12, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PrincipalChange change = principal_change(*apart.inertia, *apart.state->omega_named_rad_s,
                                                    uncertainty.numbers[static_cast<std::size_t>(i)].change);
    changes.col(i) << change.turn_rad, change.momentum, change.moments, change.axes_turn;
  }
  const Eigen::Matrix<double, 12, Eigen::Dynamic> parts = changes * uncertainty.root();
  principal_ = parts.topRows<9>();
  axes_ = parts.bottomRows<3>();
}

Eigen::Matrix3Xd AttitudeCovariance::turns_at(double t_s) const {
  return named_from_principal_ * (partials_.at(t_s).partials.topRows<3>() * principal_ - axes_);
}

Matrix3 AttitudeCovariance::of(const TurnRows& partials) const {
  Matrix3 sum = Matrix3::Zero();
  for (Eigen::Index i = 0; i < axes_.cols(); ++i) {
    const Vector3 turn = partials * principal_.col(i) - axes_.col(i);
    sum.noalias() += turn * turn.transpose();
  }
  return named_from_principal_ * sum * named_from_principal_.transpose();
}

Matrix3 AttitudeCovariance::at(double t_s) const { return of(partials_.at(t_s).partials.topRows<3>()); }

double AttitudeCovariance::sigma_rad(double t_s) const { return std::sqrt(largest_variance(at(t_s))); }

void AttitudeCovariance::batch(const TimeArrays& times, std::span<double> sigma_rad,
                               std::span<double> covariance_rad2) const {
  check_lengths(times);
  const std::size_t count = times.high.size();
  if (sigma_rad.size() != count || covariance_rad2.size() != 6 * count) {
    throw InputError(fmt::format("{} and {} numbers for the covariances of {} times; 1 and 6 for each are wanted",
                                 sigma_rad.size(), covariance_rad2.size(), count));
  }
  constexpr std::size_t block = 256;
  std::vector<double> matrices(54 * block), q(4 * block), m(3 * block);
  for (std::size_t begin = 0; begin < count; begin += block) {
    const std::size_t here = std::min(block, count - begin);
    partials_.batch(part_of(times, begin, begin + here), StateArrays::of_structures(q.data(), m.data()),
                    {matrices.data(), 54 * here});
    for (std::size_t i = 0; i < here; ++i) {
      put_covariance(of(Eigen::Map<const TurnRows>(&matrices[54 * i])), sigma_rad[begin + i],
                     &covariance_rad2[6 * (begin + i)]);
    }
  }
}

void batch_threads(const AttitudeCovariance& covariance, const TimeArrays& times, std::span<double> sigma_rad,
                   std::span<double> covariance_rad2, unsigned thread_count) {
  check_lengths(times);
  constexpr std::size_t grain = 512;
  parallel_chunks(times.high.size(), grain, thread_count, [&](std::size_t begin, std::size_t end) {
    covariance.batch(part_of(times, begin, end), sigma_rad.subspan(begin, end - begin),
                     covariance_rad2.subspan(6 * begin, 6 * (end - begin)));
  });
}

double linear_until_s(const Body& body, const AttitudeCovariance& covariance, double farthest_s) {
  constexpr double most_change = 0.05;
  const OneSigmaMotions displaced(body);
  const auto holds = [&](double t_s) {
    return covariance.sigma_rad(t_s) < kLinearSigma_rad && displaced.change_of_sigma(covariance, t_s) < most_change;
  };
  if (!holds(0.0)) return 0.0;
  constexpr int looks = 64;  // closer together early
  double good_s = 0.0;
  for (int i = 1; i <= looks; ++i) {
    const double part = static_cast<double>(i) / looks, t_s = part * part * farthest_s;
    if (holds(t_s)) {
      good_s = t_s;
      continue;
    }
    double bad_s = t_s;
    for (int halving = 0; halving < 30; ++halving) {
      const double middle_s = 0.5 * (good_s + bad_s);
      (holds(middle_s) ? good_s : bad_s) = middle_s;
    }
    return good_s;
  }
  return farthest_s;
}

std::optional<std::string> linear_caution(const std::function<double(double farthest_s)>& until_s, double from_s,
                                          double to_s) {
  std::string where;
  for (const double end_s : {std::min(from_s, 0.0), std::max(to_s, 0.0)}) {
    if (end_s == 0.0) continue;
    const double holds_s = until_s(end_s);
    if (holds_s == end_s) continue;
    where += fmt::format("{}{} {} the epoch", where.empty() ? "" : " and ", duration_text(std::abs(holds_s)),
                         end_s < 0.0 ? "before" : "after");
  }
  if (where.empty()) return std::nullopt;
  return fmt::format(
      "the uncertainties given are the first order only, which holds up to {}; beyond, they are larger than it can "
      "describe: draw clones with `polhode sample`",
      where);
}

}  // namespace polhode
