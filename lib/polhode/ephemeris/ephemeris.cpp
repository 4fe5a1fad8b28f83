#include "polhode/ephemeris/ephemeris.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

bool all_finite(std::span<const double> values) {
  double zero = 0.0;  // stays 0 as long as every value is finite
  for (const double value : values) zero += value * 0.0;
  return zero == 0.0;
}

}  // namespace

void AttitudeBlock::reserve_rows(std::size_t count) {
  if (time.size() >= count) return;
  time.resize(count);
  q_frame_from_named.resize(4 * count);
  omega_named_rad_s.resize(3 * count);
  momentum_named.resize(3 * count);
  elapsed_high.resize(count);
  elapsed_low.resize(count);
}

Ephemeris::Ephemeris(EphemerisDescription description, const Body& body, Frame frame, TimeGrid times,
                     PrincipalMotion motion)
    : description_(std::move(description)), frame_(frame), times_(std::move(times)), motion_(std::move(motion)) {
  if (!body.inertia) throw InputError("the body has no inertia; an ephemeris needs one");
  if (!body.state) throw InputError("the body has no spin state; an ephemeris needs its epoch");
  inertia_ = *body.inertia;
  epoch_ = body.state->epoch;
  if (!inertia_.named_from_principal.isIdentity(0.0)) {
    q_principal_from_named_ = inertia_.q_named_from_principal().conjugate();
  }
}

void Ephemeris::fill(std::size_t first, std::size_t count, TimeResolution resolution, AttitudeBlock& block) const {
  block.reserve_rows(count);
  block.rows = count;
  double previous = first == 0 ? std::nan("") : times_.time(first - 1, resolution).high;
  double previous_low = first == 0 ? 0.0 : times_.time(first - 1, resolution).low;
  for (std::size_t i = 0; i < count; ++i) {
    const Seconds t = times_.time(first + i, resolution);
    if ((t.high - previous) + (t.low - previous_low) == 0.0) {
      throw InputError(
          fmt::format("rows {} and {} fall on one time, {} s after MJD {}: the step is finer than the "
                      "format's times; take a longer one",
                      first + i, first + i + 1, t.high, times_.reference_mjd()));
    }
    block.time[i] = t;
    previous = t.high;
    previous_low = t.low;
  }
  const std::span high(block.elapsed_high.data(), count);
  const std::span low(block.elapsed_low.data(), count);
  times_.elapsed_tt(std::span(block.time.data(), count), epoch_, high, low, block.scale_nodes);
  motion_(high, low, block.q_frame_from_named.data(), block.momentum_named.data());

  const Vector3 inverse_moments = inertia_.principal_moments.cwiseInverse();
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Map<Eigen::Vector4d> q(&block.q_frame_from_named[4 * i]);
    Eigen::Map<Vector3> momentum(&block.momentum_named[3 * i]);
    Eigen::Map<Vector3> omega(&block.omega_named_rad_s[3 * i]);
    omega = momentum.cwiseProduct(inverse_moments);
    if (!q_principal_from_named_) continue;
    q = scalar_first(from_scalar_first(q) * *q_principal_from_named_);
    momentum = (inertia_.named_from_principal * momentum).eval();
    omega = (inertia_.named_from_principal * omega).eval();
  }
  if (!all_finite({block.q_frame_from_named.data(), 4 * count}) ||
      !all_finite({block.omega_named_rad_s.data(), 3 * count}) ||
      !all_finite({block.momentum_named.data(), 3 * count}) || !all_finite(high)) {
    throw ComputationError(
        fmt::format("a number among rows {} to {} is not finite; nothing is written", first + 1, first + count));
  }
}

}  // namespace polhode
