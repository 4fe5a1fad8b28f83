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
    : description_(std::move(description)), frame_name_(name(frame)), times_(std::move(times)) {
  if (!body.inertia) throw InputError("the body has no inertia; an ephemeris needs one");
  if (!body.state) throw InputError("the body has no spin state; an ephemeris needs its epoch");
  if (!motion) throw InputError("the ephemeris is given no motion");
  check(*body.inertia);
  inertia_ = body.inertia;
  epoch_ = body.state->epoch;
  std::optional<Quaternion> q_principal_from_named;  // absent where the axes are the same
  if (!inertia_->named_from_principal.isIdentity(0.0)) {
    q_principal_from_named = inertia_->q_named_from_principal().conjugate();
  }
  const Matrix3 named_from_principal = inertia_->named_from_principal;
  const Vector3 inverse_moments = inertia_->principal_moments.cwiseInverse();
  if (body.any_inertia) inertia_.reset();  // it says nothing of the body
  rows_ = [motion = std::move(motion), q_principal_from_named, named_from_principal, inverse_moments](
              std::size_t count, AttitudeBlock& block) {
    motion({block.elapsed_high.data(), count}, {block.elapsed_low.data(), count}, block.q_frame_from_named.data(),
           block.momentum_named.data());
    double* q_row = block.q_frame_from_named.data();
    double* m_row = block.momentum_named.data();
    double* omega_row = block.omega_named_rad_s.data();
    for (std::size_t i = 0; i < count; ++i, q_row += 4, m_row += 3, omega_row += 3) {
      Eigen::Map<Vector3> momentum(m_row);
      Eigen::Map<Vector3> omega(omega_row);
      omega = momentum.cwiseProduct(inverse_moments);
      if (!q_principal_from_named) continue;
      Eigen::Map<Eigen::Vector4d> q(q_row);
      q = scalar_first(from_scalar_first(q) * *q_principal_from_named);
      momentum = (named_from_principal * momentum).eval();
      omega = (named_from_principal * omega).eval();
    }
  };
}

Ephemeris::Ephemeris(EphemerisDescription description, AttitudeSegment segment, std::optional<Frame> frame,
                     TimeGrid times)
    : description_(std::move(description)),
      frame_name_(frame ? name(*frame) : segment.frame),
      times_(std::move(times)),
      epoch_(checked(segment).samples.front().time) {
  if (segment.samples.size() == 1 && !segment.has_rates()) {
    throw InputError("an attitude history of one row without rate has no angular velocity");
  }
  Quaternion q_frame_from_segment = Quaternion::Identity();
  if (frame && frame != segment.known_frame) {
    if (!segment.known_frame) {
      throw InputError(
          fmt::format("the attitude history refers to {}, which cannot be led to {}: no inertial frame that "
                      "is known",
                      segment.frame, name(*frame)));
    }
    q_frame_from_segment = q_icrf_from(*frame).conjugate() * q_icrf_from(*segment.known_frame);
  }
  make_signs_continuous(segment);
  rows_ = [segment = std::move(segment), q_frame_from_segment, epoch = epoch_](std::size_t count,
                                                                               AttitudeBlock& block) {
    for (std::size_t i = 0; i < count; ++i) {
      const AttitudeSample row = interpolate(segment, epoch + Seconds{block.elapsed_high[i], block.elapsed_low[i]});
      Eigen::Map<Eigen::Vector4d>(&block.q_frame_from_named[4 * i]) =
          scalar_first(q_frame_from_segment * row.q_frame_from_body);
      Eigen::Map<Vector3>(&block.omega_named_rad_s[3 * i]) = row.omega_body_rad_s.value();
      Eigen::Map<Vector3>(&block.momentum_named[3 * i]).setZero();
    }
  };
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
  rows_(count, block);
  if (covariance_) {
    if (block.sigma_rad.size() < count) {
      block.sigma_rad.resize(count);
      block.covariance_rad2.resize(6 * count);
    }
    covariance_(high, low, block.sigma_rad.data(), block.covariance_rad2.data());
  }
  if (!all_finite({block.q_frame_from_named.data(), 4 * count}) ||
      !all_finite({block.omega_named_rad_s.data(), 3 * count}) ||
      !all_finite({block.momentum_named.data(), 3 * count}) || !all_finite(high) ||
      (covariance_ && !all_finite({block.covariance_rad2.data(), 6 * count}))) {
    throw ComputationError(
        fmt::format("a number among rows {} to {} is not finite; nothing is written", first + 1, first + count));
  }
}

double largest_difference_rad(const Ephemeris& one, const Ephemeris& other) {
  constexpr std::size_t block_rows = 65536;
  AttitudeBlock a, b;
  double worst = 0.0;
  for (std::size_t first = 0; first < one.times().size(); first += block_rows) {
    const std::size_t count = std::min(block_rows, one.times().size() - first);
    one.fill(first, count, {}, a);
    other.fill(first, count, {}, b);
    for (std::size_t i = 0; i < count; ++i) {
      const auto attitude = [i](const AttitudeBlock& block) {
        return from_scalar_first(Eigen::Map<const Eigen::Vector4d>(&block.q_frame_from_named[4 * i]));
      };
      worst = std::max(worst, rotation_angle_rad(attitude(a), attitude(b)));  // fill() lets no NaN pass
    }
  }
  return worst;
}

}  // namespace polhode
