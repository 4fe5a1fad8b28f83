#include "polhode/observe/observation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/base/units.hpp"
#include "polhode/observe/aspect.hpp"

namespace polhode {
namespace {

constexpr std::array<std::string_view, 18> kGeometry{"light_time_s",
                                                     "range_m",
                                                     "phase_deg",
                                                     "sub_observer_lon_deg",
                                                     "sub_observer_lat_deg",
                                                     "sub_solar_lon_deg",
                                                     "sub_solar_lat_deg",
                                                     "momentum_ra_deg",
                                                     "momentum_dec_deg",
                                                     "momentum_pa_deg",
                                                     "momentum_aspect_deg",
                                                     "long_axis_ra_deg",
                                                     "long_axis_dec_deg",
                                                     "long_axis_pa_deg",
                                                     "long_axis_aspect_deg",
                                                     "phi_deg",
                                                     "theta_deg",
                                                     "psi_deg"};
/// The latitude, or the angle from an axis, at whose pole a column has no derivative; 0: none.
constexpr std::array<std::size_t, kGeometry.size()> kGuard{0,  0,  0,  4,  4,  6,  6,  8,  8,
                                                           10, 10, 12, 12, 14, 14, 16, 16, 16};
constexpr std::array<std::string_view, 2> kPhotometry{"magnitude", "area_m2"};

double phase_of(const Sight& sight) {
  const Vector3 observer = sight.observer_from_target_m.normalized(), sun = sight.sun_from_target_m.normalized();
  return std::atan2(observer.cross(sun).norm(), observer.dot(sun));
}

/// Four points of Gauss's quadrature from -1 to 1.
constexpr std::array<double, 4> kPlaces{-0.861136311594052575, -0.339981043584856265, 0.339981043584856265,
                                        0.861136311594052575};
constexpr std::array<double, 4> kWeights{0.347854845137453857, 0.652145154862546143, 0.652145154862546143,
                                         0.347854845137453857};

/// When light is looked at within an exposure: distances from its middle, and weights that sum up to 1.
struct Moments {
  std::vector<double> offsets_s, weights;
};

Moments moments_of(double exposure_s, double turned_rad, bool mirrors) {
  if (exposure_s == 0.0) return {{0.0}, {1.0}};
  // A mirror is bright for the Sun's diameter: some thirty looks at it.
  const double turn_of_a_part = mirrors ? 0.25 * kSunRadius_rad : 0.2;
  constexpr double most_parts = 1e4;
  const double parts = std::max(1.0, std::ceil(turned_rad / turn_of_a_part));
  if (parts > most_parts) {
    throw InputError(fmt::format("the body turns by {:.3g} rad in an exposure; at most {:.3g} rad can be followed{}",
                                 turned_rad, most_parts * turn_of_a_part, mirrors ? " where it has mirrors" : ""));
  }
  Moments out;
  for (int part = 0; part < parts; ++part) {
    for (std::size_t k = 0; k < 4; ++k) {
      out.offsets_s.push_back(exposure_s * ((part + 0.5 + 0.5 * kPlaces[k]) / parts - 0.5));
      out.weights.push_back(0.5 * kWeights[k] / parts);
    }
  }
  return out;
}

/// Where a column is looked at for its derivative by a part of the state (rad, or a part of the momentum), and the
/// derivative from the differences across the near and the far two: within 1e-13 where the column is smooth.
constexpr double kStep = 1e-3;
constexpr std::array<double, 4> kPlacesOfDerivative{kStep, -kStep, 2.0 * kStep, -2.0 * kStep};
constexpr double derivative(double across_near, double across_far) {
  return (8.0 * across_near - across_far) / (12.0 * kStep);
}

/// The instants that are computed together: what they need stays in the nearest cache.
constexpr std::size_t kBlock = 256;

/// Room for one block, as the kernels want it: arrays of which no two begin at one place in a page of memory, which
/// would make loads wait for stores.
struct ObserverWork {
  std::array<double*, 4> q{};
  std::array<double*, 3> m{}, observer{}, sun{}, observer_in_shape{}, sun_in_shape{};
  double *high = nullptr, *low = nullptr, *brightness = nullptr, *area = nullptr;
  std::vector<Sight> sights = std::vector<Sight>(kBlock);

