#include "polhode/observe/observation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

Moments moments_of(double exposure_s, double turned_rad) {
  if (exposure_s == 0.0) return {{0.0}, {1.0}};
  constexpr double turn_of_a_part = 0.2, most_parts = 1e4;
  const double parts = std::clamp(std::ceil(turned_rad / turn_of_a_part), 1.0, most_parts);
  Moments out;
  for (int part = 0; part < parts; ++part) {
    for (std::size_t k = 0; k < 4; ++k) {
      out.offsets_s.push_back(exposure_s * ((part + 0.5 + 0.5 * kPlaces[k]) / parts - 0.5));
      out.weights.push_back(0.5 * kWeights[k] / parts);
    }
  }
  return out;
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
      zero_ = photometry.absolute_magnitude.value_or(0.0) +
              2.5 * std::log10(photometry.shape->mean_at_opposition_m2(photometry.law));
    }
    double turned_rad = 0.0;
    if (options.exposure_s > 0.0 && !receptions.empty()) {
      const Seconds t = receptions.front() - body.epoch;
      const Vector3 momentum = body.motion->at(t.high, t.low).momentum_body;
      turned_rad = momentum.cwiseQuotient(body.principal_moments).norm() * options.exposure_s;
      if (!std::isfinite(turned_rad)) turned_rad = 0.0;
    }
    moments_ = moments_of(options.exposure_s, turned_rad);
  }

  void fill(std::size_t begin, std::size_t end, std::vector<ObservedColumn>& columns) const {
    ObserverWork work;
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t count = std::min(kBlock, end - first);
      std::size_t column = 0;
      if (options_.geometry) {
        states(first, count, 0.0, work);
        geometry(first, count, work, columns);
        column = kGeometry.size();
      }
      if (options_.photometry) photometry(first, count, work, columns[column].values, columns[column + 1].values);
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

  void geometry(std::size_t first, std::size_t count, const ObserverWork& work,
                std::vector<ObservedColumn>& columns) const {
    for (std::size_t i = 0; i < count; ++i) {
      const Sight& sight = work.sights[i];
      const State state{{work.q[0][i], work.q[1][i], work.q[2][i], work.q[3][i]},
                        {work.m[0][i], work.m[1][i], work.m[2][i]}};
      const Aspect aspect = aspect_of(sight, state, frame_);
      std::size_t column = 0;
      const auto put = [&](double value) { columns[column++].values[first + i] = value; };
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

  void photometry(std::size_t first, std::size_t count, ObserverWork& work, std::vector<double>& magnitude,
                  std::vector<double>& area_m2) const {
    const Photometry& photometry = *options_.photometry;
    const bool one_moment = moments_.offsets_s.size() == 1;
    std::array<double, kBlock> light{}, area{};  // sums over the exposure
    for (std::size_t moment = 0; moment < moments_.offsets_s.size(); ++moment) {
      if (!one_moment || !options_.geometry) states(first, count, moments_.offsets_s[moment], work);
      shine(count, work);
      for (std::size_t i = 0; i < count; ++i) {
        const Sight& sight = work.sights[i];
        // Distances in au, and the phase function, in the light of a body that is then 1 au from both.
        const double range_m = sight.observer_from_target_m.norm(), range = range_m / astronomical_unit_m;
        if (range_m <= photometry.shape->radius_m()) {
          throw InputError(
              fmt::format("the observer is {:.6g} m from the middle of the body, whose largest radius is {:.6g} m",
                          range_m, photometry.shape->radius_m()));
        }
        const double sun = sight.sun_from_target_m.norm() / astronomical_unit_m;
        const double phase =
            std::holds_alternative<std::monostate>(photometry.phase)
                ? 1.0
                : std::pow(10.0, -0.4 * phase_magnitude(photometry.phase, photometry.law, phase_of(sight)));
        light[i] += moments_.weights[moment] * phase * work.brightness[i] / (range * range * sun * sun);
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

std::vector<ObservedColumn> observe(const ObservedMotion& body, std::span<const Instant> receptions,
                                    const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                    const ObservationOptions& options) {
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
  }
  std::vector<ObservedColumn> columns;
  for (const std::string& name : observed_columns(options)) {
    columns.push_back({name, std::vector<double>(receptions.size())});
  }
  const Observer observer(body, receptions, sight_of, options);
  parallel_chunks(receptions.size(), kBlock, options.threads,
                  [&](std::size_t begin, std::size_t end) { observer.fill(begin, end, columns); });
  return columns;
}

}  // namespace polhode
