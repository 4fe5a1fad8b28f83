#include "polhode/motion/variation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string_view>

#include "polhode/base/error.hpp"
#include "polhode/motion/variation/orbits.hpp"

namespace polhode {

using variation::AtPoints;
using variation::Grid;
using variation::kCoefficients;
using variation::kDegree;
using variation::kGuess;
using variation::kLast;
using variation::kPoints;
using variation::kRegister;

namespace {

constexpr double kLongestEpoch_rad = 20.0;      // after which the derivatives lose digits
constexpr double kLargestDeviation_rad = 0.02;  // whose square goes into the polynomials
constexpr double kLargestDerivative = 12.0;     // of which rounding is a part
// How near a free motion may be to a rotation about a principal axis or to the separatrix, where its derivatives lose
// digits: nearer than the first it is replaced by one turned aside; where that does not help, as for a sphere, the
// method does not serve.
constexpr double kNear = 1e-4, kTurnedAside_rad = 5e-3, kTooNear = 1e-7;
constexpr double kLeastFromSeparatrix = 1e-10;
constexpr double kPhaseInDoubles = 3e-15;  // of a free motion with plain double constants, and what grows from it
constexpr double kShortestWindow_rad = 0.02;
// Times the fortieth root of the tolerance, 0.6 at 1e-9: runs to two tolerances do not share their windows.
constexpr double kLongestWindow_rad = 20.0;
// From one point to the next a body moves by no more than this part of its distance, times the same root: between two
// points there is no encounter that neither knows of. In a window, by so many times its distance at the beginning.
constexpr double kLongestWay = 3.0, kTimeScales = 5.0, kTimeScalesNearing = 0.9;
constexpr int kMostRounds = 14, kMostFeels = 6;
constexpr double kOrbitShare = 0.1;  // of a window's tolerance, by polynomials of orbits, relative
constexpr double kSeen = 0.1;        // of what is missed, by what was foreseen
constexpr double kPullShare = 6.0;   // what the points miss of an encounter is more than what is foreseen
constexpr double kUnknown = 1e300;
constexpr double kStiffer = 10.0;    // the next window than the last
constexpr double kAtEnd = 0.3;       // how small errors at the ends of windows are kept, so that those between count
constexpr double kLeft = 0.1;        // of what iteration may leave, by rounds that ask for no torque
constexpr double kInner = 0.1;       // likewise, of what feeling the torque again will move
constexpr double kUsualAway = 0.07;  // how far the torque turns the body, of what it could
constexpr double kRounding = 1e-16;  // of a momentum: iteration gets no nearer
constexpr double kMostEvaluationsPerRadian = 100.0;  // beyond which extrapolation is cheaper

const Grid& the_grid() {
  static const Grid grid;
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
long double mean_of_inverse_moments(const Vector3Of<long double>& momentum_body, const Vector3& moments) {
  return momentum_body.dot(momentum_body.cwiseQuotient(moments.cast<long double>())) / momentum_body.squaredNorm();
}

/// From the separatrix: 0 on it, large on the other principal axes.
double from_separatrix(const Vector3& inverse_moments, const Vector3& momentum_body) {
  const Vector3 d = less_mean(inverse_moments, momentum_body.normalized());
  std::array<double, 3> ascending{d[0], d[1], d[2]};
  std::sort(ascending.begin(), ascending.end());
  // On a principal axis of a symmetric body both are 0: there is no separatrix.
  constexpr double least = 1e-30;
  const double scale = inverse_moments.maxCoeff();
  return (std::abs(ascending[1]) / scale + least) / (std::sqrt(-ascending[0] * ascending[2]) / scale + least);
}

/// From rotation about a principal axis and from the separatrix, whichever is nearer: a number up to 1.
double distance_of(const Vector3& inverse_moments, const Vector3& momentum_body) {
  const Vector3 m = momentum_body.normalized(), d = less_mean(inverse_moments, m);
  const double across = d.cwiseProduct(m).norm() / m.cwiseProduct(inverse_moments).norm();
  return across > 0.0 ? std::min(across, from_separatrix(inverse_moments, momentum_body)) : 0.0;
}

/// How long a window may be that begins with a body there: a body that comes nearer, in the direction of the motion's
/// time, is not yet passed at its end.
double reach_s(const Vector3& position_m, const Vector3& velocity_m_s, double direction) {
  const double distance_m = position_m.norm(), speed_m_s = velocity_m_s.norm();
  const double away = std::copysign(1.0, direction) * position_m.dot(velocity_m_s);
  const double nearing = std::min(0.0, away / (distance_m * speed_m_s));
  return (kTimeScales + nearing * (kTimeScales - kTimeScalesNearing)) * distance_m / speed_m_s;
}

/// Of the attitude that differs from a free motion's by a rotation vector 2 sin(angle/2).
template <class Real>
Eigen::Quaternion<Real> deviation(const Vector3Of<Real>& theta) {
  const Vector3Of<Real> half = Real(0.5) * theta;
  return {std::sqrt(std::max(Real(0), 1 - half.squaredNorm())), half[0], half[1], half[2]};
}

}  // namespace

Variation::Epoch::Epoch(double t_s, const FreeBody& start, ThetaMotion::Span span)
    : base_s(t_s),
      momentum(start.q_inertial_from_body.cast<long double>().normalized() * start.momentum_body.cast<long double>()),
      omega(start.q_inertial_from_body * Vector3(start.momentum_body.cwiseQuotient(start.principal_moments))),
      mean_of_inverse_moments(
          polhode::mean_of_inverse_moments(start.momentum_body.cast<long double>(), start.principal_moments)),
      distance(distance_of(start.principal_moments.cwiseInverse(), start.momentum_body)),
      free(ThetaMotion::Unchecked{}, start, span) {
  const Vector3 &moments = start.principal_moments, b = moments.cwiseInverse();
  const Vector3 along = momentum.cast<double>().normalized(), m = start.momentum_body.normalized();
  const Vector3 d = less_mean(b, m);
  variation::Reference& r = reference;
  for (int k = 0; k < 3; ++k) r.moments[k] = moments[k], r.inverse_moments[k] = b[k], r.along[k] = along[k];
  r.magnitude = start.momentum_body.norm();
  r.along_rad_s = omega.dot(along);
  r.across_rad_s = r.magnitude * d.cwiseProduct(m).norm();
  const double by = r.across_rad_s / (d[0] * d[1] * d[2]);
  r.shear_by_swing = by * (b[0] - b[1]) * (b[0] - b[2]) * (b[1] - b[2]);
  r.shear_by_rate = -by / (r.magnitude * r.magnitude * r.magnitude);
  r.shear_at_base = -r.shear_by_swing * m.prod() / (r.across_rad_s * r.across_rad_s);
}

Variation::Coefficients Variation::begin_epoch(double t_s, const Precise& state) {
  const Vector3 momentum = state.momentum_inertial.cast<double>();
  const Quaternion q = state.q_inertial_from_body.cast<double>().normalized();
  const auto distance = [&](const Quaternion& of) {
    return distance_of(moments_.cwiseInverse(), of.conjugate() * momentum);
  };
  Quaternion reference = q;
  if (distance(q) < kNear) {
    for (int i = 0; i < 6; ++i) {
      const double turn_rad = i < 3 ? kTurnedAside_rad : -kTurnedAside_rad;
      const Quaternion aside = q * Quaternion(Eigen::AngleAxisd(turn_rad, Vector3::Unit(i % 3)));
      if (distance(aside) > distance(reference)) reference = aside;
    }
  }
  epochs_.emplace_back(t_s, FreeBody{moments_, reference, reference.conjugate() * momentum}, free_span_);
  Epoch& epoch = epochs_.back();
  const double away_from_separatrix = from_separatrix(moments_.cwiseInverse(), q.conjugate() * momentum);
  epoch.growth = 1.0 / std::sqrt(std::clamp(away_from_separatrix, kLeastFromSeparatrix, 1.0));
  // What leads back from the motion turned aside, or from the roundings.
  const auto away = state.q_inertial_from_body * reference.cast<long double>().normalized().conjugate();
  const Vector3 along = momentum.normalized();
  const Vector3 moved = (state.momentum_inertial - epoch.momentum).cast<double>();
  const Vector3 theta =
      (std::copysign(2.0L, away.w()) * away.vec()).cast<double>() - along.cross(moved) / momentum.norm();
  const Vector3 first = (epoch.omega - epoch.omega.dot(along) * along).normalized();
  Coefficients y;
  y << moved, theta.dot(along), theta.dot(first), theta.dot(along.cross(first));
  return y;
}

void Variation::find_places(const Epoch& epoch, int points, variation::Places& p) const {
  StateArrays out;
  for (int k = 0; k < 4; ++k) out.q[k] = p.q[k];
  out.q_stride = 1;
  epoch.free.batch({{p.since_base_s, static_cast<std::size_t>(points)}}, out);
  kernel_.find_places(epoch.reference, points, p);
}

State Variation::state(const Epoch& epoch, const variation::Places& p, const AtPoints* values, int point) const {
  Vector3 theta;
  kernel_.angle(epoch.reference, p, values, point, theta.data());
  const Quaternion free(p.q[0][point], p.q[1][point], p.q[2][point], p.q[3][point]);
  const Quaternion q = (deviation<double>(theta) * free).normalized();
  const Vector3 moved(values[0][point], values[1][point], values[2][point]);
  return {q, q.conjugate() * Vector3(epoch.momentum.cast<double>() + moved)};
}

Variation::Precise Variation::end_of(const Epoch& epoch, const variation::Places& p, const AtPoints* values) const {
  // The attitudes of a free motion are off by roundings that depend on its phase; those that are of the energy, a few
  // epochs of the same kind would add up, and energy is time.
  using Three = Vector3Of<long double>;
  const auto free =
      Eigen::Quaternion<long double>(p.q[0][kLast], p.q[1][kLast], p.q[2][kLast], p.q[3][kLast]).normalized();
  const Three m = free.conjugate() * epoch.momentum;
  const Vector3 across(p.across[0][kLast], p.across[1][kLast], p.across[2][kLast]);
  const auto excess = static_cast<double>(mean_of_inverse_moments(m, moments_) - epoch.mean_of_inverse_moments);
  const Vector3 back = excess * epoch.reference.magnitude * p.reciprocal_square[kLast] *
                       epoch.momentum.cast<double>().normalized().cross(across);
  Vector3 theta;
  kernel_.angle(epoch.reference, p, values, kLast, theta.data());
  const Vector3 moved(values[0][kLast], values[1][kLast], values[2][kLast]);
  const auto turn = deviation<long double>(0.5L * back.cast<long double>());
  return {turn * deviation<long double>(theta.cast<long double>()) * free, epoch.momentum + moved.cast<long double>()};
}

/// Picard's iteration over one window.
class Variation::Iteration {
 public:
  /// What a window is to keep to, in radians; a momentum counts by its part of the free motion's times a weight.
  struct Demand {
    double length_s, length_rad;
    double within, within_weight;     ///< between the points; the weight: what it turns the body by in the epoch
    double at_end, left, end_weight;  ///< of truncation, and by iterating no longer; by the end of the span
  };

