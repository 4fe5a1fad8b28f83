#include "polhode/motion/variation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string_view>

#include "polhode/motion/variation/orbits.hpp"

namespace polhode {

using variation::fill_up;
using variation::Grid;
using variation::InSlots;
using variation::kCoarse;
using variation::kCoarseSlots;
using variation::kCoefficients;
using variation::kFine;
using variation::kLast;
using variation::kSlots;
using variation::slot;

namespace {

constexpr double kLongestEpoch_rad = 30.0;      // after which the derivatives lose digits
constexpr double kLargestDeviation_rad = 0.02;  // whose square goes into the polynomials
constexpr double kLargestDerivative = 12.0;     // of which rounding is a part
// How near a free motion may be to a rotation about a principal axis or to the separatrix, where its derivatives lose
// digits: nearer than the first it is replaced by one turned aside; where that does not help, as for a sphere, the
// method does not serve.
constexpr double kNear = 1e-4, kTurnedAside_rad = 5e-3, kTooNear = 1e-7;
constexpr double kShortestWindow_rad = 0.02;
// Times the fortieth root of the tolerance, 0.6 at 1e-9: runs to two tolerances do not share their windows.
constexpr double kLongestWindow_rad = 20.0, kFirstWindow_rad = 5.0;
// From one point to the next a body moves by no more than this part of its distance, times the same root: between two
// points there is no encounter that neither knows of.
constexpr double kLongestWay = 1.5;
constexpr int kMostSweeps = 9;
constexpr double kDecayed = 0.03;    // coefficients that tell of those that follow
constexpr double kOrbitShare = 0.1;  // of a window's tolerance, by polynomials of orbits, relative
constexpr double kUnknown = 1e300;
constexpr double kStiffer = 10.0;                   // the next window than any before
constexpr double kLeft = 0.3;                       // of a window's share of the tolerance, by the iteration
constexpr double kMostEvaluationsPerRadian = 70.0;  // beyond which extrapolation is cheaper

/// Point i of the Chebyshev grid of degree n on (-1, 1), ascending; n divides kFine.
double chebyshev_point(int i, int n) {
  static const auto points = [] {
    std::array<double, kFine + 1> x;
    for (int k = 0; k <= kFine; ++k) x[static_cast<std::size_t>(k)] = -std::cos(std::numbers::pi * k / kFine);
    return x;
  }();
  const int fine = i * (kFine / n);
  return points[static_cast<std::size_t>(fine)];
}

const Grid& coarse_grid() {
  static const Grid grid(kCoarse);
  return grid;
}
const Grid& fine_grid() {
  static const Grid grid(kFine);
  return grid;
}

/// b less its mean over the components of a unit momentum, from differences: near a principal axis one of them is far
/// smaller than b.
Vector3 less_mean(const Vector3& b, const Vector3& m) {
  const Vector3 p = m.cwiseAbs2();
  return {p[1] * (b[0] - b[1]) + p[2] * (b[0] - b[2]), p[2] * (b[1] - b[2]) + p[0] * (b[1] - b[0]),
          p[0] * (b[2] - b[0]) + p[1] * (b[2] - b[1])};
}

/// Twice the energy over the square of the momentum, whatever the length of either is by rounding.
double mean_of_inverse_moments(const Vector3& momentum_body, const Vector3& moments) {
  return momentum_body.dot(momentum_body.cwiseQuotient(moments)) / momentum_body.squaredNorm();
}

/// From rotation about a principal axis and from the separatrix, whichever is nearer: a number up to 1.
double distance_of(const Vector3& inverse_moments, const Vector3& momentum_body) {
  const Vector3 m = momentum_body.normalized(), d = less_mean(inverse_moments, m);
  const double across = d.cwiseProduct(m).norm() / m.cwiseProduct(inverse_moments).norm();
  std::array<double, 3> ascending{d[0], d[1], d[2]};
  std::sort(ascending.begin(), ascending.end());
  const double from_separatrix = std::abs(ascending[1]) / std::sqrt(-ascending[0] * ascending[2]);
  return across > 0.0 ? std::min(across, from_separatrix) : 0.0;
}

/// Of the attitude that differs from a free motion's by a rotation vector 2 sin(angle/2).
Quaternion deviation(const double* theta) {
  const double s = 0.25 * (theta[0] * theta[0] + theta[1] * theta[1] + theta[2] * theta[2]);
  return {std::sqrt(std::max(0.0, 1.0 - s)), 0.5 * theta[0], 0.5 * theta[1], 0.5 * theta[2]};
}

}  // namespace

Variation::Epoch::Epoch(double t_s, const Vector3& moments, const Quaternion& q, const Vector3& momentum_inertial)
    : base_s(t_s),
      momentum(momentum_inertial),
      omega(q * Vector3((q.conjugate() * momentum).cwiseQuotient(moments))),
      mean_of_inverse_moments(polhode::mean_of_inverse_moments(q.conjugate() * momentum, moments)),
      distance(distance_of(moments.cwiseInverse(), q.conjugate() * momentum)),
      free({moments, q, q.conjugate() * momentum}, ThetaMotion::Span::step) {
  const Vector3 b = moments.cwiseInverse(), along = momentum.normalized(), m = q.conjugate() * along;
  const Vector3 d = less_mean(b, m);
  variation::Reference& r = reference;
  for (int k = 0; k < 3; ++k) r.moments[k] = moments[k], r.inverse_moments[k] = b[k], r.along[k] = along[k];
  r.magnitude = momentum.norm();
  r.along_rad_s = omega.dot(along);
  r.across_rad_s = r.magnitude * d.cwiseProduct(m).norm();
  const double by = r.across_rad_s / (d[0] * d[1] * d[2]);
  r.shear_by_swing = by * (b[0] - b[1]) * (b[0] - b[2]) * (b[1] - b[2]);
  r.shear_by_rate = -by / (r.magnitude * r.magnitude * r.magnitude);
  r.shear_at_base = -r.shear_by_swing * m.prod() / (r.across_rad_s * r.across_rad_s);
}

Variation::Coefficients Variation::begin_epoch(double t_s, const Quaternion& q, const Vector3& momentum_inertial) {
  Coefficients y = Coefficients::Zero();
  const auto distance = [&](const Quaternion& of) {
    return distance_of(moments_.cwiseInverse(), of.conjugate() * momentum_inertial);
  };
  Quaternion reference = q;
  if (distance(q) < kNear) {
    for (int i = 0; i < 6; ++i) {
      const double turn_rad = i < 3 ? kTurnedAside_rad : -kTurnedAside_rad;
      const Quaternion aside = q * Quaternion(Eigen::AngleAxisd(turn_rad, Vector3::Unit(i % 3)));
      if (distance(aside) > distance(reference)) reference = aside;
    }
  }
  const bool is_aside = distance(reference) > distance(q);
  epochs_.emplace_back(t_s, moments_, reference, momentum_inertial);
  const Epoch& epoch = epochs_.back();
  if (!is_aside || epoch.distance < kTooNear) return y;
  // What leads back from the motion turned aside.
  const Quaternion away = q * reference.conjugate();
  const Vector3 theta = std::copysign(2.0, away.w()) * away.vec();
  const Vector3 along = momentum_inertial.normalized();
  const Vector3 first = (epoch.omega - epoch.omega.dot(along) * along).normalized();
  y[3] = theta.dot(along);
  y[4] = theta.dot(first);
  y[5] = theta.dot(along.cross(first));
  return y;
}

void Variation::find_places(const Epoch& epoch, int from, int to, variation::Places& p) const {
  StateArrays out;
  for (int k = 0; k < 4; ++k) out.q[k] = p.q[k] + from;
  out.q_stride = 1;
  epoch.free.batch({{p.since_base_s + from, static_cast<std::size_t>(to - from)}}, out);
  kernel_.find_places(epoch.reference, from, to, p);
}

FreeState Variation::state(const Epoch& epoch, const variation::Places& p, const double (*values)[kSlots],
                           int in_slot) const {
  double theta[3];
  kernel_.angle(epoch.reference, p, values, in_slot, theta);
  const Quaternion free(p.q[0][in_slot], p.q[1][in_slot], p.q[2][in_slot], p.q[3][in_slot]);
  const Quaternion q = (deviation(theta) * free).normalized();
  const Vector3 moved(values[0][in_slot], values[1][in_slot], values[2][in_slot]);
  return {q, q.conjugate() * Vector3(epoch.momentum + moved)};
}

Quaternion Variation::end_of(const Epoch& epoch, const variation::Places& p, const InSlots* values) const {
  // The attitudes of a free motion are off by roundings that depend on its phase; those that are of the energy, a few
  // epochs of the same kind would add up, and energy is time.
  const Quaternion free = Quaternion(p.q[0][kLast], p.q[1][kLast], p.q[2][kLast], p.q[3][kLast]).normalized();
  const Vector3 m = free.conjugate() * epoch.momentum,
                across(p.across[0][kLast], p.across[1][kLast], p.across[2][kLast]);
  const double excess = mean_of_inverse_moments(m, moments_) - epoch.mean_of_inverse_moments;
  const Vector3 back =
      0.5 * excess * epoch.reference.magnitude * p.reciprocal_square[kLast] * epoch.momentum.normalized().cross(across);
  const Quaternion turn(1.0, 0.5 * back[0], 0.5 * back[1], 0.5 * back[2]);
  return (turn * state(epoch, p, values, kLast).q_inertial_from_body).normalized();
}

/// Picard's iteration over one window.
class Variation::Sweeps {
 public:
  Sweeps(Variation& of, variation::Orbits& orbits)
      : of_(of), kernel_(of.kernel_), orbits_of_(orbits), trajectories_(of.torques_.trajectories().size()) {}

