#include "polhode/motion/variation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace polhode {
namespace {

constexpr int kFinest = Variation::kDegree;
// Of neighbours, times the sixteenth root of the tolerance: 1e-3 at 1e-10. Its sixth power and a rounding divided by it
// are below 1e-12, and runs to two tolerances do not share the error.
constexpr double kDifference_rad = 4e-3;
constexpr double kTurns[] = {-3.0, -2.0, -1.0, 1.0, 2.0, 3.0};  // of neighbours, in that unit
constexpr double kLongestEpoch_rad = 10.0;                      // after which the derivatives lose digits
constexpr double kLargestDeviation_rad = 0.02;                  // whose square goes into the polynomials
constexpr double kLargestDerivative = 12.0;  // of which the seventh power measures the error of the derivatives
constexpr double kLongestWindow_rad = 14.0, kShortestWindow_rad = 0.02;
constexpr double kTimeScaleShare = 0.7;  // of a window in r/v: an encounter is never stepped over
constexpr int kMostSweeps = 9;
constexpr double kLeft = 0.3;                       // of a window's share of the tolerance, by the iteration
constexpr double kMostEvaluationsPerRadian = 70.0;  // beyond which extrapolation is cheaper

/// Point i of the Chebyshev grid of degree n on (-1, 1), ascending.
double chebyshev_point(int i, int n) { return -std::cos(std::numbers::pi * i / n); }

/// From values at the points of a Chebyshev grid: values of the polynomial through them, and of its integral from the
/// first point, at the points of the finest grid; and four of its Chebyshev coefficients (Clenshaw & Curtis, Numer.
/// Math. 2, 197, 1960). Row j is what the value at point j contributes.
struct Grid {
  int degree, stride;  // stride in points of the finest grid
  double interpolation[kFinest + 1][kFinest + 2] = {}, integral[kFinest + 1][kFinest + 2] = {};
  double coefficients[kFinest + 1][4] = {};  // of degree n/2, n/2 + 1, n - 1, n

  explicit Grid(int n) : degree(n), stride(kFinest / n) {
    for (int j = 0; j <= n; ++j) {
      // Of the polynomial that is 1 at point j and 0 at the others.
      std::array<double, kFinest + 3> value{}, sum{};
      const auto ends = [n](int i) { return i == 0 || i == n ? 0.5 : 1.0; };
      for (int k = 0; k <= n; ++k) {
        value[k] = 2.0 / n * ends(j) * ends(k) * std::cos(std::numbers::pi * k * (n - j) / n);
      }
      for (int k = 1; k <= n + 1; ++k) {
        sum[k] = ((k == 1 ? 2.0 : 1.0) * value[k - 1] - value[k + 1]) / (2.0 * k);
        sum[0] += k % 2 == 0 ? -sum[k] : sum[k];
      }
      for (int k = 0; k < 4; ++k) coefficients[j][k] = value[k < 2 ? n / 2 + k : n - 3 + k];
      for (int i = 0; i <= kFinest; ++i) {
        const double angle = std::numbers::pi * (kFinest - i) / kFinest;
        for (int k = 0; k <= n + 1; ++k) {
          interpolation[j][i] += value[k] * std::cos(k * angle);
          integral[j][i] += sum[k] * std::cos(k * angle);
        }
      }
    }
  }
};

/// q turned about an inertial axis.
Quaternion turned(const Vector3& rotation_vector, const Quaternion& q) {
  const double half = 0.5 * rotation_vector.norm();
  if (half == 0.0) return q;
  const Vector3 v = std::sin(half) / (2.0 * half) * rotation_vector;
  return Quaternion(std::cos(half), v[0], v[1], v[2]) * q;
}

/// The rotation vector, inertial, that turns b into a.
Vector3 rotation_vector(const Quaternion& a, const Quaternion& b) {
  const Quaternion d = a * b.conjugate();
  const double sine = d.vec().norm();
  if (sine == 0.0) return Vector3::Zero();
  return std::copysign(2.0 * std::atan2(sine, std::abs(d.w())) / sine, d.w()) * d.vec();
}

ThetaMotion neighbour(const Vector3& moments, const Quaternion& q, const Vector3& momentum_inertial,
                      const Vector3& rotation_vector) {
  const Quaternion start = turned(rotation_vector, q);
  return ThetaMotion({moments, start, start.conjugate() * momentum_inertial}, ThetaMotion::Span::step);
}

}  // namespace

