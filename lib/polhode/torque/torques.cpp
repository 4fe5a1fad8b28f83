#include "polhode/torque/torques.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polhode/base/error.hpp"
#include "polhode/body/inertia.hpp"

namespace polhode {

namespace {

void check_positive(std::string_view what, double value) {
  if (!(value > 0.0 && std::isfinite(value))) {
    throw InputError(fmt::format("{} is {}, a positive number is wanted", what, value));
  }
}

}  // namespace

void check_finite(std::string_view what, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  for (Eigen::Index k = 0; k < values.size(); ++k) check_finite(what, values.reshaped()[k]);
}

void check_finite(std::string_view what, double value) {
  if (!std::isfinite(value)) throw InputError(fmt::format("{} is {}, a finite number is wanted", what, value));
}

void GravityGradient::check() const { check_positive("mu", mu_m3_s2); }

double GravityGradient::largest(double t_s, const Vector3& moments, double /*momentum*/) const {
  const double r = trajectory.state(t_s).position_m.norm();
  return 1.5 * mu_m3_s2 / (r * r * r) * (moments[2] - moments[0]);
}

/// The matrix times 1/I is what it takes of the momentum per second; its norm from above by those of its columns and
/// rows (exact where it is diagonal).
double LinearDamping::largest(double /*t_s*/, const Vector3& moments, double momentum) const {
  const Matrix3 sizes = (coefficients * moments.cwiseInverse().asDiagonal()).cwiseAbs();
  return std::sqrt(sizes.colwise().sum().maxCoeff() * sizes.rowwise().sum().maxCoeff()) * momentum;
}

double EddyCurrents::largest(double t_s, const Vector3& moments, double momentum) const {
  const OrbitState<double> orbit = trajectory.state(t_s);
  const double r = orbit.position_m.norm(), v = orbit.velocity_m_s.norm();
  const double field = 2.0 * dipole_t_m3 / (r * r * r);
  return magnetic_tensor_s_m4.norm() * field * field * (momentum / moments[0] + 6.0 * v / r);
}

void ThrusterPulse::check() const {
  check_finite("the start of the pulse", start_s);
  check_positive("the duration of the pulse", duration_s);
  check_finite("the torque", torque_body);
  if (!(start_s < end_s() && std::isfinite(end_s()))) {
    throw InputError(fmt::format("a pulse of {} s that starts at {} s ends at {} s, a later finite time is wanted",
                                 duration_s, start_s, end_s()));
  }
}

void EddyCurrents::check() const {
  const Matrix3& tensor = magnetic_tensor_s_m4;
  check_finite("an element of the magnetic tensor", tensor);
  if (!((tensor - tensor.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * tensor.cwiseAbs().maxCoeff())) {
    throw InputError(
        fmt::format("the magnetic tensor is not symmetric: {} and {}, {} and {}, {} and {} should be equal",
                    tensor(0, 1), tensor(1, 0), tensor(0, 2), tensor(2, 0), tensor(1, 2), tensor(2, 1)));
  }
  check_finite("the axis of the dipole", dipole_axis);
  if (!(std::abs(dipole_axis.norm() - 1.0) <= 1e-9)) {
    throw InputError(fmt::format("the axis of the dipole has the length {}, 1 is wanted", dipole_axis.norm()));
  }
  if (!(dipole_t_m3 >= 0.0 && std::isfinite(dipole_t_m3))) {
    throw InputError(fmt::format("the dipole is {} T m3, 0 or more is wanted", dipole_t_m3));
  }
}

InternalDissipation InternalDissipation::from_quality_factor(double quality_factor, const Vector3& moments,
                                                             double momentum) {
  check_positive("the quality factor", quality_factor);
  check_positive("the momentum", momentum);
  check_principal_moments(moments);
  // Near the short axis the energy above it decays at the rate 2 k G^2 (1/I - 1/I3), with 1/I the mean of the others.
  const double spread = 0.5 * (1.0 / moments[0] + 1.0 / moments[1]) - 1.0 / moments[2];
  if (!(spread > 0.0)) throw InputError("a sphere has no energy to lose at constant momentum");
  return {1.0 / (quality_factor * moments[2] * 2.0 * momentum * spread)};
}

void InternalDissipation::check() const {
  if (!(relaxation >= 0.0 && std::isfinite(relaxation))) {
    throw InputError(fmt::format("the relaxation is {}, 0 or more is wanted", relaxation));
  }
}

std::string_view torque_name(const Torque& torque) {
  return std::visit([](const auto& one) { return std::string_view(one.name); }, torque);
}

std::size_t Torques::index_of(const Trajectory& trajectory) {
  const auto known = std::find(trajectories_.begin(), trajectories_.end(), trajectory);
  const auto index = static_cast<std::size_t>(known - trajectories_.begin());
  if (known == trajectories_.end()) trajectories_.push_back(trajectory);
  return index;
}

Torques::Torques(std::vector<Torque> torques) : torques_(std::move(torques)), orbits_of_torque_(torques_.size()) {
  for (std::size_t i = 0; i < torques_.size(); ++i) {
    std::visit(
        [&](const auto& one) {
          try {
            one.check();
          } catch (const InputError& problem) {
            throw InputError(fmt::format("{}: {}", one.name, problem.what()));
          }
          const auto index = [&](const auto& trajectory) {
            if constexpr (requires { trajectory.value(); }) {
              return trajectory ? index_of(*trajectory) : kNone;
            } else {
              return index_of(trajectory);
            }
          };
          if constexpr (requires { one.trajectory; }) orbits_of_torque_[i].first = index(one.trajectory);
          if constexpr (requires { one.second_trajectory; }) orbits_of_torque_[i].second = index(one.second_trajectory);
        },
        torques_[i]);
  }
  if (trajectories_.size() > kMostTrajectories) {
    throw InputError(fmt::format("the torques have {} different trajectories, at most {} are allowed",
                                 trajectories_.size(), kMostTrajectories));
  }
}

Torques Torques::in_principal_axes(const Matrix3& named_from_principal) const {
  if (named_from_principal.isIdentity(0.0)) return *this;
  check_principal_axes(named_from_principal);
  const Matrix3 principal_from_named = named_from_principal.transpose();
  Torques turned = *this;
  for (Torque& torque : turned.torques_) {
    torque = std::visit([&](const auto& one) { return Torque(one.turned(principal_from_named)); }, torque);
  }
  return turned;
}

double Torques::time_scale_s(double t_s) const {
  double scale_s = std::numeric_limits<double>::infinity();
  for (const Trajectory& trajectory : trajectories_) {
    const OrbitState<double> orbit = trajectory.state(t_s);
    scale_s = std::min(scale_s, orbit.position_m.norm() / orbit.velocity_m_s.norm());
  }
  return scale_s;
}

bool Torques::smooth() const {
  return std::none_of(torques_.begin(), torques_.end(), [](const Torque& torque) {
    return std::visit(
        [](const auto& one) {
          if constexpr (requires { one.has_kinks(); }) {
            return one.has_kinks();
          } else {
            return false;
          }
        },
        torque);
  });
}

std::vector<double> Torques::times_of_kinks_s(double first_s, double last_s) const {
  std::vector<double> times_s;
  for (const Torque& torque : torques_) {
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { one.times_of_kinks_s(first_s, last_s); }) {
            const std::vector<double> more_s = one.times_of_kinks_s(first_s, last_s);
            times_s.insert(times_s.end(), more_s.begin(), more_s.end());
          }
        },
        torque);
  }
  std::sort(times_s.begin(), times_s.end());
  times_s.erase(std::unique(times_s.begin(), times_s.end()), times_s.end());
  return times_s;
}

