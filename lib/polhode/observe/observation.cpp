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
#include "polhode/observe/observer.hpp"

namespace polhode {
namespace {

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

ExposureMoments moments_of(double exposure_s, double turned_rad, bool mirrors) {
  if (exposure_s == 0.0) return {{0.0}, {1.0}};
  // A mirror is bright for the Sun's diameter: some thirty looks at it.
  const double turn_of_a_part = mirrors ? 0.25 * kSunRadius_rad : 0.2;
  constexpr double most_parts = 1e4;
  const double parts = std::max(1.0, std::ceil(turned_rad / turn_of_a_part));
  if (parts > most_parts) {
    throw InputError(fmt::format("the body turns by {:.3g} rad in an exposure; at most {:.3g} rad can be followed{}",
                                 turned_rad, most_parts * turn_of_a_part, mirrors ? " where it has mirrors" : ""));
  }
  ExposureMoments out;
  for (int part = 0; part < parts; ++part) {
    for (std::size_t k = 0; k < 4; ++k) {
      out.offsets_s.push_back(exposure_s * ((part + 0.5 + 0.5 * kPlaces[k]) / parts - 0.5));
      out.weights.push_back(0.5 * kWeights[k] / parts);
    }
  }
  return out;
}

}  // namespace

void check(const Photometry& photometry) {
  constexpr double largest = 100.0;
  const double absolute = photometry.absolute_magnitude.value_or(0.0);
  if (!(std::abs(absolute) <= largest)) {
    throw InputError(fmt::format("the absolute magnitude is {}; -100 to 100 are allowed", absolute));
  }
  check(photometry.phase);
  const bool mirrors = photometry.shape->has_mirrors(photometry.law);
  if (photometry.law.specular != 0.0 && !mirrors) {
    throw InputError("nothing of this shape is a mirror: meshes have a specular part");
  }
  if (photometry.law.lambert == 0.0 && mirrors) {
    throw InputError("mirrors are seen beside a law with Lambert's part, as lambert; this one has none");
  }
}

Observer::Observer(const ObservedMotion& body, std::span<const Instant> receptions,
                   const std::function<Sight(std::size_t, Instant)>& sight_of, const ObservationOptions& options)
    : body_(body), receptions_(receptions), sight_of_(sight_of), options_(options) {
  if (!(options.exposure_s >= 0.0 && std::isfinite(options.exposure_s))) {
    throw InputError(fmt::format("the exposure lasts {} s; 0 or more is wanted", options.exposure_s));
  }
  if (options.photometry) check(*options.photometry);
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

void Observer::states(std::size_t first, std::size_t count, double offset_s, ObserverWork& work) const {
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

void Observer::geometry(std::size_t count, const ObserverWork& work, std::span<double* const> to) const {
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

double Observer::light_of_brightness(const Sight& sight) const {
  const Photometry& photometry = *options_.photometry;
  const double range_m = sight.observer_from_target_m.norm(), range = range_m / astronomical_unit_m;
  if (range_m <= photometry.shape->radius_m()) {
    throw InputError(
        fmt::format("the observer is {:.6g} m from the middle of the body, whose largest radius is {:.6g} m", range_m,
                    photometry.shape->radius_m()));
  }
  const double sun = sight.sun_from_target_m.norm() / astronomical_unit_m;
  const double phase = std::holds_alternative<std::monostate>(photometry.phase)
                           ? 1.0
                           : std::pow(10.0, -0.4 * phase_magnitude(photometry.phase, photometry.law, phase_of(sight)));
  return phase / (range * range * sun * sun);
}

void Observer::photometry(std::size_t first, std::size_t count, ObserverWork& work, std::vector<double>& magnitude,
                          std::vector<double>& area_m2) const {
  const bool one_moment = moments_.offsets_s.size() == 1;
  std::array<double, kObserverBlock> light{}, area{};  // sums over the exposure
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

void Observer::shine(std::size_t count, ObserverWork& work) const {
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
      {{work.observer[0], work.observer[1], work.observer[2]}, {work.sun[0], work.sun[1], work.sun[2]}}, map, e.data(),
      u.data());
  options_.photometry->shape->shine(count, {{e[0], e[1], e[2]}, {u[0], u[1], u[2]}}, options_.photometry->law,
                                    {work.brightness, work.area});
}

std::vector<std::string> observed_columns(const ObservationOptions& options) {
  std::vector<std::string> names;
  const auto add = [&names](const auto& some) {
    for (const std::string_view name : some) names.emplace_back(name);
  };
  if (options.geometry) add(kGeometry);
  if (options.photometry) add(kPhotometry);
  return names;
}

std::vector<ObservedColumn> filled_columns(const Observer& observer, std::size_t width,
                                           const std::function<void(std::size_t first, std::size_t count, ObserverWork&,
                                                                    std::vector<ObservedColumn>&)>& fill) {
  std::vector<ObservedColumn> columns;
  for (const std::string& name : observed_columns(observer.options())) {
    columns.push_back({name, std::vector<double>(width * observer.size())});
  }
  parallel_chunks(observer.size(), kObserverBlock, observer.options().threads, [&](std::size_t begin, std::size_t end) {
    ObserverWork work;
    for (std::size_t first = begin; first < end; first += kObserverBlock) {
      fill(first, std::min(kObserverBlock, end - first), work, columns);
    }
  });
  return columns;
}

std::vector<ObservedColumn> observe(const ObservedMotion& body, std::span<const Instant> receptions,
                                    const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                    const ObservationOptions& options) {
  const Observer observer(body, receptions, sight_of, options);
  return filled_columns(observer, 1, [&](std::size_t first, std::size_t count, ObserverWork& work, auto& columns) {
    std::size_t column = 0;
    if (options.geometry) {
      observer.states(first, count, 0.0, work);
      std::array<double*, kGeometry.size()> to{};
      for (double*& place : to) place = &columns[column++].values[first];
      observer.geometry(count, work, to);
    }
    if (options.photometry) {
      observer.photometry(first, count, work, columns[column].values, columns[column + 1].values);
    }
  });
}

}  // namespace polhode