  Iteration(Variation& of, variation::Orbits& orbits)
      : of_(of), kernel_(of.kernel_), orbits_of_(orbits), trajectories_(of.torques_.trajectories().size()) {}

  /// A window from t, of the epoch, with the shear there: places on the orbits and of the free motion.
  void begin(const Epoch& epoch, double t_s, double half_s, double shear) {
    epoch_ = &epoch;
    half_s_ = half_s;
    for (int i = 0; i < kPoints; ++i) {
      places_.since_base_s[i] = (t_s - epoch.base_s) + half_s * (1.0 + the_grid().point[i]);
    }
    for (std::size_t l = 0; l < trajectories_; ++l) {
      orbits_of_.find(l, epoch.base_s, places_.since_base_s, orbits_[l]);
    }
    for (std::size_t i = 0; i < of_.pulls_.size(); ++i) {
      const Torques::Pull& pull = of_.pulls_[i];
      kernel_.find_pull(orbits_[pull.trajectory], std::sqrt(3.0 * pull.mu_m3_s2), pulls_ + 3 * i);
    }
    of_.find_places(epoch, kPoints, places_);
    std::fill(places_.shear, places_.shear + kPoints, shear);
    kernel_.add_products(the_grid().integral, kPoints, &places_.shear_rate, 1, half_s_, &places_.shear);
  }

