#include "polhode/observe/sight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"
#include "polhode/time/scale.hpp"
#include "polhode/torque/kepler_orbit.hpp"

namespace polhode {
namespace {

/// The name of a centre that is only known by it; empty: the place is known from the barycentre.
std::string foreign_centre(const Place& place) {
  const auto* const way = std::get_if<KnownWay>(&place);
  return way != nullptr && centre_of_name(way->centre) == Centre::other ? upper_case(way->centre) : std::string();
}

/// Says with dates what a table of seconds does not.
void check_covered(const KnownWay& way, double t_s, Instant instant) {
  const TabulatedOrbit* const table = way.trajectory.table();
  if (table == nullptr || (table->first_s() <= t_s && t_s <= table->last_s())) return;
  const auto date = [](Instant time) { return format_date(time, TimeScale::tdb, 3); };
  const std::string message = fmt::format(
      "the trajectory covers {} to {} TDB; {} is asked for (times of reception, and light time before them)",
      date(way.zero + Seconds{table->first_s(), 0.0}), date(way.zero + Seconds{table->last_s(), 0.0}), date(instant));
  if (way.source.empty()) throw InputError(message);
  throw InputError({way.source, 0}, message);
}

/// An orbit about the Sun has the Sun's mass within a part in a hundred; another is about something else.
void check_mass(const Place& place) {
  const auto* const way = std::get_if<KnownWay>(&place);
  if (way == nullptr || centre_of_name(way->centre) != Centre::sun) return;
  const KeplerOrbit* const orbit = way->trajectory.orbit();
  if (orbit == nullptr || std::abs(orbit->elements().mu_m3_s2 / kSunMu_m3_s2 - 1.0) <= 0.01) return;
  throw InputError(fmt::format("the orbit has mu = {:g} m3/s2, which is not the Sun's; `centre` names what it is about",
                               orbit->elements().mu_m3_s2));
}

}  // namespace

Viewing::Viewing(Place target, Place observer, Place sun)
    : target_(std::move(target)), observer_(std::move(observer)), sun_(std::move(sun)) {
  for (const Place* const place : {&target_, &observer_, &sun_}) check_mass(*place);
  const std::string about = foreign_centre(target_);
  if (foreign_centre(observer_) != about || foreign_centre(sun_) != about) {
    const auto text = [](const Place& place) {
      const std::string name = foreign_centre(place);
      return name.empty() ? std::string("the Sun, the Earth or the barycentre") : name;
    };
    throw InputError(fmt::format(
        "the target is known from {}, the observer from {}, the Sun from {}; how these lie to each other is "
        "not known (the Sun, the Earth and the barycentre of the solar system are; else all three "
        "trajectories must be about one centre)",
        text(target_), text(observer_), text(sun_)));
  }
  const auto* const sun_way = std::get_if<KnownWay>(&sun_);
  if (sun_way != nullptr && centre_of_name(sun_way->centre) == Centre::sun) {
    throw InputError(
        "the trajectory of the Sun is about the Sun itself; one about the barycentre or the Earth is wanted");
  }
}

/// Earth and Sun about the time of a reception: ERFA's series are long, and are asked once where they can be.
class Viewing::Surroundings {
 public:
  explicit Surroundings(Instant reception) : reception_(reception) {}

  Vector3 earth_m(Instant instant) const {
    return instant == reception_ ? at_reception().earth_m : earth_and_sun(instant).earth_m;
  }

  /// Within an hour the Sun goes straight on, to 1.5 m.
  Vector3 sun_m(Instant instant) const {
    constexpr double straight_s = 3600.0;
    const double later_s = (instant - reception_).high;
    if (std::abs(later_s) > straight_s) return earth_and_sun(instant).sun_m;
    return at_reception().sun_m + later_s * at_reception().sun_velocity_m_s;
  }

 private:
  const EarthAndSun& at_reception() const {
    if (!known_) known_ = earth_and_sun(reception_);
    return *known_;
  }

