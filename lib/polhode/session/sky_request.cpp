#include "polhode/session/sky_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/base/units.hpp"
#include "polhode/read/mesh_file.hpp"
#include "polhode/read/text_table.hpp"
#include "polhode/read/units.hpp"

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

std::shared_ptr<const Shape> named_shape(const std::string& text, const std::string& mesh_unit,
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
    return ellipsoid_shape(length_unit_m(words[3]) * axes);
  }
  if (mesh_unit.empty()) {
    throw InputError(fmt::format("the unit of the coordinates of the mesh {} is wanted: m, km, cm, mm", text));
  }
  return mesh_shape(read_mesh(content_of(text), text), length_unit_m(mesh_unit));
}

std::vector<ObservedColumn> observe(const BodyInMotion& moving, const SkyRequest& sky,
                                    std::span<const Instant> receptions, const ObservationOptions& options) {
  const Viewing viewing(sky.target, sky.observer, sky.sun);
  std::vector<Instant> ends(receptions.begin(), receptions.end());
  double light_time_s = 0.0;
  if (!ends.empty()) {
    const auto [first, last] = std::minmax_element(receptions.begin(), receptions.end());
    light_time_s = viewing.at(*first).light_time_s;
    ends.push_back(*first + Seconds{-0.5 * options.exposure_s, 0.0});
    ends.push_back(*last + Seconds{0.5 * options.exposure_s, 0.0});
  }
  check_span(moving, ends, light_time_s);
  const Sights sights(viewing, ends);
  return observe(
      observed_motion(moving), receptions, [&sights](std::size_t, Instant reception) { return sights.at(reception); },
      options);
}

std::vector<ObservedColumn> observe(const BodyInMotion& moving, std::span<const KnownDirection> directions,
                                    std::span<const Instant> receptions, const ObservationOptions& options) {
  if (directions.size() != receptions.size()) throw InputError("as many directions as times are wanted");
  double farthest_m = 0.0;
  for (const KnownDirection& direction : directions) farthest_m = std::max(farthest_m, direction.range_m);
  check_span(moving, receptions, farthest_m / speed_of_light_m_s + 0.5 * options.exposure_s);
  return observe(
      observed_motion(moving), receptions,
      [&directions](std::size_t index, Instant reception) {
        const KnownDirection& to = directions[index];
        return sight_from_angles(earth_and_sun(reception).earth_m, to.right_ascension_rad, to.declination_rad,
                                 to.range_m, reception);
      },
      options);
}

}  // namespace polhode