Variation::Epoch::Epoch(double t_s, const Vector3& moments, const Quaternion& q, const Vector3& momentum_inertial,
                        double difference_rad)
    : base_s(t_s),
      momentum(momentum_inertial),
      magnitude(momentum.norm()),
      along(momentum / magnitude),
      omega(q * Vector3((q.conjugate() * momentum).cwiseQuotient(moments))),
      across_rad_s((omega - omega.dot(along) * along).norm()),
      first(across_rad_s > 1e-4 * omega.norm() ? Vector3((omega - omega.dot(along) * along) / across_rad_s)
                                               : along.unitOrthogonal()),
      second(along.cross(first)),
      free({moments, q, q.conjugate() * momentum}, ThetaMotion::Span::step),
      about_second{neighbour(moments, q, momentum, kTurns[0] * difference_rad * second),
                   neighbour(moments, q, momentum, kTurns[1] * difference_rad * second),
                   neighbour(moments, q, momentum, kTurns[2] * difference_rad * second),
                   neighbour(moments, q, momentum, kTurns[3] * difference_rad * second),
                   neighbour(moments, q, momentum, kTurns[4] * difference_rad * second),
                   neighbour(moments, q, momentum, kTurns[5] * difference_rad * second)} {
  if (across_rad_s > 1e-4 * omega.norm()) return;
  for (std::size_t k = 0; k < about_first.size(); ++k) {
    const Quaternion start = turned(kTurns[k] * difference_rad * first, q);
    about_first[k].emplace(FreeBody{moments, start, start.conjugate() * momentum}, ThetaMotion::Span::step);
  }
}

/// A time, and what the free motion and its derivatives are there.
struct Variation::Place {
  double since_base_s;
  Quaternion q;
  Matrix3 rotation;
  Vector3 omega, by_first, by_second;  // inertial
  Matrix3 inverse;                     // of (along, by_first, by_second)
  Torques::Surroundings<double> surroundings;

  struct Deviation {
    Vector3 momentum, angle;
  };
  Deviation deviation(const Epoch& epoch, const Coefficients& y) const {
    const Vector3 mu = y.head<3>() / epoch.magnitude;
    return {y.head<3>(), epoch.along.cross(mu) + (epoch.along.dot(mu) * since_base_s) * omega + y[3] * epoch.along +
                             y[4] * by_first + y[5] * by_second};
  }
  FreeState state(const Epoch& epoch, const Coefficients& y) const {
    const Deviation d = deviation(epoch, y);
    const Vector3 half = 0.5 * d.angle;
    FreeState s;
    s.q_inertial_from_body =
        (Quaternion(std::sqrt(1.0 - half.squaredNorm()), half[0], half[1], half[2]) * q).normalized();
    s.momentum_body = s.q_inertial_from_body.conjugate() * Vector3(epoch.momentum + d.momentum);
    return s;
  }
};

void Variation::find_places(const Epoch& epoch, std::span<const double> since_base_s, Place* places) const {
  const std::size_t count = since_base_s.size();
  double m[3 * (kDegree + 1)], q[4 * (kDegree + 1)], neighbours[6][4 * (kDegree + 1)];
  const TimeArrays times{since_base_s};
  const auto quaternion = [](const double* a, std::size_t i) {
    return Quaternion(a[4 * i], a[4 * i + 1], a[4 * i + 2], a[4 * i + 3]);
  };
  epoch.free.batch(times, StateArrays::of_structures(q, m));
  for (std::size_t k = 0; k < 6; ++k) {
    epoch.about_second[k].batch(times, StateArrays::of_structures(neighbours[k], nullptr));
  }
  const auto derivative = [&](std::size_t i) -> Vector3 {
    const auto apart = [&](int plus, int minus) {
      return rotation_vector(quaternion(neighbours[plus], i), quaternion(neighbours[minus], i));
    };
    return (45.0 * apart(3, 2) - 9.0 * apart(4, 1) + apart(5, 0)) / (60.0 * difference_rad_);
  };
  for (std::size_t i = 0; i < count; ++i) {
    Place& p = places[i];
    p.since_base_s = since_base_s[i];
    p.q = quaternion(q, i);
    p.rotation = p.q.toRotationMatrix();
    p.omega = p.rotation * Vector3(m[3 * i], m[3 * i + 1], m[3 * i + 2]).cwiseProduct(inverse_moments_);
    p.by_second = derivative(i);
    // A turn by the rate across the momentum is a shift in time and a turn about the momentum.
    p.by_first = (p.omega - epoch.omega.dot(epoch.along) * epoch.along) / epoch.across_rad_s;
  }
  if (epoch.about_first[0]) {
    for (std::size_t k = 0; k < 6; ++k) {
      epoch.about_first[k]->batch(times, StateArrays::of_structures(neighbours[k], nullptr));
    }
    for (std::size_t i = 0; i < count; ++i) places[i].by_first = derivative(i);
  }
  for (std::size_t i = 0; i < count; ++i) {
    Matrix3 basis;
    basis << epoch.along, places[i].by_first, places[i].by_second;
    places[i].inverse = basis.inverse();
  }
}