  /// A window from t, of the epoch, with the coefficients and the shear there: the coarse grid alone.
  void begin(const Epoch& epoch, double t_s, double half_s, const Coefficients& y, double shear) {
    epoch_ = &epoch;
    half_s_ = half_s;
    shear_ = shear;
    grid_ = &coarse_grid();
    if (relaxes_) felt_ = {};
    first_is_known_ = false;
    for (int i = 0; i <= kFine; ++i) {
      places_.since_base_s[slot(i)] = (t_s - epoch.base_s) + half_s * (1.0 + chebyshev_point(i, kFine));
    }
    fill_up(places_.since_base_s);
    for (int k = 0; k < kCoefficients; ++k) {
      std::fill(start_[k], start_[k] + kSlots, y[k]);
      std::fill(values_[k], values_[k] + kSlots, y[k]);
    }
    find_places(0, kCoarseSlots);
    find_orbits(0, kCoarseSlots);
  }

  /// From now on all points.
  void refine() {
    grid_ = &fine_grid();
    find_places(kCoarseSlots, kSlots);
    find_orbits(kCoarseSlots, kSlots);
    for (InSlots& values : values_) std::fill(values + kCoarseSlots, values + kSlots, 0.0);
    kernel_.add_products(values_, kCoefficients, coarse_grid().rows, coarse_grid().interpolation, kCoarseSlots, kSlots,
                         1.0, values_);
  }