double Torques::cost_of_evaluation() const {
  double cost = 1.0;
  for (const Torque& torque : torques_) {
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { one.cost_of_evaluation(); }) cost += one.cost_of_evaluation();
        },
        torque);
  }
  return cost;
}

void Torques::streams(const Surroundings<double>& surroundings, const Matrix3& inertial_from_body,
                      std::vector<TorqueStream>& streams) const {
  streams.clear();
  TorquePlace<double> place{inertial_from_body, nullptr, nullptr, surroundings.t_s};
  for (std::size_t i = 0; i < torques_.size(); ++i) {
    set_orbits(i, surroundings, place);
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { one.stream_at(place); }) {
            if (one.has_edges()) streams.push_back(one.stream_at(place));
          }
        },
        torques_[i]);
  }
}

bool Torques::has_edges() const {
  return std::any_of(torques_.begin(), torques_.end(), [](const Torque& torque) {
    return std::visit(
        [](const auto& one) {
          if constexpr (requires { one.has_edges(); }) {
            return one.has_edges();
          } else {
            return false;
          }
        },
        torque);
  });
}

Torques Torques::with_tables() const {
  Torques tabulated = *this;
  for (Torque& torque : tabulated.torques_) {
    std::visit(
        [](auto& one) {
          if constexpr (requires { one.with_table(); }) {
            if (std::isfinite(one.evaluations_for_table())) one = one.with_table();
          }
        },
        torque);
  }
  return tabulated;
}

double Torques::evaluations_for_tables() const {
  double count = std::numeric_limits<double>::infinity();
  for (const Torque& torque : torques_) {
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { one.with_table(); }) count = std::min(count, one.evaluations_for_table());
        },
        torque);
  }
  return count;
}

std::vector<double> Torques::jumps_s() const {
  std::vector<double> times_s;
  for (const Torque& torque : torques_) {
    std::visit(
        [&](const auto& one) {
          if constexpr (JumpingTorque<std::decay_t<decltype(one)>>) {
            for (const double jump_s : one.jumps_s()) times_s.push_back(jump_s);
          }
        },
        torque);
  }
  for (const Trajectory& trajectory : trajectories_) {
    if (trajectory.table() == nullptr) continue;
    const std::vector<double> seams_s = trajectory.table()->seams_s();
    times_s.insert(times_s.end(), seams_s.begin(), seams_s.end());
  }
  std::sort(times_s.begin(), times_s.end());
  times_s.erase(std::unique(times_s.begin(), times_s.end()), times_s.end());
  return times_s;
}

Torques Torques::during(double inside_s) const {
  check_finite("the time between two jumps", inside_s);
  std::vector<Torque> on;
  for (const Torque& torque : torques_) {
    std::visit(
        [&](const auto& one) {
          if constexpr (JumpingTorque<std::decay_t<decltype(one)>>) {
            if (const auto other = one.during(inside_s)) on.push_back(*other);
          } else {
            on.push_back(one);
          }
        },
        torque);
  }
  return Torques(std::move(on));
}

std::vector<TorqueStretch> stretches(const Torques& torques, double end_s) {
  std::vector<double> ends_s;
  for (const double jump_s : torques.jumps_s()) {
    if (jump_s * end_s > 0.0 && std::abs(jump_s) < std::abs(end_s)) ends_s.push_back(jump_s);
  }
  if (end_s < 0.0) std::reverse(ends_s.begin(), ends_s.end());
  ends_s.push_back(end_s);
  std::vector<TorqueStretch> all;
  double from_s = 0.0;
  for (const double to_s : ends_s) {
    all.push_back({from_s, to_s, torques.during(0.5 * (from_s + to_s))});
    from_s = to_s;
  }
  return all;
}

}  // namespace polhode