Variation::Coefficients Variation::rate(const Epoch& epoch, const Place& p, const Coefficients& y) {
  ++evaluations_;
  const Place::Deviation d = p.deviation(epoch, y);
  const Vector3 half = 0.5 * d.angle;
  const double scalar = std::sqrt(std::max(0.0, 1.0 - half.squaredNorm()));
  const Quaternion q = Quaternion(scalar, half[0], half[1], half[2]) * p.q;
  const Matrix3 rotation = q.toRotationMatrix();
  const Vector3 m = rotation.transpose() * (epoch.momentum + d.momentum);
  const Vector3 omega_body = m.cwiseProduct(inverse_moments_);
  const TorqueTerms<double> terms = torques_.at(p.surroundings, rotation, moments_);
  const Vector3 torque = rotation * terms.torque(omega_body);
  const Vector3 omega = rotation * (omega_body + terms.relaxation * m.cross(omega_body));
  // Exact; of it the linear part in the deviation is what the six solutions obey already.
  const Vector3 angle_rate = scalar * (omega - p.omega) + (omega + p.omega).cross(half);
  const Vector3 felt = d.momentum + epoch.momentum.cross(d.angle);
  const Vector3 linear = p.rotation * (p.rotation.transpose() * felt).cwiseProduct(inverse_moments_);
  const Vector3 relative = torque / epoch.magnitude;
  const Vector3 rest =
      angle_rate - linear - epoch.along.cross(relative) - (epoch.along.dot(relative) * p.since_base_s) * p.omega;
  Coefficients result;
  result << torque, p.inverse * rest;
  return result;
}

