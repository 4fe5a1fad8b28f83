#include "polhode/motion/known_until.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "polhode/base/units.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/time/duration_text.hpp"

namespace polhode {
namespace {

constexpr double kForEver_s = std::numeric_limits<double>::infinity();
constexpr int kLooks = 64;  // within the longest period

/// The longest of the motion's periods: in it SIGMA swings, and from one to the next it grows.
double longest_period_s(const Body& body) {
  const SpinInvariants spin = spin_invariants(*body.inertia, momentum_principal(body));
  double longest_s = spin.rotation_period_s.value_or(0.0);
  if (spin.polhode_period_s) {
    // On the separatrix there is no period: some turns then.
    const double turn_s = 2.0 * std::numbers::pi / body.state->omega_named_rad_s->norm();
    for (const double period_s :
         {*spin.polhode_period_s, spin.long_axis->precession_period_s, spin.short_axis->precession_period_s}) {
      longest_s = std::max(longest_s, std::min(period_s, 100.0 * turn_s));
    }
  }
  return longest_s;
}

/// Which number's exact knowledge takes most of the largest variance away, and how much of it.
std::pair<std::size_t, double> largest_term(const Body& body, const AttitudeCovariance& covariance, double t_s) {
  const Uncertainty& uncertainty = *body.uncertainty;
  const double all = std::pow(covariance.sigma_rad(t_s), 2);
  std::pair<std::size_t, double> largest{0, -1.0};
  for (std::size_t i = 0; i < uncertainty.numbers.size(); ++i) {
    const double left = std::pow(AttitudeCovariance(body, known_better(uncertainty, i, 0.0)).sigma_rad(t_s), 2);
    const double share = all > 0.0 ? 1.0 - left / all : 0.0;
    if (share > largest.second) largest = {i, share};
  }
  return largest;
}

}  // namespace

double known_until_s(const Body& body, const AttitudeCovariance& covariance, double angle_rad) {
  if (covariance.sigma_rad(0.0) >= angle_rad) return 0.0;
  const double period_s = longest_period_s(body);
  if (period_s == 0.0) return kForEver_s;  // at rest
  const auto reaches = [&](double from_s) {
    for (int i = 0; i <= kLooks; ++i) {
      if (covariance.sigma_rad(from_s + period_s * i / kLooks) >= angle_rad) return true;
    }
    return false;
  };
  // The first period in which it is reached.
  constexpr double farthest_s = 1e15;
  double below_s = 0.0, from_s = 0.0;
  while (!reaches(from_s)) {
    below_s = from_s;
    from_s = std::max(from_s + period_s, 1.25 * from_s);
    if (!(from_s < farthest_s)) return kForEver_s;
  }
  while (from_s - below_s > period_s) {
    const double middle_s = 0.5 * (below_s + from_s);
    (reaches(middle_s) ? from_s : below_s) = middle_s;
  }
  // The first time, at last by halving.
  double good_s = below_s;
  const double step_s = period_s / kLooks;
  for (int look = 0; below_s + look * step_s <= from_s + period_s; ++look) {
    const double t_s = below_s + look * step_s;
    if (covariance.sigma_rad(t_s) >= angle_rad) {
      double bad_s = t_s;
      for (int halving = 0; halving < 30; ++halving) {
        const double middle_s = 0.5 * (good_s + bad_s);
        (covariance.sigma_rad(middle_s) < angle_rad ? good_s : bad_s) = middle_s;
      }
      break;
    }
    good_s = t_s;
  }
  return good_s;
}

StateWorth state_worth(const Body& body) {
  const AttitudeCovariance covariance(body);
  const auto known = [&](double angle_rad) {
    return KnownUntil{angle_rad, known_until_s(body, covariance, angle_rad)};
  };
  StateWorth worth;
  constexpr double rounding_rad = 1e-15;
  const double at_epoch_rad = covariance.sigma_rad(0.0);
  worth.sigma_at_epoch_rad = at_epoch_rad < rounding_rad ? 0.0 : at_epoch_rad;
  worth.degree = known(degree);
  worth.ten_degrees = known(10.0 * degree);
  worth.at_all = known(std::numbers::pi);
  worth.limit_s = std::isfinite(worth.ten_degrees.after_s) ? worth.ten_degrees.after_s : 0.0;
  const auto [number, share] = largest_term(body, covariance, worth.limit_s);
  worth.limit = body.uncertainty->numbers[number].name;
  worth.limit_share = share;
  constexpr double tenth = 0.1;
  const AttitudeCovariance better(body, known_better(*body.uncertainty, number, tenth));
  worth.with_better_limit = {10.0 * degree, known_until_s(body, better, 10.0 * degree)};
  return worth;
}

std::string known_text(const KnownUntil& known) {
  if (known.after_s == 0.0) return "not even at the epoch";
  if (!std::isfinite(known.after_s)) return "for ever";
  return fmt::format("until {} after the epoch", duration_text(known.after_s));
}

std::optional<std::string> worth_text(const Body& body, double farthest_s) {
  if (!body.uncertainty || !body.missing.empty()) return std::nullopt;
  const StateWorth worth = state_worth(body);
  std::string text = fmt::format(
      "the attitude is known to 1 deg (one sigma) {}, to 10 deg {}, and at all (180 deg) {}; the largest term is that "
      "of "
      "{}",
      known_text(worth.degree), known_text(worth.ten_degrees), known_text(worth.at_all), worth.limit);
  if (farthest_s > worth.at_all.after_s) {
    text += fmt::format("; what is asked for lies beyond that, up to {} from the epoch", duration_text(farthest_s));
  }
  return text;
}

}  // namespace polhode