  /// The largest part of its distance that a body moves from one point of the guess to the next.
  double longest_way() const {
    double square = 0.0;
    for (std::size_t l = 0; l < trajectories_; ++l) {
      double before = 0.0;
      for (int i = 0; i < kGuess; ++i) {
        const double here = 1.0 / square_of_time_scale_s2(l, i);
        const double step_s = i == 0 ? 0.0 : places_.since_base_s[i] - places_.since_base_s[i - 1];
        square = std::max(square, std::max(here, before) * (step_s * step_s));
        before = here;
      }
    }
    return std::sqrt(square);
  }
  /// How long the next window may be.
  double reach_s() const {
    double least_s = kUnknown;
    for (std::size_t l = 0; l < trajectories_; ++l) {
      const AtPoints* v = orbits_[l];
      least_s = std::min(least_s, polhode::reach_s({v[0][kLast], v[1][kLast], v[2][kLast]},
                                                   {v[3][kLast], v[4][kLast], v[5][kLast]}, half_s_));
    }
    return least_s;
  }
  /// What the points will miss of the gravity gradients, before the torque is felt: guesses at the last Legendre
  /// coefficient, from those of the pulls and from those of the free motion's inertia tensor.
  struct Foreseen {
    double of_pulls, of_body;
  };
  Foreseen foresee() const {
    const auto last_of = [this](const AtPoints* values, int components, double* largest) {
      variation::Spectrum spectrum;
      kernel_.find_spectrum(the_grid(), values, components, spectrum);
      double last = *largest = 0.0;
      for (int c = 0; c < components; ++c) {
        last = std::max({last, std::abs(spectrum.coefficients[2][c]), std::abs(spectrum.coefficients[3][c])});
        *largest = std::max(*largest, spectrum.largest[c]);
      }
      return last;
    };
    Foreseen tail{};
    double largest = 0.0;
    const double inertia = last_of(places_.inertia, 6, &largest);
    for (std::size_t k = 0; k < of_.pulls_.size(); ++k) {
      const double pull = last_of(pulls_ + 3 * k, 3, &largest);
      tail.of_pulls += kPullShare * spread_of_moments() * largest * pull;
      tail.of_body += largest * largest * inertia;
    }
    return tail;
  }

