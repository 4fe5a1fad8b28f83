#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "polhode/observe/place.hpp"

namespace polhode {

inline constexpr double speed_of_light_m_s = 299792458.0;
inline constexpr double astronomical_unit_m = 149597870700.0;

/// What lies where when an observer receives light of a target. Axes of ICRF.
struct Sight {
  Vector3 observer_from_target_m;  ///< observer at reception, target at emission
  Vector3 sun_from_target_m;       ///< target at emission, Sun when its light left it
  double light_time_s = 0.0;       ///< from emission to reception
};

/// A target, an observer and the Sun. Positions are as they are, corrected for light time alone (SPICE's "LT", iterated
/// to the last digit): the target is taken at the emission of the light that the observer receives, the Sun at the
/// emission of the light that then reaches the target. Not corrected are stellar aberration, which moves the direction
/// in which an observer sees the target by up to 20 arcsec and leaves open which side of the target is seen, and the
/// bending of light.
class Viewing {
 public:
  /// Throws InputError where the three cannot be related: a trajectory about a centre that is not known, and another
  /// not about the same. `sun` may not be about the Sun.
  Viewing(Place target, Place observer, Place sun = TheSun{});

  /// Throws InputError where a trajectory does not hold the time.
  Sight at(Instant reception) const;

 private:
  class Surroundings;
  Vector3 position_m(const Place& place, Instant instant, const Surroundings& surroundings) const;
  Vector3 sun_m(Instant instant, const Surroundings& surroundings) const;

  Place target_, observer_, sun_;
};

/// A target whose direction and distance are known at single instants of reception: astrometric right ascension and
/// declination as seen from the observer, with light time, as ephemerides give them.
Sight sight_from_angles(const Vector3& observer_from_barycentre_m, double right_ascension_rad, double declination_rad,
                        double range_m, Instant reception);

/// The sights at many instants, in any order. Where they lie close together they are interpolated by polynomials that
/// hold the positions to 1e-11 of their length.
class Sights {
 public:
  Sights(const Viewing& viewing, std::span<const Instant> instants);

  Sight at(Instant reception) const;
  /// Whether they are interpolated.
  bool interpolated() const { return !pieces_.empty(); }

 private:
  static constexpr int kNodes = 12;
  struct Piece {
    double begin_s, end_s;  // from first_
    std::array<std::array<double, 6>, kNodes> coefficients;
  };
  bool build(double begin_s, double end_s, std::size_t& tries);
  Sight interpolated_at(const Piece& piece, double t_s) const;

  const Viewing* viewing_;
  Instant first_;
  std::vector<Piece> pieces_;
};

}  // namespace polhode