Variation::Variation(const FreeBody& start, double start_s, double end_s, const Torques& torques, double tolerance,
                     std::size_t max_torque_evaluations)
    : torques_(torques),
      moments_(start.principal_moments),
      inverse_moments_(start.principal_moments.cwiseInverse()),
      start_s_(start_s),
      start_{start.q_inertial_from_body.normalized(), start.momentum_body},
      difference_rad_(kDifference_rad * std::pow(tolerance, 1.0 / 16.0)) {
  static const Grid coarse(kFinest / 2), fine(kFinest);
  whole_ = start_s == end_s;
  if (whole_ || !(start.momentum_body.norm() > 0.0)) return;
  const double span_s = std::abs(end_s - start_s);
  const Vector3 momentum = start_.q_inertial_from_body * start_.momentum_body;
  epochs_.emplace_back(start_s, moments_, start_.q_inertial_from_body, momentum, difference_rad_);
  Coefficients y = Coefficients::Zero();
  double t = start_s, wanted_rad = 4.0;
  while (t != end_s) {
    const Epoch& epoch = epochs_.back();
    const double rate_rad_s = epoch.omega.norm();
    const double remaining_s = std::abs(end_s - t);
    double length_s = std::min(wanted_rad / rate_rad_s, kTimeScaleShare * torques_.time_scale_s(t));
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
    const auto size = [&](const Coefficients& c) {
      return c.tail<3>().cwiseAbs().maxCoeff() + c.head<3>().cwiseAbs().maxCoeff() / epoch.magnitude * weight;
    };

    std::array<double, kDegree + 1> since_base_s{};
    for (int i = 0; i <= kDegree; ++i) {
      since_base_s[i] = (t - epoch.base_s) + half_s * (1.0 + chebyshev_point(i, kDegree));
    }
    std::array<Place, kDegree + 1> places;
    find_places(epoch, since_base_s, places.data());
    for (Place& place : places) place.surroundings = torques_.surroundings(epoch.base_s + place.since_base_s);
    Values values = y.replicate<1, kDegree + 2>(), rates = Values::Zero();
    bool first_rate_known = false;
    // Takes the rates at the grid's points anew; returns how far the values moved.
    const auto sweep = [&](const Grid& grid) {
      double change[kDegree + 1][6] = {};
      for (int j = first_rate_known ? 1 : 0; j <= grid.degree; ++j) {
        const int i = j * grid.stride;
        const Coefficients now = rate(epoch, places[static_cast<std::size_t>(i)], values.col(i));
        for (int k = 0; k < 6; ++k) change[j][k] = now[k] - rates(k, i);
      }
      first_rate_known = true;  // the values there stay
      Values moved = Values::Zero();
      for (int k = 0; k < 6; ++k) {
        double* const to = &moved(k, 0);
        double* const rate_to = &rates(k, 0);
        for (int j = 0; j <= grid.degree; ++j) {
          const double by = half_s * change[j][k];
          for (int i = 0; i < kDegree + 2; ++i) to[i] += by * grid.integral[j][i];
        }
        if (grid.stride == 1) {
          for (int j = 0; j <= grid.degree; ++j) rate_to[j] += change[j][k];
        } else {
          for (int j = 0; j <= grid.degree; ++j) {
            for (int i = 0; i < kDegree + 2; ++i) rate_to[i] += change[j][k] * grid.interpolation[j][i];
          }
        }
      }
      values += moved;
      double most = 0.0;
      for (int i = 1; i <= kDegree; ++i) most = std::max(most, size(moved.col(i)));
      return most;
    };
    double before = sweep(coarse), moved = sweep(fine);
    std::array<Coefficients, 4> spectrum;
    spectrum.fill(Coefficients::Zero());
    double largest = 0.0;
    for (int j = 0; j <= kDegree; ++j) {
      for (std::size_t k = 0; k < 4; ++k) spectrum[k] += fine.coefficients[j][k] * rates.col(j);
      largest = std::max(largest, size(rates.col(j)));
    }
    // What is beyond degree n integrates to less by n^2 at the end, where errors go on, and by 2n between the points.
    const double tail = std::abs(half_s) * std::max(size(spectrum[2]), size(spectrum[3]));
    const double truncation = std::max(tail / (kDegree * kDegree) / allowed, tail / (2 * kDegree) / weight / tolerance);
    const double missed_by_coarse = 3.0 * std::max(size(spectrum[0]), size(spectrum[1])) / largest;
    // Each sweep moves less than the last in about the same ratio; what is left after one is about the next.
    const auto left = [&] { return moved * std::min(1.0, moved / before); };
    for (int sweeps = 2; left() > kLeft * allowed && sweeps < kMostSweeps && moved < 0.5 * before; ++sweeps) {
      const bool coarse_will_do = left() * std::max(missed_by_coarse, moved / before) <= kLeft * allowed;
      before = moved;
      moved = sweep(coarse_will_do ? coarse : fine);
    }
    const bool converged = left() <= kLeft * allowed;
    const bool good = converged && truncation <= 1.0;
    double factor = 0.5;
    if (converged && std::isfinite(truncation)) {
      factor = 0.9 * std::pow(std::max(truncation, 1e-300), -1.0 / kDegree);
    }
    wanted_rad = std::min(length_s * rate_rad_s * std::clamp(factor, 0.4, good ? 1.6 : 0.9), kLongestWindow_rad);
    if (evaluations_ > max_torque_evaluations || !(wanted_rad > kShortestWindow_rad) ||
        static_cast<double>(evaluations_) > 1000.0 + kMostEvaluationsPerRadian * rate_rad_s * std::abs(t - start_s)) {
      return;
    }
    if (!good) continue;
    windows_.push_back({t, to_s - t, epochs_.size() - 1, values});
    t = to_s;
    y = values.col(kDegree);
    const Place& end = places[kDegree];
    const Place::Deviation d = end.deviation(epoch, y);
    if (d.angle.norm() > kLargestDeviation_rad || std::abs(end.since_base_s) * rate_rad_s > kLongestEpoch_rad ||
        std::max(end.by_first.norm(), end.by_second.norm()) > kLargestDerivative) {
      const Quaternion q = end.state(epoch, y).q_inertial_from_body;
      epochs_.emplace_back(t, moments_, q, epoch.momentum + d.momentum, difference_rad_);
      y.setZero();
    }
  }
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
  Coefficients sum = Coefficients::Zero();
  double weights = 0.0;
  for (int i = 0; i <= kDegree; ++i) {
    const double away = x - chebyshev_point(i, kDegree);
    if (away == 0.0) {
      sum = window.coefficients.col(i);
      weights = 1.0;
      break;
    }
    const double weight = (i % 2 == 0 ? 1.0 : -1.0) * (i == 0 || i == kDegree ? 0.5 : 1.0) / away;
    sum += weight * window.coefficients.col(i);
    weights += weight;
  }
  const Epoch& epoch = epochs_[window.epoch];
  const std::array<double, 1> since_base_s{(t_high_s - epoch.base_s) + t_low_s};
  Place place;
  find_places(epoch, since_base_s, &place);
  return place.state(epoch, sum / weights);
}

}  // namespace polhode