  ObserverWork() {
    double* next = memory_.data();
    const auto take = [&next](double*& array) {
      array = next;
      next += kStride;
    };
    std::for_each(q.begin(), q.end(), take);
    for (auto* const group : {&m, &observer, &sun, &observer_in_shape, &sun_in_shape}) {
      std::for_each(group->begin(), group->end(), take);
    }
    for (double** const one : {&high, &low, &brightness, &area}) take(*one);
  }
  ObserverWork(const ObserverWork&) = delete;
  ObserverWork& operator=(const ObserverWork&) = delete;

 private:
  static constexpr std::size_t kStride = kBlock + 24;
  std::vector<double> memory_ = std::vector<double>(23 * kStride);
};

class Observer {
 public:
  Observer(const ObservedMotion& body, std::span<const Instant> receptions,
           const std::function<Sight(std::size_t, Instant)>& sight_of, const ObservationOptions& options)
      : body_(body), receptions_(receptions), sight_of_(sight_of), options_(options) {
    const Quaternion q_icrf_from_inertial = q_icrf_from(body.frame);
    inertial_from_icrf_ = q_icrf_from_inertial.conjugate().toRotationMatrix();
    frame_ = {q_icrf_from_inertial, body.named_from_principal, options.convention, q_icrf_from(options.angles_frame)};
    if (options.photometry) {
      const Photometry& photometry = *options.photometry;
      map_ = photometry.shape->map() * body.named_from_principal;
      const double mean_m2 = photometry.shape->mean_at_opposition_m2(photometry.law);
      if (!(mean_m2 > 0.0)) throw InputError("no part of the shape scatters light: there is no mean that H belongs to");
      zero_ = photometry.absolute_magnitude.value_or(0.0) + 2.5 * std::log10(mean_m2);
    }
    double turned_rad = 0.0;
    if (options.exposure_s > 0.0 && !receptions.empty()) {
      const Seconds t = receptions.front() - body.epoch;
      const Vector3 momentum = body.motion->at(t.high, t.low).momentum_body;
      turned_rad = momentum.cwiseQuotient(body.principal_moments).norm() * options.exposure_s;
      if (!std::isfinite(turned_rad)) turned_rad = 0.0;
    }
    moments_ = moments_of(options.exposure_s, turned_rad,
                          options.photometry && options.photometry->shape->has_mirrors(options.photometry->law));
  }

  void fill(std::size_t begin, std::size_t end, std::vector<ObservedColumn>& columns) const {
    ObserverWork work;
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t count = std::min(kBlock, end - first);
      std::size_t column = 0;
      if (options_.geometry) {
        states(first, count, 0.0, work);
        std::array<double*, kGeometry.size()> to{};
        for (double*& place : to) place = &columns[column++].values[first];
        geometry(count, work, to);
      }
      if (options_.photometry) photometry(first, count, work, columns[column].values, columns[column + 1].values);
    }
  }

  /// The derivatives of the same columns by the parameters of `states_by`, and by the scale of the shape.
  void fill_partials(std::size_t begin, std::size_t end, const StatePartialsSource& states_by,
                     std::vector<ObservedColumn>& columns) const {
    ObserverWork work;
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t count = std::min(kBlock, end - first);
      std::size_t column = 0;
      if (options_.geometry) {
        geometry_partials(first, count, states_by, work, columns);
        column = kGeometry.size();
      }
      if (options_.photometry) {
        photometry_partials(first, count, states_by, work, columns[column].values, columns[column + 1].values);
      }
    }
  }

 private:
  /// Sights at the receptions and states at the emissions, principal axes.
  void states(std::size_t first, std::size_t count, double offset_s, ObserverWork& work) const {
    for (std::size_t i = 0; i < count; ++i) {
      const Instant reception =
          offset_s == 0.0 ? receptions_[first + i] : receptions_[first + i] + Seconds{offset_s, 0.0};
      work.sights[i] = sight_of_(first + i, reception);
      const Seconds t = (reception - body_.epoch) - Seconds{work.sights[i].light_time_s, 0.0};
      work.high[i] = t.high;
      work.low[i] = t.low;
    }
    StateArrays out;
    for (std::size_t k = 0; k < 4; ++k) out.q[k] = work.q[k];
    for (std::size_t k = 0; k < 3; ++k) out.m[k] = work.m[k];
    out.q_stride = out.m_stride = 1;
    body_.motion->batch({{work.high, count}, {work.low, count}}, out);
  }