  /// Takes the torque at the points of `grid` anew, then all rates; how far the coefficients moved.
  Coefficients sweep(const Grid& grid) {
    of_.evaluations_ += static_cast<std::size_t>(grid.degree + (first_is_known_ ? 0 : 1));
    first_is_known_ = true;  // the values there stay
    const bool all = grid.degree == grid_->degree;
    variation::Felt& felt = all ? felt_ : felt_anew_;
    std::memset(felt.torque, 0, sizeof felt.torque);
    if (!of_.pulls_.empty()) {
      kernel_.add_gravity_gradients(epoch_->reference, places_, pulls_, of_.pulls_.size(), values_, grid.slots,
                                    felt.torque);
    }
    if (!of_.others_.empty()) feel_others(grid, felt);
    if (!all) {
      const auto correct = [&](InSlots* now, InSlots* known) {
        for (int k = 0; k < 3; ++k) {
          for (int i = 0; i < kCoarseSlots; ++i) {
            now[k][i] -= known[k][i];
            known[k][i] += now[k][i];
          }
        }
        kernel_.add_products(now, 3, grid.rows, grid.interpolation, kCoarseSlots, kSlots, 1.0, known);
      };
      correct(felt.torque, felt_.torque);
      if (relaxes_) correct(felt.relaxation, felt_.relaxation);
    }
    kernel_.find_rates(epoch_->reference, places_, felt_, values_, grid_->slots, rates_);
    Coefficients changes;
    kernel_.integrate(*grid_, rates_, half_s_, start_, values_, changes.data());
    return changes;
  }

