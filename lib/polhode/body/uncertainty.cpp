#include "polhode/body/uncertainty.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/body/body.hpp"

namespace polhode {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

constexpr const char* kPeriodUncertainty = "period_uncertainty";

/// What a body with an uncertainty has besides.
struct Known {
  const Uncertainty& uncertainty;
  const Inertia& inertia;
  const Vector3& omega_named_rad_s;
};

Known known_of(const Body& body) {
  if (!body.uncertainty) throw InputError("body '" + body.name + "' has no uncertainty: its numbers count as exact");
  if (!body.inertia || !body.state || !body.state->omega_named_rad_s) {
    throw InputError("body '" + body.name + "' has no inertia, or no angular velocity: its uncertainty needs both");
  }
  return {*body.uncertainty, *body.inertia, *body.state->omega_named_rad_s};
}

}  // namespace

Eigen::VectorXd Uncertainty::values() const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) out[static_cast<Eigen::Index>(i)] = numbers[i].value;
  return out;
}

double Uncertainty::sigma(std::size_t number) const {
  const auto i = static_cast<Eigen::Index>(number);
  return std::sqrt(covariance(i, i));
}

void Uncertainty::check() const {
  const auto n = static_cast<Eigen::Index>(numbers.size());
  if (n == 0) throw InputError("the uncertainty is that of no number");
  if (covariance.rows() != n || covariance.cols() != n) {
    throw InputError(fmt::format("the covariance has {} rows of {}; {} of {} are wanted, for as many parameters",
                                 covariance.rows(), covariance.cols(), n, n));
  }
  if (!covariance.allFinite()) throw InputError("the covariance holds a number that is not finite");
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::string& name = numbers[static_cast<std::size_t>(i)].name;
    if (covariance(i, i) < 0.0) {
      throw InputError(fmt::format("the variance of {} is {}; 0 or more is wanted", name, covariance(i, i)));
    }
    for (Eigen::Index k = 0; k < i; ++k) {
      const double size = std::sqrt(covariance(i, i)) * std::sqrt(covariance(k, k));
      const auto between = [&] { return fmt::format("{} and {}", numbers[static_cast<std::size_t>(k)].name, name); };
      if (!(std::abs(covariance(i, k) - covariance(k, i)) <= 1e-9 * size)) {
        throw InputError(fmt::format("the covariance is not symmetric: of {} it holds {} and {}", between(),
                                     covariance(k, i), covariance(i, k)));
      }
      if (!(std::abs(covariance(i, k)) <= (1.0 + 1e-9) * size)) {
        throw InputError(fmt::format("the covariance of {} is {:.6g}, more than their sigmas allow: {:.6g}", between(),
                                     covariance(i, k), size));
      }
    }
  }
  root();
}

