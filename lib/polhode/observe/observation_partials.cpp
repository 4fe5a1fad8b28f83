#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "polhode/base/units.hpp"
#include "polhode/observe/observer.hpp"

namespace polhode {
namespace {

/// The latitude, or the angle from an axis, at whose pole a column has no derivative; 0: none.
constexpr std::array<std::size_t, kGeometry.size()> kGuard{0,  0,  0,  4,  4,  6,  6,  8,  8,
                                                           10, 10, 12, 12, 14, 14, 16, 16, 16};

/// Where a column is looked at for its derivative by a part of the state (rad, or a part of the momentum), and the
/// derivative from the differences across the near and the far two: within 1e-13 where the column is smooth.
constexpr double kStep = 1e-3;
constexpr std::array<double, 4> kPlacesOfDerivative{kStep, -kStep, 2.0 * kStep, -2.0 * kStep};
constexpr double derivative(double across_near, double across_far) {
  return (8.0 * across_near - across_far) / (12.0 * kStep);
}

/// The derivatives of blocks of columns by the parameters of the states, by a turn of the axes, and by the scale.
class ColumnPartials {
 public:
  ColumnPartials(const Observer& observer, const StatePartialsSource& states_by)
      : observer_(observer),
        states_by_(states_by),
        parameters_(states_by.parameters.size()),
        width_(observed_parameters(states_by, observer.options()).size()) {}

  void fill(std::size_t first, std::size_t count, ObserverWork& work, std::vector<ObservedColumn>& columns) const {
    std::size_t column = 0;
    if (observer_.options().geometry) {
      geometry(first, count, work, columns);
      column = kGeometry.size();
    }
    if (observer_.options().photometry) {
      photometry(first, count, work, columns[column].values, columns[column + 1].values);
    }
  }

 private:
  /// d(theta, m)/d(parameters) at the emissions of a block, in principal axes: 6 rows for each.
  std::vector<double> state_partials(std::size_t count, const ObserverWork& work) const {
    std::vector<double> matrices(6 * parameters_ * count);
    states_by_.batch({{work.high, count}, {work.low, count}}, matrices);
    const Matrix3 principal_from_named = observer_.named_from_principal().transpose();
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>> matrix(
          &matrices[6 * parameters_ * i], 6, static_cast<Eigen::Index>(parameters_));
      for (const int row : {0, 3})
        matrix.middleRows<3>(row) = (principal_from_named * matrix.middleRows<3>(row)).eval();
    }
    return matrices;
  }

  /// The states of a block, displaced by a part of a turn about a principal axis, or of the momentum along one.
  static void displace(std::size_t count, const ObserverWork& from, int component, double part, ObserverWork& to) {
    for (std::size_t i = 0; i < count; ++i) {
      Quaternion q(from.q[0][i], from.q[1][i], from.q[2][i], from.q[3][i]);
      Vector3 m(from.m[0][i], from.m[1][i], from.m[2][i]);
      if (component < 3) {
        q = q * Quaternion(Eigen::AngleAxisd(part, Vector3::Unit(component)));
      } else {
        m[component - 3] += part * m.norm();
      }
      to.q[0][i] = q.w(), to.q[1][i] = q.x(), to.q[2][i] = q.y(), to.q[3][i] = q.z();
      for (Eigen::Index k = 0; k < 3; ++k) to.m[static_cast<std::size_t>(k)][i] = m[k];
    }
    to.sights = from.sights;
  }

  void geometry(std::size_t first, std::size_t count, ObserverWork& work, std::vector<ObservedColumn>& columns) const {
    observer_.states(first, count, 0.0, work);
    const std::vector<double> matrices = state_partials(count, work);
    ObserverWork displaced;
    std::vector<double> values(kPlacesOfDerivative.size() * kGeometry.size() * kObserverBlock);
    for (int component = 0; component < 6; ++component) {
      const auto value = [&](std::size_t place, std::size_t column) -> double* {
        return &values[(place * kGeometry.size() + column) * kObserverBlock];
      };
      for (std::size_t place = 0; place < kPlacesOfDerivative.size(); ++place) {
        displace(count, work, component, kPlacesOfDerivative[place], displaced);
        std::array<double*, kGeometry.size()> to{};
        for (std::size_t column = 0; column < to.size(); ++column) to[column] = value(place, column);
        observer_.geometry(count, displaced, to);
      }
      for (std::size_t column = 0; column < kGeometry.size(); ++column) {
        const bool is_angle = kGeometry[column].ends_with("_deg");
        for (std::size_t i = 0; i < count; ++i) {
          const auto across = [&](std::size_t one, std::size_t other) {
            const double difference = value(one, column)[i] - value(other, column)[i];
            return is_angle ? std::remainder(difference, 360.0) : difference;
          };
          const double size = component < 3 ? 1.0 : momentum(work, i);
          const double slope = size > 0.0 ? derivative(across(0, 1), across(2, 3)) / size : 0.0;
          for (std::size_t p = 0; p < parameters_; ++p) {
            columns[column].values[(first + i) * width_ + p] +=
                slope * matrices[(6 * i + static_cast<std::size_t>(component)) * parameters_ + p];
          }
          if (component < 3 && kGeometry[column].starts_with("sub_")) {
            put_by_axes(component, slope, &columns[column].values[(first + i) * width_ + parameters_]);
          }
        }
      }
    }
  }