  /// The largest part of its distance that a body moves from one coarse point to the next.
  double longest_way() const {
    double square = 0.0;
    for (std::size_t l = 0; l < trajectories_; ++l) {
      const InSlots* v = orbits_[l];
      double before = 0.0;
      for (int i = 0; i <= kLast; ++i) {
        const double r2 = v[0][i] * v[0][i] + v[1][i] * v[1][i] + v[2][i] * v[2][i];
        const double v2 = v[3][i] * v[3][i] + v[4][i] * v[4][i] + v[5][i] * v[5][i];
        const double here = v2 / r2, step_s = i == 0 ? 0.0 : places_.since_base_s[i] - places_.since_base_s[i - 1];
        square = std::max(square, std::max(here, before) * (step_s * step_s));
        before = here;
      }
    }
    return std::sqrt(square);
  }

  variation::Spectrum spectrum() const {
    variation::Spectrum spectrum;
    kernel_.find_spectrum(*grid_, rates_, spectrum);
    return spectrum;
  }
  /// Of the shear's rate: the larger of the last two Chebyshev coefficients, times what it is multiplied by.
  double shear_tail() const {
    double last[2] = {}, a2 = 0.0;
    for (int j = 0; j < grid_->slots; ++j) {
      for (int l = 0; l < 2; ++l) last[l] += grid_->coefficients[2 + l][j] * places_.shear_rate[j];
      a2 = std::max(a2, std::abs(values_[5][j]));
    }
    return std::max(std::abs(last[0]), std::abs(last[1])) * a2 * epoch_->reference.across_rad_s;
  }
  /// At the end of the window: the angle of the deviation, and the larger of the derivatives.
  double deviation_rad() const {
    Vector3 theta;
    kernel_.angle(epoch_->reference, places_, values_, kLast, theta.data());
    return theta.norm();
  }
  double derivative() const {
    const double across = 1.0 / std::sqrt(places_.reciprocal_square[kLast]);
    const double first = across / epoch_->reference.across_rad_s;
    return std::max(first, std::hypot(1.0 / first, (places_.shear_swing[kLast] + places_.shear[kLast]) * across));
  }

  const Grid& grid() const { return *grid_; }
  bool on_all_points() const { return grid_->degree == kFine; }
  const variation::Places& places() const { return places_; }
  const InSlots* values() const { return values_; }

 private:
  void find_places(int from, int to) {
    of_.find_places(*epoch_, from, to, places_);
    std::fill(places_.shear, places_.shear + kSlots, shear_);
    kernel_.add_products(&places_.shear_rate, 1, grid_->rows, grid_->integral, 0, grid_->slots, half_s_,
                         &places_.shear);
  }

  void find_orbits(int from, int to) {
    for (std::size_t l = 0; l < trajectories_; ++l) {
      orbits_of_.find(l, epoch_->base_s, places_.since_base_s, from, to, orbits_[l]);
    }
    for (std::size_t i = 0; i < of_.pulls_.size(); ++i) {
      const Torques::Pull& pull = of_.pulls_[i];
      kernel_.find_pull(orbits_[pull.trajectory], std::sqrt(3.0 * pull.mu_m3_s2), from, to, pulls_ + 3 * i);
    }
  }

  /// The torques other than gravity gradients, one point after the other.
  void feel_others(const Grid& grid, variation::Felt& felt) {
    relaxes_ = false;
    Torques::Surroundings<double> around;
    for (int j = 0; j <= grid.degree; ++j) {
      const int i = slot(j * (kFine / grid.degree));
      for (std::size_t l = 0; l < trajectories_; ++l) {
        const InSlots* v = orbits_[l];
        around[l] = {{v[0][i], v[1][i], v[2][i]}, {v[3][i], v[4][i], v[5][i]}};
      }
      const FreeState state = of_.state(*epoch_, places_, values_, i);
      const Matrix3 rotation = state.q_inertial_from_body.toRotationMatrix();
      const Vector3 omega = state.momentum_body.cwiseQuotient(of_.moments_);
      const TorqueTerms<double> terms = of_.others_.at(around, rotation, of_.moments_);
      const Vector3 torque = rotation * terms.torque(omega);
      for (int k = 0; k < 3; ++k) felt.torque[k][i] += torque[k];
      if (terms.relaxation == 0.0) continue;
      relaxes_ = true;
      const Vector3 relaxation = rotation * (terms.relaxation * state.momentum_body.cross(omega));
      for (int k = 0; k < 3; ++k) felt.relaxation[k][i] = relaxation[k];
    }
  }