Eigen::MatrixXd Uncertainty::root() const {
  // Of the correlations: units of very different size must not drown one another.
  const Eigen::VectorXd sigmas = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = sigmas.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  if (solver.info() != Eigen::Success) throw InputError("the covariance has no eigenvalues that could be found");
  const Eigen::VectorXd& values = solver.eigenvalues();
  if (values[0] < -1e-9 * values[values.size() - 1]) {
    throw InputError(fmt::format(
        "the covariance is not positive semidefinite: its correlations have the eigenvalue {:.3g}", values[0]));
  }
  return sigmas.asDiagonal() * solver.eigenvectors() * values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

Eigen::VectorXd Uncertainty::values(const Eigen::MatrixXd& root, std::span<const double> z) const {
  if (root.cols() != static_cast<Eigen::Index>(z.size())) {
    throw InputError(fmt::format("{} random numbers for a clone, {} are wanted", z.size(), root.cols()));
  }
  return values() + root * Eigen::Map<const Eigen::VectorXd>(z.data(), root.cols());
}

Body Uncertainty::clone(const Eigen::MatrixXd& root, std::span<const double> z) const {
  return body_with(values(root, z));
}

Eigen::MatrixXd independent(std::span<const double> sigmas) {
  return Eigen::Map<const Eigen::VectorXd>(sigmas.data(), static_cast<Eigen::Index>(sigmas.size()))
      .cwiseAbs2()
      .asDiagonal();
}

Eigen::MatrixXd known_better(const Uncertainty& uncertainty, std::size_t number, double factor) {
  const Eigen::VectorXd with = uncertainty.covariance.col(static_cast<Eigen::Index>(number));
  const double variance = with[static_cast<Eigen::Index>(number)];
  if (variance == 0.0) return uncertainty.covariance;
  return uncertainty.covariance - (1.0 - factor * factor) / variance * with * with.transpose();
}

void set_period_uncertainty(Body& body, double part) {
  if (!(part > 0.0 && std::isfinite(part))) {
    throw InputError(
        fmt::format("found {}; the uncertainty of the periods is a part of themselves, a positive number", part));
  }
  Uncertainty with = body.uncertainty ? *body.uncertainty : Uncertainty{};
  const auto n = static_cast<Eigen::Index>(with.numbers.size());
  if (n > 0 && with.numbers.back().name == kPeriodUncertainty) {
    with.covariance(n - 1, n - 1) = part * part;
    body.uncertainty = std::make_shared<const Uncertainty>(std::move(with));
    return;
  }
  for (const PublishedNumber& number : with.numbers) {
    const bool of_rate =
        number.name.starts_with("components") || number.name.starts_with("P_") || number.name == "period";
    if (of_rate) {
      throw InputError(fmt::format("cannot stand beside an uncertainty of {}; one of them is enough", number.name));
    }
  }
  PublishedNumber number{kPeriodUncertainty, 0.0, {}};
  if (body.state && body.state->omega_named_rad_s) number.change.omega_rad_s = -*body.state->omega_named_rad_s;
  with.numbers.push_back(std::move(number));
  with.covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(n + 1, n + 1));
  with.covariance(n, n) = part * part;
  Body exact = body;
  exact.uncertainty.reset();
  const auto of_others = with.body_with;
  with.body_with = [exact = std::move(exact), of_others, n](const Eigen::VectorXd& values) {
    if (!(values.size() == n + 1 && 1.0 + values[n] > 0.0)) {
      throw InputError("the last value is by which part the periods are longer: more than -1 is wanted");
    }
    Body clone = of_others ? of_others(values.head(n)) : exact;
    if (clone.state && clone.state->omega_named_rad_s) *clone.state->omega_named_rad_s /= 1.0 + values[n];
    return clone;
  };
  body.uncertainty = std::make_shared<const Uncertainty>(std::move(with));
}

std::optional<double> period_uncertainty(const Body& body) {
  if (!body.uncertainty || body.uncertainty->numbers.back().name != kPeriodUncertainty) return std::nullopt;
  return body.uncertainty->sigma(body.uncertainty->numbers.size() - 1);
}

Inertia separate_moments(const Inertia& inertia) {
  Inertia apart = inertia;
  Vector3& moments = apart.principal_moments;
  const double least = kLeastSeparation * moments[2];
  moments[1] = std::max(moments[1], moments[0] + least);
  moments[2] = std::max(moments[2], moments[1] + least);
  return apart;
}

