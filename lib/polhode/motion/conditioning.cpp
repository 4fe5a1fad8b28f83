#include "polhode/motion/conditioning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "polhode/base/error.hpp"
#include "polhode/base/error_budget.hpp"
#include "polhode/motion/partials.hpp"

namespace polhode {

namespace {

void check_time(double t_s) {
  if (!std::isfinite(t_s)) throw InputError(fmt::format("the time is {} s, a finite one is wanted", t_s));
}

/// The largest turn per relative change of one input, at any of the times; NaN if one is.
double largest_response_rad(const FreeBody& body, std::span<const double> times_s) {
  const FreePartials motion(body);
  double worst = 0.0;
  for (const double t_s : times_s) {
    const PartialsMatrix partials = motion.at(t_s).partials;
    for (int k = 0; k < 3; ++k) {
      const double of_momentum = std::abs(body.momentum_body[k]) * partials.block<3, 1>(0, 3 + k).norm();
      const double of_moment = body.principal_moments[k] * partials.block<3, 1>(0, 6 + k).norm();
      for (const double response : {of_momentum, of_moment}) {
        if (!(response <= worst)) worst = response;  // keeps a NaN
      }
    }
  }
  return worst;
}

}  // namespace

double condition_number(const FreeBody& body, double t_s) {
  check_time(t_s);
  const double response_rad = largest_response_rad(body, {&t_s, 1});
  return response_rad <= 1.0 ? 1.0 : response_rad;
}

double free_motion_error_rad(const FreeBody& body, double first_s, double last_s) {
  check_time(first_s);
  check_time(last_s);
  constexpr double straight_rad = 0.3;  // beyond, the response is not in proportion to the change
  constexpr double change = 1e-12;      // far above rounding
  std::array<double, 33> times_s{};
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    times_s[i] = std::lerp(first_s, last_s, static_cast<double>(i) / static_cast<double>(times_s.size() - 1));
  }
  // The phase alone grows by that, also where it is beyond any arithmetic.
  const double turned_rad =
      body.momentum_body.cwiseQuotient(body.principal_moments).norm() * std::max(std::abs(first_s), std::abs(last_s));
  if (!(change * turned_rad <= straight_rad)) return std::numeric_limits<double>::quiet_NaN();
  const double response_rad = largest_response_rad(body, times_s);
  if (!(change * response_rad <= straight_rad)) return std::numeric_limits<double>::quiet_NaN();
  return ErrorBudget::rounding_rad * std::max(1.0, response_rad);
}

MotionAccount free_motion_account(const Method& method, const FreeBody& body, double first_s, double last_s) {
  MotionAccount account;
  account.method = method.name;
  if (!method.exact_everywhere) {
    account.error_meaning = "nothing is promised";
    return account;
  }
  const double error_rad = free_motion_error_rad(body, first_s, last_s);
  if (std::isfinite(error_rad)) {
    account.max_error_rad = error_rad;
    account.error_meaning = "rounding only: the numbers of the body are taken as exact, and no torque acts";
  } else {
    account.error_meaning = "nothing is promised: a part in 1e12 of an input turns the body away within the span";
  }
  return account;
}

}  // namespace polhode