  Variation& of_;
  const variation::Kernel& kernel_;
  variation::Orbits& orbits_of_;
  std::size_t trajectories_;
  const Epoch* epoch_ = nullptr;
  double half_s_ = 0.0, shear_ = 0.0;
  const Grid* grid_ = nullptr;
  bool relaxes_ = false, first_is_known_ = false;
  variation::Places places_;
  InSlots orbits_[Torques::kMostTrajectories][6];  // positions and velocities, inertial
  InSlots pulls_[3 * Torques::kMostTrajectories];
  variation::Felt felt_, felt_anew_;
  InSlots start_[kCoefficients], values_[kCoefficients], rates_[kCoefficients];
};

Variation::Variation(const FreeBody& start, double start_s, double end_s, const Torques& torques, double tolerance,
                     std::size_t max_torque_evaluations)
    : torques_(torques),
      others_(torques.without_pulls()),
      pulls_(torques.pulls()),
      kernel_(variation::best_kernel()),
      moments_(start.principal_moments),
      start_s_(start_s),
      start_{start.q_inertial_from_body.normalized(), start.momentum_body} {
  whole_ = start_s == end_s;
  if (whole_ || !(start.momentum_body.norm() > 0.0) || pulls_.size() > Torques::kMostTrajectories) return;
  const double span_s = std::abs(end_s - start_s);
  Coefficients y =
      begin_epoch(start_s, start_.q_inertial_from_body, start_.q_inertial_from_body * start_.momentum_body);
  double t = start_s, shear = epochs_.back().reference.shear_at_base;
  double stiffness = kUnknown;
  const double shorter = std::pow(std::min(tolerance, 1e-5), 1.0 / 40.0);
  double wanted_rad = shorter * kFirstWindow_rad;
  variation::Orbits orbits(torques_.trajectories(), end_s, kernel_);
  Sweeps sweeps(*this, orbits);
  while (t != end_s) {
    surroundings_ = orbits.asked();
    const Epoch& epoch = epochs_.back();
    if (epoch.distance < kTooNear) return;
    const double rate_rad_s = epoch.omega.norm();
    if (evaluations_ > max_torque_evaluations || !(wanted_rad > kShortestWindow_rad) ||
        static_cast<double>(evaluations_) > 1000.0 + kMostEvaluationsPerRadian * rate_rad_s * std::abs(t - start_s)) {
      return;
    }
    const double remaining_s = std::abs(end_s - t);
    double length_s = wanted_rad / rate_rad_s;
    if (length_s > 0.999 * remaining_s) {
      length_s = remaining_s;
    } else if (length_s > 0.5 * remaining_s) {
      length_s = 0.5 * remaining_s;  // no sliver at the end
    }
    const double to_s = length_s == remaining_s ? end_s : t + std::copysign(length_s, end_s - start_s);
    const double half_s = 0.5 * (to_s - t);
    const double allowed = tolerance * std::sqrt(length_s / span_s);
    // A momentum off by a part d turns the body d omega t away in the time that is left; but errors swing.
    const double weight = std::sqrt(1.0 + rate_rad_s * remaining_s);
    const auto size = [&](const auto& c) {
      const double momentum = std::max({std::abs(c[0]), std::abs(c[1]), std::abs(c[2])});
      return std::max({std::abs(c[3]), std::abs(c[4]), std::abs(c[5])}) + momentum / epoch.reference.magnitude * weight;
    };
    // What is beyond degree n integrates to less by n^2 at the end, where errors go on, and by 2n between the points.
    const auto truncation_of = [&](double last_coefficient, int n) {
      const double tail = std::abs(half_s) * last_coefficient;
      return std::max(tail / (n * n) / allowed, tail / (2 * n) / weight / tolerance);
    };

    orbits.cover(t, to_s, kOrbitShare * allowed);
    sweeps.begin(epoch, t, half_s, y, shear);
    const double way = sweeps.longest_way() / (shorter * kLongestWay);
    if (way > 1.0) {
      wanted_rad = length_s * rate_rad_s * std::max(0.1, 0.9 / way);
      continue;
    }
    double before = 0.0, moved = size(sweeps.sweep(coarse_grid()));
    int count = 1;
    // Each sweep moves less than the last in about the same ratio; what is left after one is about the next.
    const auto left = [&] {
      return moved * std::min(1.0, count == 1 ? kStiffer * stiffness * moved / weight : moved / before);
    };
    double truncation = 0.0, missed_by_coarse = 0.0;
    const auto resolved = [&] {
      const variation::Spectrum spectrum = sweeps.spectrum();
      const auto& c = spectrum.coefficients;
      const double last = std::max({size(c[2]), size(c[3]), sweeps.shear_tail()}), largest = size(spectrum.largest);
      truncation = truncation_of(last, sweeps.grid().degree);
      missed_by_coarse = 3.0 * std::max(size(c[0]), size(c[1])) / largest;
      return truncation <= 1.0 && (sweeps.on_all_points() || last <= kDecayed * largest);
    };
    bool good = resolved();
    for (;;) {
      if (!good) {
        if (sweeps.on_all_points()) break;
        sweeps.refine();
        before = moved;
        moved = size(sweeps.sweep(fine_grid()));
        ++count;
        good = resolved();
        continue;
      }
      for (; left() > kLeft * allowed && count < kMostSweeps && (count == 1 || moved < 0.5 * before); ++count) {
        const bool coarse_will_do =
            sweeps.on_all_points() && left() * std::max(missed_by_coarse, moved / before) <= kLeft * allowed;
        before = moved;
        moved = size(sweeps.sweep(coarse_will_do ? coarse_grid() : sweeps.grid()));
        if (count == 1) {
          stiffness = std::max(stiffness == kUnknown ? 0.0 : stiffness, moved / before / (before / weight));
        }
      }
      if (sweeps.on_all_points()) break;
      // With the first sweep alone the square of the deviation was not yet seen.
      good = resolved();
      if (good) break;
    }
    if (!good) {
      wanted_rad = length_s * rate_rad_s * std::clamp(0.9 * std::pow(truncation, -1.0 / kCoarse), 0.3, 0.9);
      continue;
    }
    const bool converged = left() <= kLeft * allowed;
    const double factor = converged ? 0.9 * std::pow(std::max(truncation, 1e-300), -1.0 / sweeps.grid().degree) : 0.5;
    wanted_rad = std::min(length_s * rate_rad_s * std::clamp(factor, 0.4, 1.6), shorter * kLongestWindow_rad);
    if (!converged) continue;
    windows_.push_back({t, to_s - t, epochs_.size() - 1, values_.size(), sweeps.grid().degree});
    for (int k = 0; k <= kCoefficients; ++k) {
      const double* of = k < kCoefficients ? sweeps.values()[k] : sweeps.places().shear;
      values_.insert(values_.end(), of, of + kCoarse + 1);
      if (sweeps.on_all_points()) values_.insert(values_.end(), of + kCoarseSlots, of + kCoarseSlots + kCoarse);
    }
    t = to_s;
    for (int k = 0; k < kCoefficients; ++k) y[k] = sweeps.values()[k][kLast];
    shear = sweeps.places().shear[kLast];
    if (sweeps.deviation_rad() > kLargestDeviation_rad || sweeps.derivative() > kLargestDerivative ||
        std::abs(t - epoch.base_s) * rate_rad_s > kLongestEpoch_rad) {
      y = begin_epoch(t, end_of(epoch, sweeps.places(), sweeps.values()), epoch.momentum + y.head<3>());
      shear = epochs_.back().reference.shear_at_base;
    }
  }
  surroundings_ = orbits.asked();
  whole_ = true;
}

FreeState Variation::at(double t_high_s, double t_low_s) const {
  if (windows_.empty()) return start_;
  const double direction = windows_.front().length_s;
  const auto after = std::upper_bound(
      windows_.begin(), windows_.end(), t_high_s,
      [direction](double t, const Window& w) { return direction > 0.0 ? t < w.first_s : t > w.first_s; });
  const Window& window = after == windows_.begin() ? *after : *(after - 1);
  // The barycentric formula (Berrut & Trefethen, SIAM Rev. 46, 501, 2004).
  const double x = 2.0 * ((t_high_s - window.first_s) + t_low_s) / window.length_s - 1.0;
  const int n = window.degree;
  const double* const values = &values_[window.values];
  double sums[kCoefficients + 1] = {}, weights = 0.0;
  for (int i = 0; i <= n; ++i) {
    const double away = x - chebyshev_point(i, n);
    const double* const here = values + (n == kFine && i % 2 == 1 ? kCoarse + 1 + i / 2 : i * kCoarse / n);
    const double weight = away == 0.0 ? 1.0 : (i % 2 == 0 ? 1.0 : -1.0) * (i == 0 || i == n ? 0.5 : 1.0) / away;
    if (away == 0.0) std::fill(sums, sums + kCoefficients + 1, weights = 0.0);
    for (int k = 0; k <= kCoefficients; ++k) sums[k] += weight * here[k * (n + 1)];
    weights += weight;
    if (away == 0.0) break;
  }
  const Epoch& epoch = epochs_[window.epoch];
  variation::Places place;
  constexpr int kRegister = 8;
  std::fill(place.since_base_s, place.since_base_s + kRegister, (t_high_s - epoch.base_s) + t_low_s);
  find_places(epoch, 0, kRegister, place);
  InSlots y[kCoefficients];
  for (int k = 0; k < kCoefficients; ++k) y[k][0] = sums[k] / weights;
  place.shear[0] = sums[kCoefficients] / weights;
  return state(epoch, place, y, 0);
}

namespace variation {

extern const Kernel k_kernel_baseline;
#ifdef POLHODE_X86_TARGETS
extern const Kernel k_kernel_avx2;
extern const Kernel k_kernel_avx512;
#endif

std::vector<const Kernel*> kernels() {
  std::vector<const Kernel*> all{&k_kernel_baseline};
#ifdef POLHODE_X86_TARGETS
  const theta::Target* targets[3];
  const std::size_t count = theta::targets(targets);
  for (std::size_t i = 0; i < count; ++i) {
    for (const Kernel* kernel : {&k_kernel_avx2, &k_kernel_avx512}) {
      if (std::string_view(targets[i]->name) == kernel->name) all.push_back(kernel);
    }
  }
#endif
  return all;
}

const Kernel& best_kernel() {
  for (const Kernel* kernel : kernels()) {
    if (std::string_view(ThetaMotion::best_target().name) == kernel->name) return *kernel;
  }
  return k_kernel_baseline;
}

Grid::Grid(int n)
    : degree(n), rows(n == kFine ? slot(kFine - 1) + 1 : n + 1), slots(n == kFine ? kSlots : kCoarseSlots) {
  for (int j = 0; j <= n; ++j) {
    const int in_slot = slot(j * (kFine / n));
    // Of the polynomial that is 1 at point j and 0 at the others.
    std::array<double, kFine + 3> value{}, sum{};
    const auto ends = [n](int i) { return i == 0 || i == n ? 0.5 : 1.0; };
    for (int k = 0; k <= n; ++k) {
      value[k] = 2.0 / n * ends(j) * ends(k) * std::cos(std::numbers::pi * k * (n - j) / n);
    }
    for (int k = 1; k <= n + 1; ++k) {
      sum[k] = ((k == 1 ? 2.0 : 1.0) * value[k - 1] - value[k + 1]) / (2.0 * k);
      sum[0] += k % 2 == 0 ? -sum[k] : sum[k];
    }
    for (int k = 0; k < 4; ++k) coefficients[k][in_slot] = value[k < 2 ? n / 2 + k : n - 3 + k];
    for (int i = 0; i <= kFine; ++i) {
      const double angle = std::numbers::pi * (kFine - i) / kFine;
      for (int k = 0; k <= n + 1; ++k) {
        interpolation[in_slot][slot(i)] += value[k] * std::cos(k * angle);
        integral[in_slot][slot(i)] += sum[k] * std::cos(k * angle);
      }
    }
    fill_up(interpolation[in_slot]);
    fill_up(integral[in_slot]);
  }
}

}  // namespace variation

}  // namespace polhode
