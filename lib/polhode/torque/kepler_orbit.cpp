#include "polhode/torque/kepler_orbit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

template <class Real>
struct UniversalFunctions {
  Real u1, u2, u3;
};

/// chi^k c_k(alpha chi^2) for k = 1, 2, 3, where c_k(z) = sum (-z)^n / (k + 2n)!. Series for small z, where the closed
/// forms cancel.
template <class Real>
UniversalFunctions<Real> universal_functions(Real chi, Real alpha) {
  const Real z = alpha * chi * chi;
  Real c1, c2, c3;
  if (std::abs(z) < Real(0.6)) {
    c2 = c3 = 0;
    constexpr int terms = std::is_same_v<Real, double> ? 8 : 10;  // 0.6^terms / (2 terms + 2)! is below a rounding
    for (int n = terms; n >= 0; --n) {
      c2 = (1 - z * c2) / Real((2 * n + 1) * (2 * n + 2));
      c3 = (1 - z * c3) / Real((2 * n + 2) * (2 * n + 3));
    }
    c1 = 1 - z * c3;
  } else if (z > 0) {
    const Real E = std::sqrt(z), half_sine = std::sin(E / 2);
    c1 = 2 * half_sine * std::cos(E / 2) / E;
    c2 = 2 * half_sine * half_sine / z;
    c3 = (1 - c1) / z;
  } else {
    const Real H = std::sqrt(-z), half_sine = std::sinh(H / 2);
    c1 = 2 * half_sine * std::cosh(H / 2) / H;
    c2 = -2 * half_sine * half_sine / z;
    c3 = (1 - c1) / z;
  }
  return {chi * c1, chi * chi * c2, chi * chi * chi * c3};
}

}  // namespace

std::optional<KeplerFault> fault_of(const KeplerElements& elements) {
  using Element = KeplerFault::Element;
  const auto is_positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  if (!is_positive(elements.mu_m3_s2)) {
    return KeplerFault{Element::mu, fmt::format("mu is {}, a positive number of m3/s2 is wanted", elements.mu_m3_s2)};
  }
  if (!is_positive(elements.periapsis_m)) {
    return KeplerFault{Element::periapsis, fmt::format("the periapsis distance is {}, a positive number of m is wanted",
                                                       elements.periapsis_m)};
  }
  if (!(elements.eccentricity >= 0.0) || !std::isfinite(elements.eccentricity)) {
    return KeplerFault{Element::eccentricity,
                       fmt::format("the eccentricity is {}, 0 or more is wanted", elements.eccentricity)};
  }
  if (!(std::abs(elements.periapsis_time_s) <= kMostPeriapsisTime_s)) {
    return KeplerFault{
        Element::periapsis_time,
        fmt::format("the time of periapsis is {} s, from {:g} s to {:g} s is wanted: of times much longer "
                    "a double does not hold the phase on an orbit",
                    elements.periapsis_time_s, -kMostPeriapsisTime_s, kMostPeriapsisTime_s)};
  }
  const auto text = [](const Vector3& v) { return fmt::format("({:.9g}, {:.9g}, {:.9g})", v[0], v[1], v[2]); };
  const Vector3 &x = elements.to_periapsis, &normal = elements.along_normal;
  const auto is_direction = [](const Vector3& v) { return v.allFinite() && !v.isZero(0.0); };
  constexpr const char* wanted = "{} is {}, a finite vector other than 0 is wanted";
  if (!is_direction(x)) {
    return KeplerFault{Element::to_periapsis, fmt::format(wanted, "the direction of periapsis", text(x))};
  }
  if (!is_direction(normal))
    return KeplerFault{Element::along_normal, fmt::format(wanted, "the orbit normal", text(normal))};
  const double skew_rad =
      std::abs(std::asin(std::clamp(x.stableNormalized().dot(normal.stableNormalized()), -1.0, 1.0)));
  if (!(skew_rad <= kMostSkew_rad)) {
    return KeplerFault{
        Element::along_normal,
        fmt::format("the orbit normal {} is {:.2g} rad from a right angle to the direction of periapsis {}; "
                    "at most {:g} rad is allowed, what four decimals hold",
                    text(normal), skew_rad, text(x), kMostSkew_rad)};
  }
  return std::nullopt;
}

KeplerOrbit::KeplerOrbit(const KeplerElements& elements) : elements_(elements) {
  if (const auto fault = fault_of(elements)) throw InputError(fault->message);
  using Extended = long double;
  Constants<Extended>& c = extended_;
  const Extended mu = elements.mu_m3_s2, q = elements.periapsis_m, e = elements.eccentricity;
  c.sqrt_mu = std::sqrt(mu);
  c.alpha = (1 - e) / q;
  c.period_s = c.alpha > 0 ? 2 * std::numbers::pi_v<Extended> / (c.sqrt_mu * c.alpha * std::sqrt(c.alpha)) : 0;
  c.time_s = elements.periapsis_time_s;
  c.sqrt_parameter = std::sqrt(q * (1 + e));
  c.x = elements.to_periapsis.cast<Extended>().stableNormalized();
  Vector3Of<Extended> normal = elements.along_normal.cast<Extended>().stableNormalized();
  normal -= c.x.dot(normal) * c.x;
  c.y = normal.normalized().cross(c.x);
  plain_ = {static_cast<double>(c.sqrt_mu),
            static_cast<double>(c.alpha),
            static_cast<double>(c.period_s),
            static_cast<double>(c.time_s),
            static_cast<double>(c.sqrt_parameter),
            c.x.cast<double>(),
            c.y.cast<double>()};
  period_rounding_s_ = static_cast<double>(c.period_s - plain_.period_s);
  const OrbitState<double> closest = state(plain_.time_s);
  if (!(closest.position_m.norm() > 0.0 && closest.velocity_m_s.norm() > 0.0 &&
        std::isfinite(closest.position_m.squaredNorm() + closest.velocity_m_s.squaredNorm()))) {
    throw InputError(
        fmt::format("mu {} m3/s2, periapsis {} m and eccentricity {} are no orbit that double precision holds",
                    elements.mu_m3_s2, elements.periapsis_m, elements.eccentricity));
  }
}