  void geometry(std::size_t count, const ObserverWork& work, std::span<double* const> to) const {
    for (std::size_t i = 0; i < count; ++i) {
      const Sight& sight = work.sights[i];
      const State state{{work.q[0][i], work.q[1][i], work.q[2][i], work.q[3][i]},
                        {work.m[0][i], work.m[1][i], work.m[2][i]}};
      const Aspect aspect = aspect_of(sight, state, frame_);
      std::size_t column = 0;
      const auto put = [&](double value) { to[column++][i] = value; };
      const auto put_angle = [&](double rad) { put(rad / degree); };
      const auto put_axis = [&](const AxisOnSky& axis) {
        put_angle(axis.icrf.longitude_rad);
        put_angle(axis.icrf.latitude_rad);
        put_angle(axis.position_angle_rad);
        put_angle(axis.aspect_angle_rad);
      };
      put(sight.light_time_s);
      put(sight.observer_from_target_m.norm());
      put_angle(phase_of(sight));
      put_angle(aspect.sub_observer.longitude_rad);
      put_angle(aspect.sub_observer.latitude_rad);
      put_angle(aspect.sub_solar.longitude_rad);
      put_angle(aspect.sub_solar.latitude_rad);
      put_axis(aspect.momentum);
      put_axis(aspect.long_axis);
      for (const double angle : aspect.euler_angles_rad) put_angle(angle);
    }
  }

  /// Distances in au, and the phase function, in the light of a body that is then 1 au from both.
  double light_of_brightness(const Sight& sight) const {
    const Photometry& photometry = *options_.photometry;
    const double range_m = sight.observer_from_target_m.norm(), range = range_m / astronomical_unit_m;
    if (range_m <= photometry.shape->radius_m()) {
      throw InputError(
          fmt::format("the observer is {:.6g} m from the middle of the body, whose largest radius is {:.6g} m", range_m,
                      photometry.shape->radius_m()));
    }
    const double sun = sight.sun_from_target_m.norm() / astronomical_unit_m;
    const double phase =
        std::holds_alternative<std::monostate>(photometry.phase)
            ? 1.0
            : std::pow(10.0, -0.4 * phase_magnitude(photometry.phase, photometry.law, phase_of(sight)));
    return phase / (range * range * sun * sun);
  }