  /// From these coefficients at the first point; whether those at the others were found, and the points are dense
  /// enough.
  bool solve(const Coefficients& y, const Demand& demand) {
    start(y);
    const bool knows_gradient = of_.others_.empty();
    const double weight = demand.end_weight + demand.length_rad, steepness = find_steepness(demand.length_rad) * weight;
    const auto round = [&] {
      const Coefficients changes = find_rates_and_integrate();
      moved_ = size(changes, demand.end_weight);
      since_felt_ += moved_;
      const double turned_rad = size(changes, demand.within_weight);
      turned_since_felt_rad_ += turned_rad, turned_since_gradient_rad_ += turned_rad;
      ++rounds_;
    };
    if (knows_gradient ? third_order(usual_away_rad_) * weight > demand.left : felt_twice_) {
      guess();
      round();
    }
    const double rounding = kRounding * demand.end_weight;
    double gain = 1.0, felt_gain = std::min(1.0, kStiffer * felt_gain_), felt_before = 0.0;
    for (int feels = 1; feels <= kMostFeels && !converged_; ++feels) {
      feel(kPoints);
      since_felt_ = turned_since_felt_rad_ = 0.0;
      bool gradient_is_of_before = has_gradient_;
      round();
      const double first_move = moved_;
      measure(demand);
      if (truncation_ > 1.0) return false;
      felt_twice_ = feels > 1;
      if (felt_twice_) felt_gain = felt_gain_ = std::min(1.0, first_move / felt_before);
      felt_before = first_move;
      if (!felt_twice_) gain = std::min(1.0, kStiffer * stiffness_ * moved_);
      // By what the torque may still be off.
      const auto left = [&] {
        if (!knows_gradient) return felt_gain * since_felt_;
        if (!has_gradient_) return steepness * turned_since_felt_rad_;
        return gradient_is_of_before ? steepness * turned_since_felt_rad_ * 2.0 * turned_since_gradient_rad_
                                     : third_order(away_rad_) * weight;
      };
      const double target =
          knows_gradient ? kLeft * demand.left : std::max(kLeft * demand.left, kInner * felt_gain * moved_);
      for (int inner = 0; gain * moved_ > target && moved_ > rounding; ++inner) {
        if (rounds_ >= kMostRounds || (inner > 1 && gain > 0.5)) return false;
        if (!knows_gradient ? !has_gradient_ : left() > target && (!has_gradient_ || gradient_is_of_before)) {
          differentiate();
          gradient_is_of_before = false;
        }
        const double before = moved_;
        round();
        gain = moved_ / before;
        if (inner == 0 && !felt_twice_) stiffness_ = gain / before;
      }
      converged_ = left() <= demand.left || first_move <= rounding;
    }
    measure(demand);
    return converged_ && truncation_ <= 1.0;
  }
  bool converged() const { return converged_; }
  int rounds() const { return rounds_; }
  /// By the points being too few: of what is allowed.
  double truncation() const { return truncation_; }

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

  const variation::Places& places() const { return places_; }
  const AtPoints* values() const { return values_; }

 private:
  double square_of_time_scale_s2(std::size_t trajectory, int i) const {
    const AtPoints* v = orbits_[trajectory];
    return (v[0][i] * v[0][i] + v[1][i] * v[1][i] + v[2][i] * v[2][i]) /
           (v[3][i] * v[3][i] + v[4][i] * v[4][i] + v[5][i] * v[5][i]);
  }

  double spread_of_moments() const { return of_.moments_.maxCoeff() - of_.moments_.minCoeff(); }

  template <class Six>
  double size(const Six& c, double weight) const {
    const double momentum = std::max({std::abs(c[0]), std::abs(c[1]), std::abs(c[2])});
    return std::max({std::abs(c[3]), std::abs(c[4]), std::abs(c[5])}) + momentum / epoch_->reference.magnitude * weight;
  }

