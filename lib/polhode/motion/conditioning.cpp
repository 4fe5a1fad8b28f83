#include "polhode/motion/conditioning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "polhode/base/error.hpp"
#include "polhode/base/error_budget.hpp"

namespace polhode {

namespace {

void check_time(double t_s) {
  if (!std::isfinite(t_s)) throw InputError(fmt::format("the time is {} s, a finite one is wanted", t_s));
}

/// The largest response at any of the times, in radians; NaN if one is.
double largest_response_rad(std::unique_ptr<Motion> (*make)(const FreeBody&), const FreeBody& body,
                            std::span<const double> times_s, double change) {
  const auto motion = make(body);
  double worst = 0.0;
  const auto compare = [&](const FreeBody& changed) {
    const auto other = make(changed);
    for (const double t_s : times_s) {
      const double moved =
          rotation_angle_rad(other->at(t_s).q_inertial_from_body, motion->at(t_s).q_inertial_from_body);
      if (!(moved <= worst)) worst = moved;  // keeps a NaN
    }
  };
  for (int k = 0; k < 3; ++k) {
    FreeBody changed = body;
    // Away from the neighbours, so that the moments keep their order; the middle one has one side free unless all
    // three are equal.
    Vector3& moments = changed.principal_moments;
    const double sign = k == 0 || (k == 1 && moments[1] > moments[0]) ? -1.0 : 1.0;
    moments[k] *= 1.0 + sign * change;
    std::sort(moments.begin(), moments.end());
    compare(changed);
  }
  for (int k = 0; k < 3; ++k) {
    FreeBody changed = body;
    changed.momentum_body[k] *= 1.0 + change;
    compare(changed);
  }
  return worst;
}

constexpr double kChange = 1e-12;  // far above rounding, far below what bends the answer

}  // namespace

double condition_number(std::unique_ptr<Motion> (*make)(const FreeBody&), const FreeBody& body, double t_s) {
  check_time(t_s);
  const double response_rad = largest_response_rad(make, body, {&t_s, 1}, kChange);
  return response_rad <= kChange ? 1.0 : response_rad / kChange;
}

double free_motion_error_rad(std::unique_ptr<Motion> (*make)(const FreeBody&), const FreeBody& body, double first_s,
                             double last_s) {
  check_time(first_s);
  check_time(last_s);
  constexpr double straight_rad = 0.3;  // beyond, the response is not in proportion to the change
  std::array<double, 33> times_s{};
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    times_s[i] = std::lerp(first_s, last_s, static_cast<double>(i) / static_cast<double>(times_s.size() - 1));
  }
  // The phase alone grows by that, also where it is beyond any arithmetic.
  const double turned_rad =
      body.momentum_body.cwiseQuotient(body.principal_moments).norm() * std::max(std::abs(first_s), std::abs(last_s));
  if (!(kChange * turned_rad <= straight_rad)) return std::numeric_limits<double>::quiet_NaN();
  const double response_rad = largest_response_rad(make, body, times_s, kChange);
  if (!(response_rad <= straight_rad)) return std::numeric_limits<double>::quiet_NaN();
  return ErrorBudget::rounding_rad * std::max(1.0, response_rad / kChange);
}

MotionAccount free_motion_account(const Method& method, const FreeBody& body, double first_s, double last_s) {
  MotionAccount account;
  account.method = method.name;
  if (!method.exact_everywhere) {
    account.error_meaning = "nothing is promised";
    return account;
  }
  const double error_rad = free_motion_error_rad(method.make, body, first_s, last_s);
  if (std::isfinite(error_rad)) {
    account.max_error_rad = error_rad;
    account.error_meaning = "rounding only: the numbers of the body are taken as exact, and no torque acts";
  } else {
    account.error_meaning = "nothing is promised: a part in 1e12 of an input turns the body away within the span";
  }
  return account;
}

}  // namespace polhode