  void photometry(std::size_t first, std::size_t count, ObserverWork& work, std::vector<double>& magnitude,
                  std::vector<double>& area_m2) const {
    const bool one_moment = moments_.offsets_s.size() == 1;
    std::array<double, kBlock> light{}, area{};  // sums over the exposure
    for (std::size_t moment = 0; moment < moments_.offsets_s.size(); ++moment) {
      if (!one_moment || !options_.geometry) states(first, count, moments_.offsets_s[moment], work);
      shine(count, work);
      for (std::size_t i = 0; i < count; ++i) {
        light[i] += moments_.weights[moment] * light_of_brightness(work.sights[i]) * work.brightness[i];
        area[i] += moments_.weights[moment] * work.area[i];
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      magnitude[first + i] = zero_ - 2.5 * std::log10(light[i]);
      if (!(magnitude[first + i] > -std::numeric_limits<double>::infinity())) {
        throw ComputationError(
            fmt::format("the magnitude of row {} is {}: shape, distance and law leave the range of "
                        "numbers",
                        first + i + 1, magnitude[first + i]));
      }
      area_m2[first + i] = area[i];
    }
  }

  /// d(theta, m)/d(parameters) at the emissions of a block, in principal axes: 6 rows for each.
  std::vector<double> state_partials(std::size_t count, const StatePartialsSource& states_by,
                                     const ObserverWork& work) const {
    const std::size_t parameters = states_by.parameters.size();
    std::vector<double> matrices(6 * parameters * count);
    states_by.batch({{work.high, count}, {work.low, count}}, matrices);
    const Matrix3 principal_from_named = body_.named_from_principal.transpose();
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>> matrix(
          &matrices[6 * parameters * i], 6, static_cast<Eigen::Index>(parameters));
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

  void geometry_partials(std::size_t first, std::size_t count, const StatePartialsSource& states_by, ObserverWork& work,
                         std::vector<ObservedColumn>& columns) const {
    states(first, count, 0.0, work);
    const std::vector<double> matrices = state_partials(count, states_by, work);
    const std::size_t parameters = states_by.parameters.size();
    const std::size_t width = parameters + (options_.photometry ? 4 : 3);
    ObserverWork displaced;
    std::vector<double> values(kPlacesOfDerivative.size() * kGeometry.size() * kBlock);
    for (int component = 0; component < 6; ++component) {
      const auto value = [&](std::size_t place, std::size_t column) -> double* {
        return &values[(place * kGeometry.size() + column) * kBlock];
      };
      for (std::size_t place = 0; place < kPlacesOfDerivative.size(); ++place) {
        displace(count, work, component, kPlacesOfDerivative[place], displaced);
        std::array<double*, kGeometry.size()> to{};
        for (std::size_t column = 0; column < to.size(); ++column) to[column] = value(place, column);
        geometry(count, displaced, to);
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
          for (std::size_t p = 0; p < parameters; ++p) {
            columns[column].values[(first + i) * width + p] +=
                slope * matrices[(6 * i + static_cast<std::size_t>(component)) * parameters + p];
          }
          if (component < 3 && kGeometry[column].starts_with("sub_")) {
            put_by_axes(component, slope, &columns[column].values[(first + i) * width + parameters]);
          }
        }
      }
    }
  }

  void photometry_partials(std::size_t first, std::size_t count, const StatePartialsSource& states_by,
                           ObserverWork& work, std::vector<double>& magnitude, std::vector<double>& area_m2) const {
    const std::size_t parameters = states_by.parameters.size(), width = parameters + 4;
    std::vector<double> light(count), by_light(count * width);
    ObserverWork displaced;
    for (std::size_t moment = 0; moment < moments_.offsets_s.size(); ++moment) {
      states(first, count, moments_.offsets_s[moment], work);
      const std::vector<double> matrices = state_partials(count, states_by, work);
      shine(count, work);
      for (std::size_t i = 0; i < count; ++i) {
        light[i] += moments_.weights[moment] * light_of_brightness(work.sights[i]) * work.brightness[i];
        area_m2[(first + i + 1) * width - 1] += 2.0 * moments_.weights[moment] * work.area[i];  // by the scale
      }
      for (int component = 0; component < 3; ++component) {          // of the momentum nothing depends
        std::array<std::array<double, kBlock>, 2> bright{}, area{};  // differences over the near and the far two places
        for (std::size_t place = 0; place < kPlacesOfDerivative.size(); ++place) {
          displace(count, work, component, kPlacesOfDerivative[place], displaced);
          shine(count, displaced);
          const double sign = place % 2 == 0 ? 1.0 : -1.0;
          for (std::size_t i = 0; i < count; ++i) {
            bright[place / 2][i] += sign * displaced.brightness[i];
            area[place / 2][i] += sign * displaced.area[i];
          }
        }
        for (std::size_t i = 0; i < count; ++i) {
          const double weight = moments_.weights[moment];
          const double by_turn = weight * light_of_brightness(work.sights[i]) * derivative(bright[0][i], bright[1][i]);
          const double area_by_turn = weight * derivative(area[0][i], area[1][i]);
          for (std::size_t p = 0; p < parameters; ++p) {
            const double turned = matrices[(6 * i + static_cast<std::size_t>(component)) * parameters + p];
            by_light[i * width + p] += by_turn * turned;
            area_m2[(first + i) * width + p] += area_by_turn * turned;
          }
          put_by_axes(component, by_turn, &by_light[i * width + parameters]);
          put_by_axes(component, area_by_turn, &area_m2[(first + i) * width + parameters]);
        }
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t p = 0; p < width; ++p) {
        magnitude[(first + i) * width + p] = -2.5 / std::numbers::ln10 * by_light[i * width + p] / light[i];
      }
    }
  }

  /// Adds what a turn of the principal axes in the body does, seen from which it is one of the attitude backwards.
  void put_by_axes(int component, double by_turn, double* to) const {
    for (int named = 0; named < 3; ++named) to[named] -= by_turn * body_.named_from_principal(named, component);
  }

  static double momentum(const ObserverWork& work, std::size_t i) {
    return Vector3(work.m[0][i], work.m[1][i], work.m[2][i]).norm();
  }

  /// Brightness and area of a block.
  void shine(std::size_t count, ObserverWork& work) const {
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 observer = (inertial_from_icrf_ * work.sights[i].observer_from_target_m).normalized();
      const Vector3 sun = (inertial_from_icrf_ * work.sights[i].sun_from_target_m).normalized();
      for (std::size_t k = 0; k < 3; ++k) {
        work.observer[k][i] = observer[static_cast<Eigen::Index>(k)];
        work.sun[k][i] = sun[static_cast<Eigen::Index>(k)];
      }
    }
    double map[9];
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{map} = map_;
    const auto &e = work.observer_in_shape, &u = work.sun_in_shape;
    brightness::best_kernels().turn(
        count, work.q.data(),
        {{work.observer[0], work.observer[1], work.observer[2]}, {work.sun[0], work.sun[1], work.sun[2]}}, map,
        e.data(), u.data());
    options_.photometry->shape->shine(count, {{e[0], e[1], e[2]}, {u[0], u[1], u[2]}}, options_.photometry->law,
                                      {work.brightness, work.area});
  }