  Instant reception_;
  mutable std::optional<EarthAndSun> known_;
};

Vector3 Viewing::sun_m(Instant instant, const Surroundings& surroundings) const {
  return std::holds_alternative<TheSun>(sun_) ? surroundings.sun_m(instant) : position_m(sun_, instant, surroundings);
}

Vector3 Viewing::position_m(const Place& place, Instant instant, const Surroundings& surroundings) const {
  if (std::holds_alternative<TheGeocentre>(place)) return surroundings.earth_m(instant);
  if (std::holds_alternative<TheSun>(place)) return sun_m(instant, surroundings);
  if (const auto* const site = std::get_if<Site>(&place)) {
    return surroundings.earth_m(instant) + site_from_geocentre_m(*site, instant);
  }
  const auto& way = std::get<KnownWay>(place);
  const Seconds t = instant - way.zero;
  check_covered(way, t.high + t.low, instant);
  const Vector3 position = q_icrf_from(way.frame) * way.trajectory.state(t.high + t.low).position_m;
  switch (centre_of_name(way.centre)) {
    case Centre::sun:
      return position + sun_m(instant, surroundings);
    case Centre::earth:
      return position + surroundings.earth_m(instant);
    case Centre::barycentre:
    case Centre::other:
      break;
  }
  return position;
}

namespace {

/// Where the light of something came from that arrives at `here` at `arrival`, and how long it took.
template <class Position>
std::pair<Vector3, double> source_of_light(const Position& position, const Vector3& here, Instant arrival) {
  constexpr int most_steps = 30;
  constexpr double enough = 4e-16;
  Vector3 from_here = position(arrival) - here;
  double light_time_s = from_here.norm() / speed_of_light_m_s;
  for (int step = 0; step < most_steps; ++step) {
    from_here = position(arrival + Seconds{-light_time_s, 0.0}) - here;
    const double next_s = from_here.norm() / speed_of_light_m_s;
    const bool done = std::abs(next_s - light_time_s) <= enough * next_s;
    light_time_s = next_s;
    if (done) break;
  }
  return {from_here, light_time_s};
}

}  // namespace

Sight Viewing::at(Instant reception) const {
  const Surroundings surroundings(reception);
  const Vector3 observer_m = position_m(observer_, reception, surroundings);
  const auto [target_from_observer_m, light_time_s] =
      source_of_light([&](Instant t) { return position_m(target_, t, surroundings); }, observer_m, reception);
  const Vector3 target_m = observer_m + target_from_observer_m;
  const Instant emission = reception + Seconds{-light_time_s, 0.0};
  const Vector3 sun_m =
      source_of_light([&](Instant t) { return position_m(sun_, t, surroundings); }, target_m, emission).first;
  if (!(light_time_s > 0.0)) throw InputError("observer and target are at one place");
  if (!(sun_m.norm() > 0.0)) throw InputError("the target and the Sun are at one place");
  return {-target_from_observer_m, sun_m, light_time_s};
}

Sight sight_from_angles(const Vector3& observer_from_barycentre_m, double right_ascension_rad, double declination_rad,
                        double range_m, Instant reception) {
  if (!(range_m > 0.0))
    throw InputError(fmt::format("the distance of the target is {} m; it must be positive", range_m));
  const Vector3 direction(std::cos(declination_rad) * std::cos(right_ascension_rad),
                          std::cos(declination_rad) * std::sin(right_ascension_rad), std::sin(declination_rad));
  const Vector3 target_m = observer_from_barycentre_m + range_m * direction;
  const double light_time_s = range_m / speed_of_light_m_s;
  const Instant emission = reception + Seconds{-light_time_s, 0.0};
  const Vector3 sun_m = source_of_light([](Instant t) { return earth_and_sun(t).sun_m; }, target_m, emission).first;
  return {-range_m * direction, sun_m, light_time_s};
}

// --- Interpolation ---------------------------------------------------------------------------------------------------

namespace {

constexpr double position_tolerance = 1e-11;

std::array<double, 6> numbers_of(const Sight& sight) {
  std::array<double, 6> numbers{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    numbers[k] = sight.observer_from_target_m[i];
    numbers[3 + k] = sight.sun_from_target_m[i];
  }
  return numbers;
}

}  // namespace

Sights::Sights(const Viewing& viewing, std::span<const Instant> instants) : viewing_(&viewing) {
  constexpr std::size_t calls_per_piece = kNodes + 3;
  if (instants.size() < 4 * calls_per_piece) return;
  const auto [first, last] = std::minmax_element(instants.begin(), instants.end());
  first_ = *first;
  const double span_s = (*last - first_).high;
  std::size_t tries = instants.size() / (3 * calls_per_piece);  // more would cost as much as the instants themselves
  if (!(span_s > 0.0) || !build(0.0, span_s, tries)) pieces_.clear();
}

bool Sights::build(double begin_s, double end_s, std::size_t& tries) {
  constexpr double longest_s = 32.0 * 86400.0;
  const auto numbers_at = [this](double t_s) { return numbers_of(viewing_->at(first_ + Seconds{t_s, 0.0})); };
  const double middle_s = 0.5 * (begin_s + end_s), half_s = 0.5 * (end_s - begin_s);
  if (end_s - begin_s > longest_s) {
    return build(begin_s, middle_s, tries) && build(middle_s, end_s, tries);
  }
  if (tries == 0) return false;
  --tries;
  Piece piece{begin_s, end_s, {}};
  for (int node = 0; node < kNodes; ++node) {
    const double angle = std::numbers::pi * (node + 0.5) / kNodes;
    const std::array<double, 6> values = numbers_at(middle_s + half_s * std::cos(angle));
    for (int n = 0; n < kNodes; ++n) {
      const double weight = (n == 0 ? 1.0 : 2.0) / kNodes * std::cos(n * angle);
      for (std::size_t k = 0; k < 6; ++k) piece.coefficients[static_cast<std::size_t>(n)][k] += weight * values[k];
    }
  }
  bool good = true;
  for (const double place : {-0.995, 0.05, 0.97}) {
    const double t_s = middle_s + half_s * place;
    const Sight wanted = viewing_->at(first_ + Seconds{t_s, 0.0}), found = interpolated_at(piece, t_s);
    good = good &&
           (wanted.observer_from_target_m - found.observer_from_target_m).norm() <=
               position_tolerance * wanted.observer_from_target_m.norm() &&
           (wanted.sun_from_target_m - found.sun_from_target_m).norm() <=
               position_tolerance * wanted.sun_from_target_m.norm();
  }
  if (good) {
    pieces_.push_back(piece);
    return true;
  }
  return build(begin_s, middle_s, tries) && build(middle_s, end_s, tries);
}

Sight Sights::interpolated_at(const Piece& piece, double t_s) const {
  const double x = (2.0 * t_s - piece.begin_s - piece.end_s) / (piece.end_s - piece.begin_s);
  std::array<double, 6> b1{}, b2{};
  for (std::size_t n = kNodes - 1; n > 0; --n) {
    for (std::size_t k = 0; k < 6; ++k) {
      const double next = piece.coefficients[n][k] + 2.0 * x * b1[k] - b2[k];
      b2[k] = b1[k];
      b1[k] = next;
    }
  }
  std::array<double, 6> sum{};
  for (std::size_t k = 0; k < 6; ++k) sum[k] = piece.coefficients[0][k] + x * b1[k] - b2[k];
  Sight sight;
  sight.observer_from_target_m = {sum[0], sum[1], sum[2]};
  sight.sun_from_target_m = {sum[3], sum[4], sum[5]};
  sight.light_time_s = sight.observer_from_target_m.norm() / speed_of_light_m_s;
  return sight;
}

Sight Sights::at(Instant reception) const {
  if (pieces_.empty()) return viewing_->at(reception);
  const Seconds since = reception - first_;
  const double t_s = since.high + since.low;
  auto piece =
      std::lower_bound(pieces_.begin(), pieces_.end(), t_s, [](const Piece& one, double t) { return one.end_s < t; });
  if (piece == pieces_.end()) --piece;
  return interpolated_at(*piece, t_s);
}

}  // namespace polhode