  void start(const Coefficients& y) {
    if (has_gradient_) std::memset(felt_.gradient, 0, sizeof felt_.gradient);
    has_gradient_ = is_felt_ = converged_ = false;
    rounds_ = 0;
    start_ = y;
    for (int k = 0; k < kCoefficients; ++k) std::fill(values_[k], values_[k] + kPoints, y[k]);
  }

  /// The torque at so many points.
  void feel(int points) {
    of_.evaluations_ += static_cast<std::size_t>(points - (is_felt_ ? 1 : 0));  // the values at the first stay
    is_felt_ = true;
    kernel_.feel_gravity_gradients(epoch_->reference, places_, pulls_, of_.pulls_.size(), values_, points, felt_);
    if (!of_.others_.empty()) feel_others(points);
  }

  /// The torques other than gravity gradients, one point after the other.
  void feel_others(int points) {
    Torques::Surroundings<double> around;
    for (int i = 0; i < points; ++i) {
      for (std::size_t l = 0; l < trajectories_; ++l) {
        const AtPoints* v = orbits_[l];
        around[l] = {{v[0][i], v[1][i], v[2][i]}, {v[3][i], v[4][i], v[5][i]}};
      }
      const State state = of_.state(*epoch_, places_, values_, i);
      const Matrix3 rotation = state.q_inertial_from_body.toRotationMatrix();
      const Vector3 omega = state.momentum_body.cwiseQuotient(of_.moments_);
      const TorqueTerms<double> terms = of_.others_.at(around, rotation, of_.moments_);
      const Vector3 torque = rotation * terms.torque(omega);
      const Vector3 relaxation = rotation * (terms.relaxation * state.momentum_body.cross(omega));
      for (int k = 0; k < 3; ++k) {
        felt_.torque[k][i] += torque[k];
        felt_.relaxation[k][i] = relaxation[k];
        others_torque_[k][i] = torque[k];
      }
    }
  }

  /// The torque at a few points, and at the others as the polynomial through those has it.
  void guess() {
    feel(kGuess);
    for (AtPoints* of : {felt_.torque, felt_.relaxation}) {
      AtPoints at_few[3];
      std::memcpy(at_few, of, sizeof at_few);
      std::memset(of, 0, sizeof at_few);
      kernel_.add_products(the_grid().interpolation, kGuess, at_few, 3, 1.0, of);
    }
  }

  /// From now on a round knows how the torque goes with the deviation.
  void differentiate() {
    if (!of_.pulls_.empty()) of_.gradients_ += kPoints;
    has_gradient_ = true;
    turned_since_gradient_rad_ = 0.5 * turned_since_felt_rad_;
    kernel_.find_gradients(epoch_->reference, places_, pulls_, of_.pulls_.size(), values_, felt_);
    if (of_.others_.empty()) return;
    // Most of what else there is turns with the body.
    const AtPoints* t = others_torque_;
    for (int i = 0; i < kPoints; ++i) {
      felt_.gradient[1][i] -= t[2][i], felt_.gradient[2][i] += t[1][i];
      felt_.gradient[3][i] += t[2][i], felt_.gradient[5][i] -= t[0][i];
      felt_.gradient[6][i] -= t[1][i], felt_.gradient[7][i] += t[0][i];
    }
  }

  /// By what part of the momentum, at most, the gravity gradients change in the window per angle of the deviation;
  /// their part of the momentum at the points per time and angle; and how far they usually turn the body until there.
  double find_steepness(double length_rad) {
    std::memset(steepness_1_s_, 0, sizeof steepness_1_s_);
    for (std::size_t k = 0; k < 3 * of_.pulls_.size(); ++k) {
      for (int i = 0; i < kPoints; ++i) steepness_1_s_[i] += pulls_[k][i] * pulls_[k][i];
    }
    for (double& s : steepness_1_s_) s *= spread_of_moments() / epoch_->reference.magnitude;
    AtPoints grown[1] = {}, turned[1] = {};
    kernel_.add_products(the_grid().integral, kPoints, &steepness_1_s_, 1, std::abs(half_s_), grown);
    kernel_.add_products(the_grid().integral, kPoints, grown, 1, kUsualAway * 0.5 * length_rad, turned);
    std::copy(turned[0], turned[0] + kPoints, usual_away_rad_);
    return grown[0][kLast];
  }
  /// A bound of the part of the momentum that is missed where the deviation is so far from where the torque was felt:
  /// with the gradient half way, by the third order.
  double third_order(const AtPoints& away_rad) const {
    double sum = 0.0;
    for (int i = 0; i < kPoints; ++i) {
      sum += the_grid().integral[i][kLast] * steepness_1_s_[i] * (away_rad[i] * away_rad[i] * away_rad[i]);
    }
    return std::abs(half_s_) * sum;
  }

