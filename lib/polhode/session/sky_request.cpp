#include "polhode/session/sky_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/base/units.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/read/text_table.hpp"
#include "polhode/read/units.hpp"
#include "polhode/session/displaced_motions.hpp"

namespace polhode {
namespace {

/// "4.6 2.4 1.92 km" or "204.5, 19.8, 4200" as cells.
std::vector<std::string> words_of(const std::string& text) {
  std::string plain = text;
  std::replace(plain.begin(), plain.end(), ',', ' ');
  std::vector<std::string> words;
  split_cells(plain, false, words);
  return words;
}

/// Refuses instants that the motion does not hold. Those of a scene are known before their light has been followed.
void check_span(const BodyInMotion& moving, std::span<const Instant> receptions, double earliest_s) {
  if (!moving.under_torques || receptions.empty()) return;
  const auto [first, last] = std::minmax_element(receptions.begin(), receptions.end());
  moving.account_between(*first + Seconds{-earliest_s, 0.0}, *last, TimeScale::tdb);
}

}  // namespace

ObservedMotion observed_motion(const BodyInMotion& moving) {
  ObservedMotion out;
  out.motion = moving.motion;
  out.frame = moving.frame;
  out.epoch = moving.body.state->epoch;
  out.named_from_principal = moving.body.inertia->named_from_principal;
  out.principal_moments = moving.free.principal_moments;
  return out;
}

Place named_place(const std::string& text, const TrajectoryRequest& request, const ContentOf& content_of) {
  const std::string lower = lower_case(text);
  if (lower == "geocentre" || lower == "geocenter") return TheGeocentre{};
  if (lower == "sun") return TheSun{};
  TrajectoryRequest icrf = request;
  icrf.frame = Frame::icrf;
  CentredTrajectory way = parse_centred_trajectory(content_of(text), text, icrf);
  return KnownWay{std::move(way.trajectory), Frame::icrf, request.zero,
                  way.centre.empty() ? upper_case(request.centre) : way.centre, text};
}

Site parse_site(const std::string& text, const EarthOrientation& earth) {
  const std::vector<std::string> words = words_of(text);
  std::vector<double> numbers;
  for (const std::string& word : words) {
    if (const std::optional<double> number = parse_number(word)) numbers.push_back(*number);
  }
  if (words.size() != 3 || numbers.size() != 3) {
    throw InputError(
        fmt::format("'{:.60}' is no place: LONGITUDE LATITUDE HEIGHT are wanted, in deg (east), deg and m", text));
  }
  const Site site{numbers[0] * degree, numbers[1] * degree, numbers[2], earth};
  site_from_geocentre_m(site, Instant{});  // refuses coordinates that are none
  return site;
}

SurfaceShine surface_shine(std::span<const double> numbers) {
  if (numbers.size() == 2) return {numbers[0], numbers[1], false};
  if (numbers.size() == 3 && (numbers[2] == 1.0 || numbers[2] == 2.0))
    return {numbers[0], numbers[1], numbers[2] == 2.0};
  throw InputError("of a surface its diffuse and its specular part are wanted, and it may have 1 or 2 sides");
}

std::pair<std::string, SurfaceShine> parse_surface(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  std::vector<double> numbers;
  bool whole = equals != std::string::npos && equals > 0;
  for (const std::string& word : words_of(whole ? text.substr(equals + 1) : "")) {
    const std::optional<double> number = parse_number(word);
    whole = whole && number;
    numbers.push_back(number.value_or(0.0));
  }
  if (!whole) {
    throw InputError(fmt::format("'{:.60}' is not NAME=DIFFUSE,SPECULAR[,SIDES], as panels=0.2,0.7,2", text));
  }
  return {text.substr(0, equals), surface_shine(numbers)};
}

std::shared_ptr<const Shape> named_shape(const std::string& text, const std::string& mesh_unit,
                                         const std::map<std::string, SurfaceShine, std::less<>>& surfaces,
                                         const ContentOf& content_of) {
  const std::vector<std::string> words = words_of(text);
  if (!words.empty() && parse_number(words[0]) && !std::filesystem::exists(text)) {
    Vector3 axes;
    bool numbers = words.size() == 4;
    for (std::size_t k = 0; k < 3 && numbers; ++k) {
      const std::optional<double> number = parse_number(words[k]);
      numbers = number.has_value();
      if (numbers) axes[static_cast<Eigen::Index>(k)] = *number;
    }
    if (!numbers) {
      throw InputError(fmt::format(
          "'{:.60}' is no ellipsoid: three semi-axes and their unit are wanted, as \"2.3 1.2 0.96 km\"", text));
    }
    if (!mesh_unit.empty())
      throw InputError("a unit beside the shape is for meshes; that of an ellipsoid stands with its axes");
    if (!surfaces.empty()) throw InputError("surfaces are of a mesh, which gives them names; this is an ellipsoid");
    return ellipsoid_shape(length_unit_m(words[3]) * axes);
  }
  if (mesh_unit.empty()) {
    throw InputError(fmt::format("the unit of the coordinates of the mesh {} is wanted: m, km, cm, mm", text));
  }
  return mesh_shape(read_mesh(content_of(text), text), length_unit_m(mesh_unit), surfaces);
}

namespace {

using SightOf = std::function<Sight(std::size_t index, Instant reception)>;

/// What `observe` makes of the sights of one who is told a target.
template <class Observe>
auto with_sights(const BodyInMotion& moving, const SkyRequest& sky, std::span<const Instant> receptions,
                 double exposure_s, const Observe& observe) {
  const Viewing viewing(sky.target, sky.observer, sky.sun);
  std::vector<Instant> ends(receptions.begin(), receptions.end());
  double light_time_s = 0.0;
  if (!ends.empty()) {
    const auto [first, last] = std::minmax_element(receptions.begin(), receptions.end());
    light_time_s = viewing.at(*first).light_time_s;
    ends.push_back(*first + Seconds{-0.5 * exposure_s, 0.0});
    ends.push_back(*last + Seconds{0.5 * exposure_s, 0.0});
  }
  check_span(moving, ends, light_time_s);
  const Sights sights(viewing, ends);
  return observe(SightOf([&sights](std::size_t, Instant reception) { return sights.at(reception); }));
}

template <class Observe>
auto with_sights(const BodyInMotion& moving, const std::vector<KnownDirection>& directions,
                 std::span<const Instant> receptions, double exposure_s, const Observe& observe) {
  if (directions.size() != receptions.size()) throw InputError("as many directions as times are wanted");
  double farthest_m = 0.0;
  for (const KnownDirection& direction : directions) farthest_m = std::max(farthest_m, direction.range_m);
  check_span(moving, receptions, farthest_m / speed_of_light_m_s + 0.5 * exposure_s);
  return observe(SightOf([&directions](std::size_t index, Instant reception) {
    const KnownDirection& to = directions[index];
    return sight_from_angles(earth_and_sun(reception).earth_m, to.right_ascension_rad, to.declination_rad, to.range_m,
                             reception);
  }));
}

/// The same, whichever of both is told.
template <class Observe>
auto seen_from(const Sky& sky, const BodyInMotion& moving, std::span<const Instant> receptions, double exposure_s,
               const Observe& observe) {
  return std::visit([&](const auto& known) { return with_sights(moving, known, receptions, exposure_s, observe); },
                    sky);
}

}  // namespace

std::vector<ObservedColumn> observe(const BodyInMotion& moving, const Sky& sky, std::span<const Instant> receptions,
                                    const ObservationOptions& options) {
  return seen_from(sky, moving, receptions, options.exposure_s, [&](const SightOf& sight_of) {
    return observe(observed_motion(moving), receptions, sight_of, options);
  });
}

std::vector<ObservedColumn> observe_partials(const BodyInMotion& moving, const Sky& sky,
                                             std::span<const Instant> receptions, const ObservationOptions& options,
                                             const StatePartialsSource& states_by) {
  return seen_from(sky, moving, receptions, options.exposure_s, [&](const SightOf& sight_of) {
    return observe_partials(observed_motion(moving), receptions, sight_of, options, states_by);
  });
}

namespace {

bool depends_on_attitude(const ObservedColumn& column) {
  return column.name != "light_time_s" && column.name != "range_m" && column.name != "phase_deg";
}

/// NaN stays NaN: nothing is known of such a row.
double root_of(double variance) { return variance < 0.0 ? 0.0 : std::sqrt(variance); }

/// Of a scene: what its displaced motions show. Its torques may be fixed in the body, whose axes may be uncertain.
std::vector<ObservedColumn> sigmas_of_displaced(const BodyInMotion& moving, const Sky& sky,
                                                std::span<const Instant> receptions,
                                                const ObservationOptions& options) {
  const DisplacedMotions motions(moving);
  const auto seen = [&](const DisplacedMotion& displaced) {
    BodyInMotion of = moving;
    of.body = displaced.body;
    of.free = displaced.free;
    of.motion = displaced.motion;
    return observe(of, sky, receptions, options);
  };
  const std::vector<ObservedColumn> centre = seen(motions.centre);
  std::vector<ObservedColumn> variances = centre;
  for (ObservedColumn& column : variances) std::fill(column.values.begin(), column.values.end(), 0.0);
  for (const auto& [one, other] : motions.of_parts) {
    const std::vector<ObservedColumn> to_one = seen(one), to_other = seen(other);
    const ParabolaWeights w = parabola_weights(one, other);
    for (std::size_t c = 0; c < centre.size(); ++c) {
      const bool is_angle = centre[c].name.ends_with("_deg");
      for (std::size_t row = 0; row < receptions.size(); ++row) {
        const auto away = [&](const std::vector<ObservedColumn>& displaced) {
          const double difference = displaced[c].values[row] - centre[c].values[row];
          return is_angle ? std::remainder(difference, 360.0) : difference;
        };
        const double slope = w.first_of_one * away(to_one) + w.first_of_other * away(to_other);
        variances[c].values[row] += has_derivative(centre, c, row) ? slope * slope : std::nan("");
      }
    }
  }
  std::vector<ObservedColumn> sigmas;
  for (ObservedColumn& column : variances) {
    if (!depends_on_attitude(column)) continue;
    std::transform(column.values.begin(), column.values.end(), column.values.begin(), root_of);
    sigmas.push_back({"sigma_" + column.name, std::move(column.values)});
  }
  return sigmas;
}

}  // namespace

std::vector<ObservedColumn> observe_sigmas(const BodyInMotion& moving, const Sky& sky,
                                           std::span<const Instant> receptions, const ObservationOptions& options) {
  if (moving.under_torques) return sigmas_of_displaced(moving, sky, receptions, options);
  const auto covariance = epoch_covariance_with_axes(moving.body);
  const StatePartialsSource states_by = state_partials_of(*moving.motion, moving.free);
  const std::size_t width = observed_parameters(states_by, options).size();
  std::vector<ObservedColumn> sigmas;
  for (const ObservedColumn& column : observe_partials(moving, sky, receptions, options, states_by)) {
    if (!depends_on_attitude(column)) continue;
    sigmas.push_back({"sigma_" + column.name, {}});
    ObservedColumn& sigma = sigmas.back();
    for (std::size_t i = 0; i < receptions.size(); ++i) {
      const Eigen::Map<const Eigen::Matrix<double, 12, 1>> by(&column.values[i * width]);
      sigma.values.push_back(root_of(by.dot(covariance * by)));
    }
  }
  return sigmas;
}

std::optional<std::string> sigmas_caution(const BodyInMotion& moving, std::span<const Instant> receptions) {
  if (moving.under_torques || receptions.empty()) return std::nullopt;
  const auto [first, last] = std::minmax_element(receptions.begin(), receptions.end());
  const Instant epoch = moving.body.state->epoch;
  return covariance_rows(moving, (*first - epoch).high, (*last - epoch).high).caution;
}

}  // namespace polhode
