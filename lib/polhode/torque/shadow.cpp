#include "polhode/torque/shadow.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace polhode {
namespace {

constexpr double kSunRadius_m = 6.957e8;  // nominal, IAU 2015 resolution B3

/// As seen from the body: angular radii, and how far the centres are apart.
struct Discs {
  double sun_rad, ball_rad, apart_rad;

  Discs(const Vector3& to_sun_m, const Vector3& from_ball_m, double ball_radius_m)
      : sun_rad(std::asin(std::min(1.0, kSunRadius_m / to_sun_m.norm()))),
        ball_rad(std::asin(std::min(1.0, ball_radius_m / from_ball_m.norm()))),
        apart_rad(std::atan2(to_sun_m.cross(from_ball_m).norm(), -to_sun_m.dot(from_ball_m))) {}

  /// Above 0 outside of the penumbra, and outside of the umbra (or of where a ring is left).
  double from_penumbra() const { return apart_rad - (ball_rad + sun_rad); }
  double from_inner() const { return apart_rad - std::abs(ball_rad - sun_rad); }
};

/// Of a disc of radius r, beyond a chord at this distance from its centre (-r to r).
double segment_area(double r, double distance) {
  const double x = std::clamp(distance / r, -1.0, 1.0);
  return r * r * (std::acos(x) - x * std::sqrt((1.0 - x) * (1.0 + x)));
}

}  // namespace

double lit_share(const Vector3& to_sun_m, const Vector3& from_ball_m, double ball_radius_m) {
  // Most places are far from the penumbra, by their distance from the line through Sun and ball.
  const double sun_distance = to_sun_m.norm(), sine = kSunRadius_m / sun_distance;
  const double across = to_sun_m.cross(from_ball_m).norm() / sun_distance;
  if (sine < 0.1 && across > 1.01 * (ball_radius_m + sine * from_ball_m.norm())) return 1.0;
  const Discs d(to_sun_m, from_ball_m, ball_radius_m);
  if (d.from_penumbra() >= 0.0) return 1.0;
  const double sun = d.sun_rad, ball = d.ball_rad, apart = d.apart_rad;
  if (d.from_inner() <= 0.0) return ball >= sun ? 0.0 : 1.0 - (ball / sun) * (ball / sun);
  const double to_chord = (apart * apart + (sun - ball) * (sun + ball)) / (2.0 * apart);  // from the Sun's centre
  const double covered = segment_area(sun, to_chord) + segment_area(ball, apart - to_chord);
  return std::clamp(1.0 - covered / (std::numbers::pi * sun * sun), 0.0, 1.0);
}

std::vector<double> shadow_edges_s(const Trajectory& from_sun, const Trajectory& from_ball, double ball_radius_m,
                                   double first_s, double last_s) {
  constexpr double kStep = 0.25;  // in r/v: about a twenty-fifth of an orbit
  const auto discs = [&](double t_s) {
    return Discs(-from_sun.state(t_s).position_m, from_ball.state(t_s).position_m, ball_radius_m);
  };
  std::vector<double> edges_s;
  // Each of the two distances on its own: between two looks it changes sign, or dips below 0 and back.
  struct Look {
    double t_s, distance;
  };
  for (const bool inner : {false, true}) {
    const auto look = [&](double t_s) {
      const Discs d = discs(t_s);
      return Look{t_s, inner ? d.from_inner() : d.from_penumbra()};
    };
    const auto add_root = [&](Look a, Look b) {  // by secants (Illinois)
      double before_s = a.t_s;
      for (int i = 0, side = 0; i < 60; ++i) {
        const double t_s =
            std::clamp((b.t_s * a.distance - a.t_s * b.distance) / (a.distance - b.distance), a.t_s, b.t_s);
        const bool done = std::abs(t_s - before_s) < 1e-6;
        before_s = t_s;
        if (done) break;
        const Look middle = look(t_s);
        if ((middle.distance > 0.0) == (b.distance > 0.0)) {
          b = middle;
          if (side == -1) a.distance *= 0.5;
          side = -1;
        } else {
          a = middle;
          if (side == 1) b.distance *= 0.5;
          side = 1;
        }
      }
      edges_s.push_back(before_s);
    };
    Look before = look(first_s), last = before;
    while (last.t_s < last_s) {
      const OrbitState<double> place = from_ball.state(last.t_s);
      const double step_s = kStep * place.position_m.norm() / place.velocity_m_s.norm();
      const Look next = look(std::min(last.t_s + step_s, last_s));
      if ((last.distance > 0.0) != (next.distance > 0.0)) {
        add_root(last, next);
      } else if (before.t_s < last.t_s && last.distance > 0.0 && before.distance >= last.distance &&
                 next.distance >= last.distance && before.distance > 0.0) {
        // A least distance lies between: golden section.
        Look a = before, b = next, low = last;
        constexpr double share = 0.381966;
        for (int i = 0; i < 40 && low.distance > 0.0 && b.t_s - a.t_s > 1e-3 * step_s; ++i) {
          const bool right = b.t_s - low.t_s > low.t_s - a.t_s;
          const Look other = look(right ? low.t_s + share * (b.t_s - low.t_s) : low.t_s - share * (low.t_s - a.t_s));
          if (other.distance < low.distance) {
            (right ? a : b) = low;
            low = other;
          } else {
            (right ? b : a) = other;
          }
        }
        if (low.distance <= 0.0) {
          add_root(before, low);
          add_root(low, next);
        }
      }
      before = last, last = next;
    }
  }
  std::sort(edges_s.begin(), edges_s.end());
  return edges_s;
}

}  // namespace polhode
