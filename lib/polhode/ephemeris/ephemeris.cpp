#include "polhode/ephemeris/ephemeris.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

bool all_finite(std::span<const double> values) {
  std::array<double, 8> zeros{};  // stay 0 as long as every value is finite; several, so that none waits for another
  std::size_t i = 0;
  for (; i + zeros.size() <= values.size(); i += zeros.size()) {
    for (std::size_t k = 0; k < zeros.size(); ++k) zeros[k] += values[i + k] * 0.0;
  }
  for (; i < values.size(); ++i) zeros[0] += values[i] * 0.0;
  return std::all_of(zeros.begin(), zeros.end(), [](double zero) { return zero == 0.0; });
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

void Ephemeris::refuse_equal_times(std::size_t first, TimeResolution resolution, std::span<const Seconds> times) const {
  const auto equal = [](Seconds a, Seconds b) { return (a.high - b.high) + (a.low - b.low) == 0.0; };
  const auto refuse = [this](std::size_t row, Seconds t) {
    throw InputError(
        fmt::format("rows {} and {} fall on one time, {} s after MJD {}: the step is finer than the format's times; "
                    "take a longer one",
                    row, row + 1, t.high, times_.reference_mjd()));
  };
  if (first > 0 && equal(times_.time(first - 1, resolution), times[0])) refuse(first, times[0]);
  const auto found = std::adjacent_find(times.begin(), times.end(), equal);
  if (found != times.end()) refuse(first + static_cast<std::size_t>(found - times.begin()) + 1, *found);
}

void Ephemeris::fill(std::size_t first, std::size_t count, TimeResolution resolution, AttitudeBlock& block) const {
  block.reserve_rows(count);
  block.rows = count;
  const std::span times(block.time.data(), count);
  times_.times(first, resolution, times);
  refuse_equal_times(first, resolution, times);
  const std::span high(block.elapsed_high.data(), count);
  const std::span low(block.elapsed_low.data(), count);
  times_.elapsed_tt(times, epoch_, high, low, block.scale_nodes);
  motion_(high, low, block.q_frame_from_named.data(), block.momentum_named.data());

  const Vector3 inverse_moments = inertia_.principal_moments.cwiseInverse();
  double* q_row = block.q_frame_from_named.data();
  double* m_row = block.momentum_named.data();
  double* omega_row = block.omega_named_rad_s.data();
  for (std::size_t i = 0; i < count; ++i, q_row += 4, m_row += 3, omega_row += 3) {
    Eigen::Map<Vector3> momentum(m_row);
    Eigen::Map<Vector3> omega(omega_row);
    omega = momentum.cwiseProduct(inverse_moments);
    if (!q_principal_from_named_) continue;
    Eigen::Map<Eigen::Vector4d> q(q_row);
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