  const ObservedMotion& body_;
  std::span<const Instant> receptions_;
  const std::function<Sight(std::size_t, Instant)>& sight_of_;
  const ObservationOptions& options_;
  Matrix3 inertial_from_icrf_;
  AspectFrame frame_;
  Matrix3 map_ = Matrix3::Identity();
  double zero_ = 0.0;
  Moments moments_;
};

}  // namespace

std::vector<std::string> observed_columns(const ObservationOptions& options) {
  std::vector<std::string> names;
  const auto add = [&names](const auto& some) {
    for (const std::string_view name : some) names.emplace_back(name);
  };
  if (options.geometry) add(kGeometry);
  if (options.photometry) add(kPhotometry);
  return names;
}

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

namespace {

/// Columns of `width` numbers an instant, which `fill` fills in parts.
template <class Fill>
std::vector<ObservedColumn> filled_columns(const ObservedMotion& body, std::span<const Instant> receptions,
                                           const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                           const ObservationOptions& options, std::size_t width, const Fill& fill) {
  if (!(options.exposure_s >= 0.0 && std::isfinite(options.exposure_s))) {
    throw InputError(fmt::format("the exposure lasts {} s; 0 or more is wanted", options.exposure_s));
  }
  if (options.photometry) {
    constexpr double largest = 100.0;
    const double absolute = options.photometry->absolute_magnitude.value_or(0.0);
    if (!(std::abs(absolute) <= largest)) {
      throw InputError(fmt::format("the absolute magnitude is {}; -100 to 100 are allowed", absolute));
    }
    check(options.photometry->phase);
    const ScatteringLaw& law = options.photometry->law;
    if (law.lambert == 0.0 && options.photometry->shape->has_mirrors(law)) {
      throw InputError("mirrors are seen beside a law with Lambert's part, as lambert; this one has none");
    }
  }
  std::vector<ObservedColumn> columns;
  for (const std::string& name : observed_columns(options)) {
    columns.push_back({name, std::vector<double>(width * receptions.size())});
  }
  const Observer observer(body, receptions, sight_of, options);
  parallel_chunks(receptions.size(), kBlock, options.threads,
                  [&](std::size_t begin, std::size_t end) { fill(observer, begin, end, columns); });
  return columns;
}

}  // namespace

std::vector<ObservedColumn> observe(const ObservedMotion& body, std::span<const Instant> receptions,
                                    const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                    const ObservationOptions& options) {
  return filled_columns(body, receptions, sight_of, options, 1,
                        [](const Observer& observer, std::size_t begin, std::size_t end,
                           std::vector<ObservedColumn>& columns) { observer.fill(begin, end, columns); });
}

std::vector<ObservedColumn> observe_partials(const ObservedMotion& body, std::span<const Instant> receptions,
                                             const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                             const ObservationOptions& options, const StatePartialsSource& states_by) {
  const std::vector<ObservedColumn> values = observe(body, receptions, sight_of, options);
  const std::size_t width = observed_parameters(states_by, options).size();
  std::vector<ObservedColumn> partials = filled_columns(
      body, receptions, sight_of, options, width,
      [&states_by](const Observer& observer, std::size_t begin, std::size_t end, std::vector<ObservedColumn>& columns) {
        observer.fill_partials(begin, end, states_by, columns);
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