PrincipalChange principal_change(const Inertia& inertia, const Vector3& omega_named_rad_s, const EpochChange& change) {
  const Vector3& moments = inertia.principal_moments;
  const Matrix3 to_principal = inertia.named_from_principal.transpose();
  const Matrix3 tensor = to_principal * change.tensor * to_principal.transpose();
  PrincipalChange out;
  out.moments = tensor.diagonal();
  for (int k = 0; k < 3; ++k) {
    // First order of the eigenvectors: exp(axes_turn) takes axis i towards axis j by tensor(i, j) / (I_i - I_j).
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double product = tensor(i, j), apart = moments[i] - moments[j];
    if (product != 0.0 && !(std::abs(apart) >= 0.5 * kLeastSeparation * moments[2])) {
      throw ComputationError("a product of inertia is uncertain about axes of equal moments");
    }
    out.axes_turn[k] = product == 0.0 ? 0.0 : product / apart;
  }
  const Vector3 omega = to_principal * omega_named_rad_s;
  out.turn_rad = to_principal * change.turn_rad + out.axes_turn;
  out.momentum = moments.cwiseProduct(to_principal * change.omega_rad_s) + tensor * omega -
                 out.axes_turn.cross(moments.cwiseProduct(omega));
  return out;
}

EpochChange epoch_change(const Inertia& inertia, const Vector3& omega_named_rad_s, const Vector3& turn_rad,
                         const Vector3& momentum, const Matrix3& tensor) {
  EpochChange out;
  out.tensor = tensor;
  const PrincipalChange of_tensor = principal_change(inertia, Vector3::Zero(), out);
  const Matrix3& named_from_principal = inertia.named_from_principal;
  const Vector3 omega = named_from_principal.transpose() * omega_named_rad_s;
  out.turn_rad = named_from_principal * (turn_rad - of_tensor.axes_turn);
  out.omega_rad_s = named_from_principal *
                    ((momentum - of_tensor.moments.cwiseProduct(omega)).cwiseQuotient(inertia.principal_moments) +
                     of_tensor.axes_turn.cross(omega));
  return out;
}

Eigen::Matrix<double, 12, 12> epoch_covariance_with_axes(const Body& body) {
  const Known known = known_of(body);
  const Inertia inertia = separate_moments(known.inertia);
  const Matrix3& named_from_principal = inertia.named_from_principal;
  Eigen::Matrix<double, 12, Eigen::Dynamic> partials(12, static_cast<Eigen::Index>(known.uncertainty.numbers.size()));
  for (Eigen::Index i = 0; i < partials.cols(); ++i) {
    const PrincipalChange change = principal_change(inertia, known.omega_named_rad_s,
                                                    known.uncertainty.numbers[static_cast<std::size_t>(i)].change);
    partials.col(i) << named_from_principal * change.turn_rad, named_from_principal * change.momentum, change.moments,
        named_from_principal * change.axes_turn;
  }
  return partials * known.uncertainty.covariance * partials.transpose();
}

Matrix9 epoch_covariance(const Body& body) { return epoch_covariance_with_axes(body).topLeftCorner<9, 9>(); }

double energy_sigma(const Body& body) {
  const Known known = known_of(body);
  const Matrix3 tensor = inertia_tensor(known.inertia);
  const Vector3& omega = known.omega_named_rad_s;
  const Vector3 momentum = tensor * omega, short_axis = known.inertia.named_from_principal.col(2);
  if (momentum.isZero(0.0)) throw InputError("body '" + body.name + "' is at rest: it has no E/E0");
  Eigen::VectorXd relative(static_cast<Eigen::Index>(known.uncertainty.numbers.size()));
  for (Eigen::Index i = 0; i < relative.size(); ++i) {
    const EpochChange& change = known.uncertainty.numbers[static_cast<std::size_t>(i)].change;
    const Vector3 of_momentum = tensor * change.omega_rad_s + change.tensor * omega;
    relative[i] = (momentum.dot(change.omega_rad_s) + omega.dot(of_momentum)) / momentum.dot(omega) +
                  short_axis.dot(change.tensor * short_axis) / known.inertia.principal_moments[2] -
                  2.0 * momentum.dot(of_momentum) / momentum.squaredNorm();
  }
  const double energy = momentum.dot(omega) * known.inertia.principal_moments[2] / momentum.squaredNorm();
  return energy * std::sqrt(relative.dot(known.uncertainty.covariance * relative));
}

}  // namespace polhode