  /// By how much the coefficients change.
  Coefficients find_rates_and_integrate() {
    kernel_.find_rates(epoch_->reference, places_, felt_, values_, rates_, away_rad_);
    Coefficients changes;
    kernel_.integrate(the_grid(), rates_, half_s_, start_.data(), values_, changes.data());
    return changes;
  }

  /// The truncation, from the last Legendre coefficients of the rates and of the shear's. Between the points what is
  /// beyond them integrates to less by twice their degree; at the end the first that is missed is of twice that, of
  /// about the size that the fall from half the degree on leads to.
  void measure(const Demand& demand) {
    variation::Spectrum spectrum, of_shear;
    kernel_.find_spectrum(the_grid(), rates_, kCoefficients, spectrum);
    kernel_.find_spectrum(the_grid(), &places_.shear_rate, 1, of_shear);
    double a2 = 0.0;
    for (const double a : values_[5]) a2 = std::max(a2, std::abs(a));
    const double shear = std::max(std::abs(of_shear.coefficients[2][0]), std::abs(of_shear.coefficients[3][0])) * a2 *
                         epoch_->reference.across_rad_s;
    const auto& c = spectrum.coefficients;
    const auto larger = [&](int i, double weight) { return std::max(size(c[i], weight), size(c[i + 1], weight)); };
    const double last = std::max(larger(2, demand.end_weight), shear);
    const double fall = std::min(1.0, last / std::max(larger(0, demand.end_weight), 1e-300));
    const double within = std::max(larger(2, demand.within_weight), shear) / (2 * kDegree);
    truncation_ = std::abs(half_s_) * std::max(last * fall * fall / demand.at_end, within / demand.within);
  }