template <class Real>
OrbitState<Real> KeplerOrbit::state(Real t_s) const {
  const auto& c = [this]() -> const Constants<Real>& {
    if constexpr (std::is_same_v<Real, double>) {
      return plain_;
    } else {
      return extended_;
    }
  }();
  const Real q = elements_.periapsis_m, e = elements_.eccentricity;
  Real dt = t_s - c.time_s;
  if (c.alpha > 0) {
    if constexpr (std::is_same_v<Real, double>) {
      // The rounding of the period would add up to a phase that every turn makes larger.
      const double turns = std::nearbyint(dt / c.period_s);
      dt = std::fma(-turns, c.period_s, dt) - turns * period_rounding_s_;
    } else {
      dt = std::remainder(dt, c.period_s);
    }
  }
  const Real path = c.sqrt_mu * std::abs(dt);

  Real bound, chi;
  starter(path, bound, chi);
  // Halley's steps (the derivatives of the time by chi are r and e U1); below `done` their error, a third power, is a
  // rounding, and Taylor's formula gives the functions at the end of the step.
  constexpr Real done = std::is_same_v<Real, double> ? Real(2e-6) : Real(1e-7);
  UniversalFunctions<Real> u{};
  for (int i = 0; i < 60; ++i) {
    u = universal_functions(chi, c.alpha);
    const Real r = q + e * u.u2;
    const Real newton = (q * u.u1 + u.u3 - path) / r;
    const Real step = std::max(newton / std::max(1 - newton * e * u.u1 / (2 * r), Real(0.5)), chi - bound);
    if (std::abs(step) <= done * chi) {
      const Real u0 = 1 - c.alpha * u.u2, u1 = u.u1;
      u.u1 -= step * (u0 + step / 2 * c.alpha * u1);
      u.u2 -= step * (u1 - step / 2 * u0);
      break;
    }
    chi -= step;
  }
  const Real rate = c.sqrt_mu / (q + e * u.u2);  // of chi
  const Real side = std::copysign(Real(1), dt);
  return {(q - u.u2) * c.x + side * c.sqrt_parameter * u.u1 * c.y,
          -side * rate * u.u1 * c.x + rate * c.sqrt_parameter * (1 - c.alpha * u.u2) * c.y};
}

template <class Real>
void KeplerOrbit::starter(Real path, Real& bound, Real& chi) const {
  // In double precision, whatever Real is. The time is convex in chi: from an upper bound Newton's method comes down to
  // the root. q <= r gives one, U3 >= chi^3/pi^2 (ellipse, half a turn) or chi^3/6 another, and for a hyperbola
  // e sinh H - H >= (e - 1) sinh H a third.
  const double q = elements_.periapsis_m, e = elements_.eccentricity, alpha = plain_.alpha;
  const double way = static_cast<double>(path);
  double most = std::min(way / q, std::cbrt(way * (alpha > 0 ? 9.87 : 6.0)));
  double start = most;
  if (alpha > 0.0) {  // good to a few per cent where e is not near 1
    const double sqrt_alpha = std::sqrt(alpha), M = way * alpha * sqrt_alpha;
    if (e > 0.0) start = std::min(most, (M + e * std::sin(M) / (1.0 - std::sin(M + e) + std::sin(M))) / sqrt_alpha);
  } else if (alpha < 0.0) {
    const double sqrt_alpha = std::sqrt(-alpha);
    start = most = std::min(most, std::asinh(way * -alpha * sqrt_alpha / (e - 1.0)) / sqrt_alpha);
  }
  if constexpr (!std::is_same_v<Real, double>) {
    for (int i = 0; i < 60; ++i) {  // to the digits of double: one step is left to Real
      const UniversalFunctions<double> u = universal_functions(start, alpha);
      const double r = q + e * u.u2, newton = (q * u.u1 + u.u3 - way) / r;
      const double step = std::max(newton / std::max(1.0 - newton * e * u.u1 / (2.0 * r), 0.5), start - most);
      start -= step;
      if (std::abs(step) <= 1e-8 * start) break;
    }
    most *= 1.0 + 1e-15;
  }
  bound = most, chi = start;
}

template OrbitState<double> KeplerOrbit::state(double) const;
template OrbitState<long double> KeplerOrbit::state(long double) const;

}  // namespace polhode
