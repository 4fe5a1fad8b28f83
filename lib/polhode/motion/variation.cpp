#include "polhode/motion/variation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace polhode {
namespace {

constexpr int kFinest = Variation::kDegree, kPoints = Variation::kPoints;
constexpr int kTogether = 4;  // points in a register
// Of neighbours, times the sixteenth root of the tolerance: 1e-3 at 1e-10. Its sixth power and a rounding divided by it
// are below 1e-12, and runs to two tolerances do not share the error.
constexpr double kDifference_rad = 4e-3;
constexpr double kTurns[] = {-3.0, -2.0, -1.0, 1.0, 2.0, 3.0};  // of neighbours, in that unit
constexpr double kLongestEpoch_rad = 10.0;                      // after which the derivatives lose digits
constexpr double kLargestDeviation_rad = 0.02;                  // whose square goes into the polynomials
constexpr double kLargestDerivative = 12.0;  // of which the seventh power measures the error of the derivatives
constexpr double kShortestWindow_rad = 0.02;
// Times the fortieth root of the tolerance, 0.6 at 1e-9: runs to two tolerances do not share their windows.
constexpr double kLongestWindow_rad = 20.0;
constexpr double kWindowTimeScaleShare = 1.1;  // of a window in r/v: an encounter is never stepped over
constexpr int kMostSweeps = 9;
constexpr double kDecayed = 0.03;  // coefficients that tell of those that follow
constexpr double kUnknown = 1e300;
constexpr double kStiffer = 10.0;                   // the next window than any before
constexpr double kLeft = 0.3;                       // of a window's share of the tolerance, by the iteration
constexpr double kMostEvaluationsPerRadian = 70.0;  // beyond which extrapolation is cheaper

/// A number at each point of a window, in order of time. The loops over points are compiled for wider registers as
/// well, where the processor has them; the bits are the same.
using AtPoints = double[kPoints];

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define POLHODE_WIDE [[gnu::target_clones("avx2", "default")]]
#else
#define POLHODE_WIDE
#endif

/// Inertial, at one point; as plain as the compiler's vectors want it.
struct Plain {
  double x, y, z;
};
[[gnu::always_inline]] inline Plain operator+(Plain a, Plain b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
[[gnu::always_inline]] inline Plain operator-(Plain a, Plain b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
[[gnu::always_inline]] inline Plain operator*(double s, Plain a) { return {s * a.x, s * a.y, s * a.z}; }
[[gnu::always_inline]] inline double dot(Plain a, Plain b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
[[gnu::always_inline]] inline Plain cross(Plain a, Plain b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[gnu::always_inline]] inline Plain plain(const Vector3& v) { return {v[0], v[1], v[2]}; }
[[gnu::always_inline]] inline Plain get(const AtPoints* v, int i) { return {v[0][i], v[1][i], v[2][i]}; }
[[gnu::always_inline]] inline void put(Plain a, AtPoints* v, int i) { v[0][i] = a.x, v[1][i] = a.y, v[2][i] = a.z; }

/// Point i of the Chebyshev grid of degree n on (-1, 1), ascending.
double chebyshev_point(int i, int n) { return -std::cos(std::numbers::pi * i / n); }

/// From values at the points of a Chebyshev grid: values of the polynomial through them, and of its integral from the
/// first point, at the points of the finest grid; and four of its Chebyshev coefficients (Clenshaw & Curtis, Numer.
/// Math. 2, 197, 1960). Row j is what the value at point j contributes.
struct Grid {
  int degree, stride;  // stride in points of the finest grid
  double interpolation[kFinest + 1][kPoints] = {}, integral[kFinest + 1][kPoints] = {};
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

/// to += the values at the points of a grid times the rows of a matrix.
POLHODE_WIDE void add_products(const double* values, int stride, int rows, const double (*matrix)[kPoints], double by,
                               double* to) {
  double sum[kPoints];
  for (int i = 0; i < kPoints; ++i) sum[i] = values[0] * matrix[0][i];
  for (int j = 1; j < rows; ++j) {
    const double value = values[j * stride];
    for (int i = 0; i < kPoints; ++i) sum[i] += value * matrix[j][i];
  }
  for (int i = 0; i < kPoints; ++i) to[i] += by * sum[i];
}

/// q turned about an inertial axis.
Quaternion turned(const Vector3& rotation_vector, const Quaternion& q) {
  const double half = 0.5 * rotation_vector.norm();
  if (half == 0.0) return q;
  const Vector3 v = std::sin(half) / (2.0 * half) * rotation_vector;
  return Quaternion(std::cos(half), v[0], v[1], v[2]) * q;
}

ThetaMotion neighbour(const Vector3& moments, const Quaternion& q, const Vector3& momentum_inertial,
                      const Vector3& rotation_vector) {
  const Quaternion start = turned(rotation_vector, q);
  return ThetaMotion({moments, start, start.conjugate() * momentum_inertial}, ThetaMotion::Span::step);
}

std::array<ThetaMotion, 6> neighbours(const Vector3& moments, const Quaternion& q, const Vector3& momentum,
                                      const Vector3& rotation_vector) {
  const auto turned_by = [&](int i) { return neighbour(moments, q, momentum, kTurns[i] * rotation_vector); };
  return {turned_by(0), turned_by(1), turned_by(2), turned_by(3), turned_by(4), turned_by(5)};
}

/// to += weight times the small rotation vector that turns b into a.
POLHODE_WIDE void add_rotation_vectors(const AtPoints* a, const AtPoints* b, double weight, int count, AtPoints* to) {
  for (int i = 0; i < count; ++i) {
    const Plain va = get(a + 1, i), vb = get(b + 1, i);
    const double w = a[0][i] * b[0][i] + dot(va, vb);
    const Plain v = b[0][i] * va - a[0][i] * vb - cross(va, vb);
    const double s = dot(v, v);  // of the sine of half the angle; asin(x)/x to its 10th power
    const double ratio = 1.0 + s * (1.0 / 6 + s * (3.0 / 40 + s * (5.0 / 112 + s * (35.0 / 1152 + s * (63.0 / 2816)))));
    put(get(to, i) + (std::copysign(2.0, w) * weight * ratio) * v, to, i);
  }
}

}  // namespace

namespace variation {

/// Times, and what the free motion and its derivatives are there; all inertial.
struct Places {
  AtPoints since_base_s;
  AtPoints q[4];
  AtPoints omega[3], by_first[3], by_second[3];
  AtPoints inverse_inertia[6];  // 11, 22, 33, 23, 31, 12
  AtPoints inverse[3][3];       // of (along, by_first, by_second)
};

/// What the body feels at the points of a window, inertial.
struct Felt {
  AtPoints torque[3] = {};
  AtPoints relaxation[3] = {};  // what internal dissipation adds to the rate
};

}  // namespace variation

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
      about_second(neighbours(moments, q, momentum, difference_rad * second)) {
  if (across_rad_s > 1e-4 * omega.norm()) return;
  // NOLINTNEXTLINE(modernize-make-unique): the motions cannot be moved
  about_first.reset(new Neighbours(neighbours(moments, q, momentum, difference_rad * first)));
}

namespace {

POLHODE_WIDE void find_inertia(const AtPoints* q, Plain inverse_moments, Plain momentum, int count, AtPoints* inverse,
                               AtPoints* omega) {
  for (int i = 0; i < count; ++i) {
    const double w = q[0][i], x = q[1][i], y = q[2][i], z = q[3][i];
    const Plain e1{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)};
    const Plain e2{2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)};
    const Plain e3{2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)};
    const Plain f1 = inverse_moments.x * e1, f2 = inverse_moments.y * e2, f3 = inverse_moments.z * e3;
    inverse[0][i] = e1.x * f1.x + e2.x * f2.x + e3.x * f3.x;
    inverse[1][i] = e1.y * f1.y + e2.y * f2.y + e3.y * f3.y;
    inverse[2][i] = e1.z * f1.z + e2.z * f2.z + e3.z * f3.z;
    inverse[3][i] = e1.y * f1.z + e2.y * f2.z + e3.y * f3.z;
    inverse[4][i] = e1.z * f1.x + e2.z * f2.x + e3.z * f3.x;
    inverse[5][i] = e1.x * f1.y + e2.x * f2.y + e3.x * f3.y;
    put(dot(f1, momentum) * e1 + dot(f2, momentum) * e2 + dot(f3, momentum) * e3, omega, i);
  }
}

POLHODE_WIDE void find_first(const AtPoints* omega, Plain middle, double across, int count, AtPoints* by_first) {
  for (int i = 0; i < count; ++i) put((1.0 / across) * (get(omega, i) - middle), by_first, i);
}

POLHODE_WIDE void invert(Plain along, const AtPoints* by_first, const AtPoints* by_second, int count,
                         AtPoints (*inverse)[3]) {
  for (int i = 0; i < count; ++i) {
    const Plain a = get(by_first, i), b = get(by_second, i);
    const Plain ab = cross(a, b);
    const double reciprocal = 1.0 / dot(along, ab);
    put(reciprocal * ab, inverse[0], i);
    put(reciprocal * cross(b, along), inverse[1], i);
    put(reciprocal * cross(along, a), inverse[2], i);
  }
}

}  // namespace

void Variation::find_places(const Epoch& epoch, int count, variation::Places& p) const {
  const int padded = (count + kTogether - 1) / kTogether * kTogether;
  std::fill(p.since_base_s + count, p.since_base_s + padded, p.since_base_s[count - 1]);
  const TimeArrays times{{p.since_base_s, static_cast<std::size_t>(padded)}};
  const auto attitudes = [&](const ThetaMotion& motion, AtPoints* q) {
    StateArrays out;
    for (int k = 0; k < 4; ++k) out.q[k] = q[k];
    out.q_stride = 1;
    motion.batch(times, out);
  };
  const auto derivative = [&](const Epoch::Neighbours& turned, AtPoints* to) {
    constexpr double weights[] = {45.0, -9.0, 1.0};
    for (int k = 0; k < 3; ++k) std::fill(to[k], to[k] + padded, 0.0);
    for (std::size_t n = 0; n < 3; ++n) {
      AtPoints plus[4], minus[4];
      attitudes(turned[3 + n], plus);
      attitudes(turned[2 - n], minus);
      add_rotation_vectors(plus, minus, weights[n] / (60.0 * difference_rad_), padded, to);
    }
  };
  attitudes(epoch.free, p.q);
  find_inertia(p.q, plain(inverse_moments_), plain(epoch.momentum), padded, p.inverse_inertia, p.omega);
  derivative(epoch.about_second, p.by_second);
  if (epoch.about_first != nullptr) {
    derivative(*epoch.about_first, p.by_first);
  } else {
    // A turn by the rate across the momentum is a shift in time and a turn about the momentum.
    find_first(p.omega, plain(epoch.omega.dot(epoch.along) * epoch.along), epoch.across_rad_s, padded, p.by_first);
  }
  invert(plain(epoch.along), p.by_first, p.by_second, padded, p.inverse);
}

namespace {

/// The rotation vector of the deviation at a point.
[[gnu::always_inline]] inline Plain angle(const variation::Places& p, int i, Plain along, Plain mu, const double* a) {
  return cross(along, mu) + (dot(along, mu) * p.since_base_s[i]) * get(p.omega, i) + a[0] * along +
         a[1] * get(p.by_first, i) + a[2] * get(p.by_second, i);
}

/// The rates of the coefficients y at the points (variation.md, "The equations of what differs"), free of differences
/// between near numbers.
POLHODE_WIDE void find_rates(const variation::Places& p, const variation::Felt& felt, Plain along, double magnitude,
                             const double (*y)[kPoints], double (*__restrict rates)[kPoints]) {
  const double reciprocal = 1.0 / magnitude;
  for (int i = 0; i < kPoints; ++i) {
    const Plain mu = reciprocal * Plain{y[0][i], y[1][i], y[2][i]};  // all momenta in units of the free motion's
    const double a[3] = {y[3][i], y[4][i], y[5][i]};
    const Plain theta = angle(p, i, along, mu, a);
    const double s = 0.25 * dot(theta, theta);
    const double c = std::sqrt(std::abs(1.0 - s)), less = s / (1.0 + c);  // 1 - c
    const auto inverse_inertia = [&p, i, magnitude ](Plain v) __attribute__((always_inline)) {
      const AtPoints* j = p.inverse_inertia;
      return magnitude * Plain{j[0][i] * v.x + j[5][i] * v.y + j[4][i] * v.z,
                               j[5][i] * v.x + j[1][i] * v.y + j[3][i] * v.z,
                               j[4][i] * v.x + j[3][i] * v.y + j[2][i] * v.z};
    };
    // The momentum turned back, less the free motion's; `second` is its part of second order.
    const Plain turned = cross(theta, along), turned_mu = cross(theta, mu);
    const Plain second = less * turned - c * turned_mu + 0.5 * cross(theta, turned + turned_mu);
    const Plain momentum = mu - turned + second;
    // N, and the rate less the free motion's.
    const Plain omega = get(p.omega, i), rate = inverse_inertia(momentum);
    const Plain relaxation = get(felt.relaxation, i);
    const Plain turned_omega = cross(theta, omega), turned_rate = cross(theta, rate);
    const Plain twice = cross(theta, turned_omega + turned_rate);
    const Plain more = rate + c * (turned_omega + turned_rate) + 0.5 * twice + relaxation;
    const Plain n = inverse_inertia(second) - less * rate - s * turned_omega + (c * c) * turned_rate +
                    (0.5 * c) * twice + c * relaxation + 0.5 * cross(more, theta);
    const Plain torque = get(felt.torque, i), relative = reciprocal * torque;
    const Plain rest = n - cross(along, relative) - (dot(along, relative) * p.since_base_s[i]) * omega;
    rates[0][i] = torque.x;
    rates[1][i] = torque.y;
    rates[2][i] = torque.z;
    rates[3][i] = dot(get(p.inverse[0], i), rest);
    rates[4][i] = dot(get(p.inverse[1], i), rest);
    rates[5][i] = dot(get(p.inverse[2], i), rest);
  }
}

}  // namespace

FreeState Variation::state(const Epoch& epoch, const variation::Places& p, int i, const Coefficients& y) const {
  const Plain theta = angle(p, i, plain(epoch.along), (1.0 / epoch.magnitude) * Plain{y[0], y[1], y[2]}, &y[3]);
  const double s = 0.25 * dot(theta, theta);
  FreeState state;
  state.q_inertial_from_body = (Quaternion(std::sqrt(1.0 - s), 0.5 * theta.x, 0.5 * theta.y, 0.5 * theta.z) *
                                Quaternion(p.q[0][i], p.q[1][i], p.q[2][i], p.q[3][i]))
                                   .normalized();
  state.momentum_body = state.q_inertial_from_body.conjugate() * Vector3(epoch.momentum + y.head<3>());
  return state;
}

void Variation::feel(const Epoch& epoch, const variation::Places& p, int i, const Coefficients& y,
                     const Torques::Surroundings<double>& surroundings, Vector3& torque, Vector3& relaxation) {
  ++evaluations_;
  const Plain theta = angle(p, i, plain(epoch.along), (1.0 / epoch.magnitude) * Plain{y[0], y[1], y[2]}, &y[3]);
  const double s = 0.25 * dot(theta, theta);
  const Quaternion e(std::sqrt(std::max(0.0, 1.0 - s)), 0.5 * theta.x, 0.5 * theta.y, 0.5 * theta.z);
  const Matrix3 rotation = (e * Quaternion(p.q[0][i], p.q[1][i], p.q[2][i], p.q[3][i])).toRotationMatrix();
  const Vector3 m = rotation.transpose() * (epoch.momentum + y.head<3>());
  const Vector3 omega = m.cwiseProduct(inverse_moments_);
  const TorqueTerms<double> terms = torques_.at(surroundings, rotation, moments_);
  torque = rotation * terms.torque(omega);
  if (terms.relaxation != 0.0) relaxation = rotation * (terms.relaxation * m.cross(omega));
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
  double stiffness = kUnknown;
  const double shorter = std::pow(std::min(tolerance, 1e-5), 1.0 / 40.0);
  variation::Places places;
  std::array<Torques::Surroundings<double>, kDegree + 1> surroundings;
  while (t != end_s) {
    const Epoch& epoch = epochs_.back();
    const Plain along = plain(epoch.along);
    const double rate_rad_s = epoch.omega.norm();
    const double remaining_s = std::abs(end_s - t);
    double length_s = std::min(wanted_rad / rate_rad_s, shorter * kWindowTimeScaleShare * torques_.time_scale_s(t));
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

    for (int i = 0; i <= kDegree; ++i) {
      places.since_base_s[i] = (t - epoch.base_s) + half_s * (1.0 + chebyshev_point(i, kDegree));
    }
    find_places(epoch, kDegree + 1, places);
    std::array<bool, kDegree + 1> surrounded{};
    const Values start_values = y.replicate<1, kPoints>();
    Values values = start_values, rates;
    variation::Felt felt;
    bool first_is_known = false;
    // Takes the torque at the grid's points anew, then the rates at all points; returns how far the values moved.
    const auto sweep = [&](const Grid& grid) {
      AtPoints change[6] = {};
      bool relaxes = false;
      for (int j = first_is_known ? 1 : 0; j <= grid.degree; ++j) {
        const int i = j * grid.stride;
        auto& around = surroundings[static_cast<std::size_t>(i)];
        if (!surrounded[static_cast<std::size_t>(i)]) {
          around = torques_.surroundings(epoch.base_s + places.since_base_s[i]);
          surrounded[static_cast<std::size_t>(i)] = true;
        }
        Vector3 torque = Vector3::Zero(), relaxation = Vector3::Zero();
        feel(epoch, places, i, values.col(i), around, torque, relaxation);
        for (int k = 0; k < 3; ++k) {
          change[k][i] = torque[k] - felt.torque[k][i];
          change[3 + k][i] = relaxation[k] - felt.relaxation[k][i];
          relaxes = relaxes || change[3 + k][i] != 0.0;
        }
      }
      first_is_known = true;  // the values there stay
      for (int k = 0; k < (relaxes ? 6 : 3); ++k) {
        AtPoints& to = k < 3 ? felt.torque[k] : felt.relaxation[k - 3];
        add_products(change[k], grid.stride, grid.degree + 1, grid.interpolation, 1.0, to);
      }
      const auto rows = [](Values& v) { return reinterpret_cast<double(*)[kPoints]>(v.data()); };
      Values moved = -values;
      double last = 0.0;
      for (int following = 0; following < 2 && !(last <= kLeft * allowed && following > 0); ++following) {
        find_rates(places, felt, along, epoch.magnitude, rows(values), rows(rates));
        values = start_values;
        for (int k = 0; k < 6; ++k) add_products(&rates(k, 0), 1, kDegree + 1, fine.integral, half_s, &values(k, 0));
        last = size((moved + values).cwiseAbs().rowwise().maxCoeff());
      }
      moved += values;
      return size(moved.cwiseAbs().rowwise().maxCoeff());
    };
    double before = 0.0, moved = sweep(coarse);
    // What is beyond degree n integrates to less by n^2 at the end, where errors go on, and by 2n between the points.
    const auto truncation_of = [&](double last_coefficient, int n) {
      const double tail = std::abs(half_s) * last_coefficient;
      return std::max(tail / (n * n) / allowed, tail / (2 * n) / weight / tolerance);
    };
    double last_torque = 0.0, largest_torque = 0.0;
    for (const AtPoints& torque : felt.torque) {
      double last[2] = {};
      for (int j = 0; j <= coarse.degree; ++j) {
        const double here = torque[j * coarse.stride];
        for (int k = 0; k < 2; ++k) last[k] += coarse.coefficients[j][2 + k] * here;
        largest_torque = std::max(largest_torque, std::abs(here));
      }
      last_torque = std::max({last_torque, std::abs(last[0]), std::abs(last[1])});
    }
    const bool coarse_resolves = last_torque <= kDecayed * largest_torque &&
                                 truncation_of(last_torque / epoch.magnitude * (1.0 + weight), coarse.degree) <= 1.0;
    int sweeps = 1;
    // Each sweep moves less than the last in about the same ratio; what is left after one is about the next.
    const auto left = [&] {
      return moved * std::min(1.0, sweeps == 1 ? kStiffer * stiffness * moved / weight : moved / before);
    };
    if (!coarse_resolves) {
      before = moved;
      moved = sweep(fine);
      ++sweeps;
    }
    std::array<Coefficients, 4> spectrum;
    spectrum.fill(Coefficients::Zero());
    double largest = 0.0;
    for (int j = 0; j <= kDegree; ++j) {
      for (std::size_t k = 0; k < 4; ++k) spectrum[k] += fine.coefficients[j][k] * rates.col(j);
      largest = std::max(largest, size(rates.col(j)));
    }
    const double missed_by_coarse =
        coarse_resolves ? 0.0 : 3.0 * std::max(size(spectrum[0]), size(spectrum[1])) / largest;
    const double truncation = truncation_of(std::max(size(spectrum[2]), size(spectrum[3])), kDegree);
    for (; left() > kLeft * allowed && sweeps < kMostSweeps && (sweeps == 1 || moved < 0.5 * before); ++sweeps) {
      const bool coarse_will_do = left() * std::max(missed_by_coarse, moved / before) <= kLeft * allowed;
      before = moved;
      moved = sweep(sweeps == 1 || coarse_will_do ? coarse : fine);
      if (sweeps == 1)
        stiffness = std::max(stiffness == kUnknown ? 0.0 : stiffness, moved / before / (before / weight));
    }
    const bool converged = left() <= kLeft * allowed;
    const bool good = converged && truncation <= 1.0;
    double factor = 0.5;
    if (converged && std::isfinite(truncation)) {
      factor = 0.9 * std::pow(std::max(truncation, 1e-300), -1.0 / kDegree);
    }
    wanted_rad =
        std::min(length_s * rate_rad_s * std::clamp(factor, 0.4, good ? 1.6 : 0.9), shorter * kLongestWindow_rad);
    if (evaluations_ > max_torque_evaluations || !(wanted_rad > kShortestWindow_rad) ||
        static_cast<double>(evaluations_) > 1000.0 + kMostEvaluationsPerRadian * rate_rad_s * std::abs(t - start_s)) {
      return;
    }
    if (!good) continue;
    windows_.push_back({t, to_s - t, epochs_.size() - 1, values});
    t = to_s;
    y = values.col(kDegree);
    const Plain mu = (1.0 / epoch.magnitude) * Plain{y[0], y[1], y[2]};
    const Plain theta = angle(places, kDegree, along, mu, &y[3]);
    const auto length = [](Plain v) { return std::sqrt(dot(v, v)); };
    if (length(theta) > kLargestDeviation_rad ||
        std::abs(places.since_base_s[kDegree]) * rate_rad_s > kLongestEpoch_rad ||
        std::max(length(get(places.by_first, kDegree)), length(get(places.by_second, kDegree))) > kLargestDerivative) {
      const Quaternion q = state(epoch, places, kDegree, y).q_inertial_from_body;
      epochs_.emplace_back(t, moments_, q, epoch.momentum + y.head<3>(), difference_rad_);
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
  variation::Places place;
  place.since_base_s[0] = (t_high_s - epoch.base_s) + t_low_s;
  find_places(epoch, 1, place);
  return state(epoch, place, 0, sum / weights);
}

}  // namespace polhode
