#include "polhode/motion/events.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

constexpr double kQuarter = std::numbers::pi / 2.0;

double angle_between(const Vector3& a, const Vector3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

MeanRates mean_rates(const ThetaMotion& motion) {
  const theta::Solution& s = motion.solution();
  MeanRates rates;
  double nu = 0.0, rho = 0.0;
  switch (s.chart) {
    case theta::Chart::fixed_axis: {
      const double rate = 2.0 * kQuarter * s.fixed_axis.quarters_per_s.high;
      return {rates.polhode_period_s, rate, rate};
    }
    case theta::Chart::fourier:
      nu = kQuarter * s.fourier.v_quarters_per_s.high;
      rho = kQuarter * s.fourier.rho_quarters_per_s.high;
      break;
    case theta::Chart::hyperbolic:
      nu = std::numbers::pi * s.hyperbolic.x_per_s.high * s.hyperbolic.reciprocal_x_period;
      rho = kQuarter * s.hyperbolic.rho_quarters_per_s.high;
      break;
  }
  if (nu != 0.0) rates.polhode_period_s = 2.0 * std::numbers::pi / std::abs(nu);
  const double circled = 2.0 * rho + nu;  // the axis that the momentum circles
  rates.long_axis_precession_rad_s = s.long_axis_mode ? circled : 2.0 * rho;
  rates.short_axis_precession_rad_s = s.long_axis_mode ? 2.0 * rho : circled;
  return rates;
}

double next_flip_s(const ThetaMotion& motion, double after_s) {
  if (!std::isfinite(after_s)) throw InputError(fmt::format("the time is {} s, a finite one is wanted", after_s));
  const theta::Solution& s = motion.solution();
  constexpr double never = std::numeric_limits<double>::infinity();
  // m2 = 0 where the phase is a whole number of half periods: t = (n period - offset) / rate.
  double rate = 0.0, offset = 0.0, period = 0.0;
  switch (s.chart) {
    case theta::Chart::fixed_axis:
      return never;
    case theta::Chart::fourier:
      rate = s.fourier.v_quarters_per_s.high;
      offset = s.fourier.v_quarters_at_0 + s.fourier.v_whole_quarters_at_0;
      period = 2.0;
      break;
    case theta::Chart::hyperbolic:
      rate = s.hyperbolic.x_per_s.high;
      offset = s.hyperbolic.x_at_0.high;
      period = s.hyperbolic.x_period.high;
      break;
  }
  if (rate < 0.0) rate = -rate, offset = -offset;
  if (s.chart == theta::Chart::hyperbolic && s.hyperbolic.reciprocal_x_period == 0.0) {
    const double only = -offset / rate;
    return only > after_s ? only : never;
  }
  // The count may be off by one after rounding.
  const double about = std::ceil(std::fma(rate, after_s, offset) / period);
  for (const double step : {-1.0, 0.0, 1.0}) {
    const double t = std::fma(about + step, period, -offset) / rate;
    if (t > after_s) return t;
  }
  return never;
}

std::optional<AxisPass> next_pass(const ThetaMotion& motion, const FreeBody& body, const Vector3& axis_body,
                                  const Vector3& direction_inertial, double within_rad, double after_s,
                                  double until_s) {
  checked(body);
  const auto is_direction = [](const Vector3& v) { return std::abs(v.norm() - 1.0) <= 1e-9; };
  if (!is_direction(axis_body) || !is_direction(direction_inertial)) {
    throw InputError("the axis and the direction must be vectors of length 1");
  }
  if (!(within_rad >= 0.0) || !std::isfinite(after_s) || !std::isfinite(until_s)) {
    throw InputError(
        fmt::format("a passage within {} rad from {} s to {} s; an angle of 0 or more and finite times are "
                    "wanted",
                    within_rad, after_s, until_s));
  }
  // |omega| is greatest where the energy is all about the axes of small moment: 2E / I1 bounds its square, and so does
  // (G / I1)^2; the former is never larger.
  const Vector3 omega = body.momentum_body.cwiseQuotient(body.principal_moments);
  const double fastest_rad_s = std::sqrt(omega.dot(body.momentum_body) / body.principal_moments[0]);
  constexpr double resolution_rad = 1e-9;
  double t = after_s;
  while (t <= until_s) {
    const Vector3 axis = motion.at(t).q_inertial_from_body * axis_body;
    const double angle = angle_between(axis, direction_inertial);
    const double beyond = angle - within_rad;
    if (beyond <= resolution_rad) return AxisPass{t, angle};
    const double next = t + beyond / fastest_rad_s;
    if (!(next > t)) return AxisPass{t, angle};  // nearer than time can tell
    t = next;
  }
  return std::nullopt;
}

}  // namespace polhode
