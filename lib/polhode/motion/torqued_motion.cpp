#include "polhode/motion/torqued_motion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "polhode/base/error.hpp"
#include "polhode/motion/series_motion.hpp"
#include "polhode/motion/value_motion.hpp"

namespace polhode {
namespace {

constexpr std::string_view kAuto = "auto", kSeries = "series", kDormandPrince = "dormand-prince";

}  // namespace

std::string_view outcome_name(Outcome outcome) {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::stopped:
      return "stopped";
    default:
      return "tolerance not reachable";
  }
}

std::span<const std::string_view> torqued_motion_methods() {
  static constexpr std::string_view all[] = {kAuto, kSeries, kDormandPrince};
  return all;
}

TorquedMotion::TorquedMotion(const FreeBody& body, const Torques& torques_named, const TorquedOptions& options)
    : body_(checked(body)), torques_(torques_named), method_(options.method), tolerance_rad_(options.tolerance_rad) {
  const Torques torques = torques_named.in_principal_axes(body.named_from_principal);
  if (!(options.tolerance_rad > 0.0 && std::isfinite(options.tolerance_rad))) {
    throw InputError(fmt::format("the tolerance is {}, a positive angle in radians is wanted", options.tolerance_rad));
  }
  check_span(options.first_s, options.last_s);
  const PropagationOptions how{options.tolerance_rad, options.first_s, options.last_s, options.max_torque_evaluations};
  if (method_ == kAuto) method_ = SeriesMotion::serves(torques) ? kSeries : kDormandPrince;
  if (method_ == kSeries) {
    if (!SeriesMotion::serves(torques)) {
      throw InputError(
          "a torque here has no series: one on facets, a function of your own, or the currents of several fields");
    }
    engine_ = std::make_shared<const SeriesMotion>(body, torques, how);
  } else if (method_ == kDormandPrince) {
    engine_ = std::make_shared<const ValueMotion>(body, torques, how);
  } else {
    throw InputError(fmt::format("unknown method '{:.40}' under torques, allowed are {}", method_,
                                 fmt::join(torqued_motion_methods(), ", ")));
  }
  outcome_ = !engine_->whole()               ? Outcome::stopped
             : error_rad() <= tolerance_rad_ ? Outcome::done
                                             : Outcome::tolerance_not_reachable;
}

MotionAccount TorquedMotion::account() const {
  MotionAccount account;
  account.method = method_;
  account.torque_evaluations = torque_evaluations();
  if (outcome_ == Outcome::stopped) {
    account.error_meaning = "nothing is promised: the end of the span was not reached";
    return account;
  }
  const std::string found = method_ == kSeries
                                ? fmt::format("carried along with the motion: {:.1e} rad", error_rad())
                                : fmt::format("from the differences of its runs: {:.1e} rad", error_rad());
  if (outcome_ == Outcome::done) {
    account.max_error_rad = tolerance_rad_;
    account.error_meaning = found + "; the numbers of the body and its torques are taken as exact";
  } else {
    account.error_meaning = fmt::format("nothing is promised: {} only", found);
  }
  return account;
}

}  // namespace polhode