  void photometry(std::size_t first, std::size_t count, ObserverWork& work, std::vector<double>& magnitude,
                  std::vector<double>& area_m2) const {
    std::vector<double> light(count), by_light(count * width_);
    ObserverWork displaced;
    for (std::size_t moment = 0; moment < observer_.moments().offsets_s.size(); ++moment) {
      observer_.states(first, count, observer_.moments().offsets_s[moment], work);
      const std::vector<double> matrices = state_partials(count, work);
      observer_.shine(count, work);
      for (std::size_t i = 0; i < count; ++i) {
        light[i] +=
            observer_.moments().weights[moment] * observer_.light_of_brightness(work.sights[i]) * work.brightness[i];
        area_m2[(first + i + 1) * width_ - 1] +=
            2.0 * observer_.moments().weights[moment] * work.area[i];  // by the scale
      }
      for (int component = 0; component < 3; ++component) {  // of the momentum nothing depends
        std::array<std::array<double, kObserverBlock>, 2> bright{},
            area{};  // differences over the near and the far two places
        for (std::size_t place = 0; place < kPlacesOfDerivative.size(); ++place) {
          displace(count, work, component, kPlacesOfDerivative[place], displaced);
          observer_.shine(count, displaced);
          const double sign = place % 2 == 0 ? 1.0 : -1.0;
          for (std::size_t i = 0; i < count; ++i) {
            bright[place / 2][i] += sign * displaced.brightness[i];
            area[place / 2][i] += sign * displaced.area[i];
          }
        }
        for (std::size_t i = 0; i < count; ++i) {
          const double weight = observer_.moments().weights[moment];
          const double by_turn =
              weight * observer_.light_of_brightness(work.sights[i]) * derivative(bright[0][i], bright[1][i]);
          const double area_by_turn = weight * derivative(area[0][i], area[1][i]);
          for (std::size_t p = 0; p < parameters_; ++p) {
            const double turned = matrices[(6 * i + static_cast<std::size_t>(component)) * parameters_ + p];
            by_light[i * width_ + p] += by_turn * turned;
            area_m2[(first + i) * width_ + p] += area_by_turn * turned;
          }
          put_by_axes(component, by_turn, &by_light[i * width_ + parameters_]);
          put_by_axes(component, area_by_turn, &area_m2[(first + i) * width_ + parameters_]);
        }
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t p = 0; p < width_; ++p) {
        magnitude[(first + i) * width_ + p] = -2.5 / std::numbers::ln10 * by_light[i * width_ + p] / light[i];
      }
    }
  }

  /// Adds what a turn of the principal axes in the body does, seen from which it is one of the attitude backwards.
  void put_by_axes(int component, double by_turn, double* to) const {
    for (int named = 0; named < 3; ++named) to[named] -= by_turn * observer_.named_from_principal()(named, component);
  }

  static double momentum(const ObserverWork& work, std::size_t i) {
    return Vector3(work.m[0][i], work.m[1][i], work.m[2][i]).norm();
  }

  const Observer& observer_;
  const StatePartialsSource& states_by_;
  std::size_t parameters_, width_;
};

}  // namespace

bool has_derivative(std::span<const ObservedColumn> columns, std::size_t column, std::size_t row) {
  if (!std::isfinite(columns[column].values[row])) return false;
  if (columns.size() < kGeometry.size() || column >= kGeometry.size() || kGuard[column] == 0) return true;
  const std::size_t guard = kGuard[column];
  const double angle = columns[guard].values[row], from_equator = std::abs(angle);
  const bool is_latitude = kGeometry[guard].ends_with("_lat_deg") || kGeometry[guard].ends_with("_dec_deg");
  return (is_latitude ? 90.0 - from_equator : std::min(angle, 180.0 - angle)) * degree > 2.0 * kStep;
}

std::vector<std::string> observed_parameters(const StatePartialsSource& states_by, const ObservationOptions& options) {
  std::vector<std::string> names = states_by.parameters;
  names.insert(names.end(), {"axes_x", "axes_y", "axes_z"});
  if (options.photometry) names.emplace_back("scale");
  return names;
}

std::vector<ObservedColumn> observe_partials(const ObservedMotion& body, std::span<const Instant> receptions,
                                             const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                             const ObservationOptions& options, const StatePartialsSource& states_by) {
  const std::vector<ObservedColumn> values = observe(body, receptions, sight_of, options);
  const std::size_t width = observed_parameters(states_by, options).size();
  const Observer observer(body, receptions, sight_of, options);
  const ColumnPartials of_block(observer, states_by);
  std::vector<ObservedColumn> partials =
      filled_columns(observer, width, [&](std::size_t first, std::size_t count, ObserverWork& work, auto& columns) {
        of_block.fill(first, count, work, columns);
      });
  for (std::size_t column = 0; column < partials.size(); ++column) {
    for (std::size_t row = 0; row < receptions.size(); ++row) {
      if (has_derivative(values, column, row)) continue;
      std::fill_n(&partials[column].values[row * width], width, std::numeric_limits<double>::quiet_NaN());
    }
  }
  return partials;
}

}  // namespace polhode