  Variation& of_;
  const variation::Kernel& kernel_;
  variation::Orbits& orbits_of_;
  std::size_t trajectories_;
  const Epoch* epoch_ = nullptr;
  double half_s_ = 0.0;
  variation::Places places_;
  AtPoints orbits_[Torques::kMostTrajectories][6];  // positions and velocities, inertial
  AtPoints pulls_[3 * Torques::kMostTrajectories];
  variation::Felt felt_;
  AtPoints others_torque_[3];
  Coefficients start_;
  AtPoints values_[kCoefficients], rates_[kCoefficients];
  bool has_gradient_ = false, is_felt_ = false, converged_ = false;
  int rounds_ = 0;
  double moved_ = 0.0, since_felt_ = 0.0, turned_since_felt_rad_ = 0.0, turned_since_gradient_rad_ = 0.0,
         truncation_ = 0.0;
  AtPoints away_rad_, steepness_1_s_, usual_away_rad_;
  // Of windows before: how much less the second round moves than the first, per what that moved; how much less the
  // torque felt anew moves than when it was felt before; and whether it had to be.
  double stiffness_ = kUnknown, felt_gain_ = 1.0;
  bool felt_twice_ = true;
};

Variation::Variation(const FreeBody& start, double start_s, double end_s, const Torques& torques, double tolerance,
                     std::size_t max_torque_evaluations)
    : Variation(start.principal_moments,
                {start.q_inertial_from_body.cast<long double>(), start.momentum_body.cast<long double>()}, start_s,
                end_s, torques.in_principal_axes(start.named_from_principal), tolerance, max_torque_evaluations) {
  checked(start);
}

Variation::Variation(const Vector3& principal_moments, const ExtendedState& start, double start_s, double end_s,
                     const Torques& torques, double tolerance, std::size_t max_torque_evaluations)
    : torques_(torques),
      others_(torques.without_pulls()),
      pulls_(torques.pulls()),
      kernel_(variation::best_kernel()),
      moments_(principal_moments),
      start_s_(start_s),
      start_{start.q_inertial_from_body.normalized().cast<double>(), start.momentum_body.cast<double>()} {
  check_principal_moments(principal_moments);
  check_finite("the start of the variation", start_s);
  check_finite("the end of the variation", end_s);
  if (!(tolerance > 0.0)) throw InputError(fmt::format("the tolerance is {}, a positive one is wanted", tolerance));
  whole_ = start_s == end_s;
  if (whole_ || !(start.momentum_body.norm() > 0.0L) || pulls_.size() > Torques::kMostTrajectories) return;
  const double span_s = std::abs(end_s - start_s);
  const double span_rad = start_.momentum_body.cwiseQuotient(moments_).norm() * span_s;
  if (tolerance < kPhaseInDoubles * (1.0 + span_rad)) free_span_ = ThetaMotion::Span::any;
  const auto q = start.q_inertial_from_body.normalized();
  Coefficients y = begin_epoch(start_s, {q, q * start.momentum_body});
  // A momentum off by a part d turns the body d omega t away in the time that is left; but errors swing.
  const auto weight_for = [this](double time_s) { return std::sqrt(1.0 + epochs_.back().omega.norm() * time_s); };
  const double tolerance_at_end = tolerance / (kAtEnd * weight_for(span_s));
  const double shorter = std::pow(std::min(tolerance, 1e-5), 1.0 / 40.0);
  double t = start_s, shear = epochs_.back().reference.shear_at_base;
  double wanted_rad = shorter * kLongestWindow_rad, converging_rad = kLongestWindow_rad, after_encounter_rad = 0.0;
  double longest_s = kUnknown;
  for (const Trajectory& trajectory : torques_.trajectories()) {
    const OrbitState<double> orbit = trajectory.state(start_s);
    longest_s = std::min(longest_s, reach_s(orbit.position_m, orbit.velocity_m_s, end_s - start_s));
  }
  variation::Orbits orbits(torques_.trajectories(), end_s, kernel_);
  Iteration iteration(*this, orbits);
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
    double length_s = std::min(wanted_rad / rate_rad_s, longest_s);
    if (length_s > 0.999 * remaining_s) {
      length_s = remaining_s;
    } else if (length_s > 0.5 * remaining_s) {
      length_s = 0.5 * remaining_s;  // no sliver at the end
    }
    const double to_s = length_s == remaining_s ? end_s : t + std::copysign(length_s, end_s - start_s);
    const double half_s = 0.5 * (to_s - t), length_rad = length_s * rate_rad_s;
    // Truncation goes this way and that from window to window; what iteration leaves goes one way.
    const double part = length_s / span_s, end_weight = weight_for(remaining_s);
    const Iteration::Demand demand{.length_s = length_s,
                                   .length_rad = length_rad,
                                   .within = tolerance,
                                   .within_weight = 1.0 + rate_rad_s * std::abs(to_s - epoch.base_s),
                                   .at_end = tolerance_at_end * std::sqrt(part) / epoch.growth,
                                   .left = tolerance_at_end * part / epoch.growth,
                                   .end_weight = end_weight};

    orbits.cover(t, to_s, kOrbitShare * demand.at_end);
    iteration.begin(epoch, t, half_s, shear);
    const double way = iteration.longest_way() / (shorter * kLongestWay);
    // An encounter is seen before the torque is felt; when it is over windows are as long as before.
    const Iteration::Foreseen tail = iteration.foresee();
    const double by_tail =
        std::abs(half_s) / epoch.reference.magnitude * demand.within_weight / (2 * kDegree) / tolerance;
    const double by_pulls = by_tail * tail.of_pulls, missed = by_pulls + by_tail * tail.of_body;
    if (way > 1.0 || missed > 1.0) {
      if (way > 1.0 || by_pulls > 0.5 * missed) after_encounter_rad = std::max(after_encounter_rad, wanted_rad);
      wanted_rad = length_rad * std::max(0.1, std::min(0.9 / way, 0.95 * std::pow(missed, -1.0 / 16.0)));
      continue;
    }
    if (!iteration.solve(y, demand)) {
      if (by_pulls < kSeen) after_encounter_rad = 0.0;
      const bool is_too_long = iteration.truncation() > 1.0;
      wanted_rad =
          length_rad * (is_too_long ? std::max(0.3, 0.9 * std::pow(iteration.truncation(), -1.0 / kDegree)) : 0.5);
      if (!is_too_long) converging_rad = wanted_rad;
      continue;
    }
    if (length_rad < 0.99 * wanted_rad) after_encounter_rad = std::max(after_encounter_rad, wanted_rad);
    const double longer = 0.93 * std::pow(std::max(iteration.truncation(), 1e-300), -1.0 / kDegree);
    converging_rad *= iteration.rounds() > kMostRounds / 2 ? 1.1 : 1.5;
    wanted_rad = std::min({std::max(length_rad * std::clamp(longer, 0.4, 3.0), after_encounter_rad),
                           shorter * kLongestWindow_rad, converging_rad});
    after_encounter_rad = 0.0;
    windows_.push_back({t, to_s - t, epochs_.size() - 1, values_.size()});
    for (int k = 0; k <= kCoefficients; ++k) {
      const double* of = k < kCoefficients ? iteration.values()[k] : iteration.places().shear;
      values_.insert(values_.end(), of, of + kPoints);
    }
    t = to_s;
    longest_s = iteration.reach_s();
    for (int k = 0; k < kCoefficients; ++k) y[k] = iteration.values()[k][kLast];
    shear = iteration.places().shear[kLast];
    if (iteration.deviation_rad() > kLargestDeviation_rad || iteration.derivative() > kLargestDerivative ||
        std::abs(t - epoch.base_s) * rate_rad_s > kLongestEpoch_rad) {
      y = begin_epoch(t, end_of(epoch, iteration.places(), iteration.values()));
      shear = epochs_.back().reference.shear_at_base;
    }
  }
  surroundings_ = orbits.asked();
  whole_ = true;
}

State Variation::at(double t_high_s, double t_low_s) const {
  if (windows_.empty()) return start_;
  const double direction = windows_.front().length_s;
  const auto after = std::upper_bound(
      windows_.begin(), windows_.end(), t_high_s,
      [direction](double t, const Window& w) { return direction > 0.0 ? t < w.first_s : t > w.first_s; });
  const Window& window = after == windows_.begin() ? *after : *(after - 1);
  // The barycentric formula (Berrut & Trefethen, SIAM Rev. 46, 501, 2004).
  const double x = 2.0 * ((t_high_s - window.first_s) + t_low_s) / window.length_s - 1.0;
  const Grid& grid = the_grid();
  const double* const values = &values_[window.values];
  double sums[kCoefficients + 1] = {}, weights = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const double away = x - grid.point[i];
    const double weight = away == 0.0 ? 1.0 : grid.barycentric[i] / away;
    if (away == 0.0) std::fill(sums, sums + kCoefficients + 1, weights = 0.0);
    for (int k = 0; k <= kCoefficients; ++k) sums[k] += weight * values[k * kPoints + i];
    weights += weight;
    if (away == 0.0) break;
  }
  const Epoch& epoch = epochs_[window.epoch];
  variation::Places place;
  std::fill(place.since_base_s, place.since_base_s + kRegister, (t_high_s - epoch.base_s) + t_low_s);
  find_places(epoch, kRegister, place);
  AtPoints y[kCoefficients];
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

namespace {

/// Legendre polynomials of degree 0 to kPoints at x.
std::array<double, kPoints + 1> legendre(double x) {
  std::array<double, kPoints + 1> p{1.0, x};
  for (std::size_t k = 1; k < kPoints; ++k) {
    const double degree = static_cast<double>(k);
    p[k + 1] = ((2.0 * degree + 1.0) * x * p[k] - degree * p[k - 1]) / (degree + 1.0);
  }
  return p;
}

}  // namespace

Grid::Grid() {
  constexpr int n = kDegree;
  double ascending[kPoints];
  for (int i = 0; i <= n; ++i) {
    double x = -std::cos(std::numbers::pi * i / n);
    for (int step = 0; step < 20 && i > 0 && i < n; ++step) {
      // Newton's for P_n' = 0, by (1 - x^2) P_n'' = 2 x P_n' - n (n + 1) P_n.
      const auto p = legendre(x);
      const double first = n * (p[n - 1] - x * p[n]);  // times 1 - x^2
      x -= first / (2.0 * x * first / (1.0 - x * x) - n * (n + 1) * p[n]);
    }
    ascending[i] = x;
  }
  int guesses = 0, others = kGuess;
  for (int i = 0; i <= n; ++i) {
    const bool of_guess = i == (2 * guesses * n + (kGuess - 1)) / (2 * (kGuess - 1));
    point[of_guess ? guesses++ : others++] = 0.5 * (ascending[i] - ascending[n - i]);
  }
  for (int j = 0; j <= n; ++j) {
    // Of the polynomial that is 1 at point j and 0 at the others; the norm of the last coefficient is the rule's.
    const auto p = legendre(point[j]);
    const double weight = 2.0 / (n * (n + 1) * p[n] * p[n]);
    double of_degree[kPoints];
    for (int k = 0; k <= n; ++k) of_degree[k] = (k == n ? 0.5 * n : k + 0.5) * weight * p[static_cast<std::size_t>(k)];
    barycentric[j] = 1.0 / p[n];
    const int degrees[4] = {kPoints / 2 - 1, kPoints / 2, n - 1, n};
    for (int k = 0; k < 4; ++k) coefficients[k][j] = of_degree[degrees[k]];
    for (int i = 0; i <= n; ++i) {
      const auto there = legendre(point[i]);
      double sum = of_degree[0] * (1.0 + point[i]);
      for (std::size_t k = 1; k <= n; ++k) {
        sum += of_degree[k] * (there[k + 1] - there[k - 1]) / (2.0 * static_cast<double>(k) + 1.0);
      }
      integral[j][i] = sum;
    }
  }
  for (int j = 0; j < kGuess; ++j) {
    for (int i = 0; i <= n; ++i) {
      interpolation[j][i] = 1.0;
      for (int l = 0; l < kGuess; ++l) {
        if (l != j) interpolation[j][i] *= (point[i] - point[l]) / (point[j] - point[l]);
      }
    }
  }
}

}  // namespace variation

}  // namespace polhode
