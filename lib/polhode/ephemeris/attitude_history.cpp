#include "polhode/ephemeris/attitude_history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

using Vector4 = Eigen::Vector4d;

/// More rows make no better polynomial.
constexpr std::size_t most_nodes = 32;

/// Two files round the time of one row differently: so far beyond the first and last row the interpolation goes on.
constexpr Seconds rounding{1e-6, 0.0};

bool holds(const AttitudeSegment& segment, Instant time) {
  return !segment.samples.empty() && !(time + rounding < segment.samples.front().time) &&
         !(segment.samples.back().time + rounding < time);
}

bool before(const Instant& a, const AttitudeSample& b) { return a < b.time; }

/// The rotation vector of q: its axis times its angle, 0 to pi.
Vector3 rotation_vector(const Quaternion& q) {
  const double sine = q.vec().norm();
  if (sine == 0.0) return Vector3::Zero();
  const double half = std::atan2(sine, std::abs(q.w()));
  return (std::copysign(2.0 * half, q.w()) / sine) * q.vec();
}

Quaternion from_rotation_vector(const Vector3& v) {
  const double angle = v.norm();
  const double sinc = angle < 1e-8 ? 0.5 : std::sin(0.5 * angle) / angle;
  Quaternion q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = sinc * v;
  return q;
}

/// How the body gets from one row to the next: from a it turns by `turn`, and at the same time about axes that turn
/// with it by `rest`, each at a constant rate. Rotation vectors.
struct Passage {
  Vector3 turn;  // of the mean of the two rates, which may be several turns; 0 without rates
  Vector3 rest;  // what lacks to b, the shortest way

  Passage(const AttitudeSample& a, const AttitudeSample& b) : turn(Vector3::Zero()) {
    if (a.omega_body_rad_s && b.omega_body_rad_s) {
      turn = 0.5 * (b.time - a.time).high * (*a.omega_body_rad_s + *b.omega_body_rad_s);
    }
    rest = rotation_vector((a.q_frame_from_body * from_rotation_vector(turn)).conjugate() * b.q_frame_from_body);
  }

  /// From a to the part x of the way.
  Quaternion rotation(double x) const { return from_rotation_vector(x * turn) * from_rotation_vector(x * rest); }
  /// Per unit of x.
  Vector3 rate(double x) const { return rest + from_rotation_vector(x * rest).conjugate() * turn; }
};

/// The rate of a row if `time` is that row's but for rounding. `right` is the row after the instant.
std::optional<Vector3> rate_near(const std::vector<AttitudeSample>& rows, std::size_t right, Instant time) {
  constexpr double rounding_s = 1e-9;
  for (const std::size_t i : {right - 1, right}) {
    if (std::abs((time - rows[i].time).high) <= rounding_s) return rows[i].omega_body_rad_s;
  }
  return std::nullopt;
}

/// A polynomial in Newton's form through values, and derivatives where a node stands twice, with its derivative.
/// Nodes in units of the gap around the instant.
struct Newton {
  std::vector<double> nodes;
  std::vector<Vector4> coefficients;

  std::array<Vector4, 2> at(double x) const {
    Vector4 value = coefficients.back();
    Vector4 slope = Vector4::Zero();
    for (std::size_t k = coefficients.size() - 1; k-- > 0;) {
      slope = slope * (x - nodes[k]) + value;
      value = value * (x - nodes[k]) + coefficients[k];
    }
    return {value, slope};
  }
};

Newton newton(const std::vector<double>& x, const std::vector<Vector4>& values, const std::vector<Vector4>& slopes) {
  Newton p;
  std::vector<Vector4> column;
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int copy = 0; copy < (slopes.empty() ? 1 : 2); ++copy) {
      p.nodes.push_back(x[i]);
      column.push_back(values[i]);
    }
  }
  const std::size_t n = column.size();
  p.coefficients.push_back(column[0]);
  for (std::size_t order = 1; order < n; ++order) {
    for (std::size_t i = 0; i + order < n; ++i) {
      const double gap = p.nodes[i + order] - p.nodes[i];
      if (order == 1 && gap == 0.0) {
        column[i] = slopes[i / 2];
      } else {
        column[i] = (column[i + 1] - column[i]) / gap;
      }
    }
    p.coefficients.push_back(column[0]);
  }
  return p;
}

Vector4 components(const Quaternion& q) { return q.coeffs(); }  // x, y, z, w; only taken apart and put together here

Quaternion of_components(const Vector4& c) { return Quaternion(c[3], c[0], c[1], c[2]); }

}  // namespace

std::string_view name(AttitudeInterpolation method) {
  switch (method) {
    case AttitudeInterpolation::linear:
      return "LINEAR";
    case AttitudeInterpolation::lagrange:
      return "LAGRANGE";
    case AttitudeInterpolation::hermite:
      return "HERMITE";
  }
  return "";
}

void AttitudeSegment::choose_method() {
  method = has_rates() ? AttitudeInterpolation::hermite : AttitudeInterpolation::linear;
  degree = has_rates() ? 3 : 1;
}

Instant AttitudeSegment::first() const {
  const Instant rows = samples.front().time;
  return usable_start && rows < *usable_start ? *usable_start : rows;
}

Instant AttitudeSegment::last() const {
  const Instant rows = samples.back().time;
  return usable_stop && *usable_stop < rows ? *usable_stop : rows;
}

bool AttitudeSegment::is_usable_at(Instant time) const {
  return !(time + rounding < first()) && !(last() + rounding < time);
}

std::size_t AttitudeHistory::rows() const {
  std::size_t sum = 0;
  for (const AttitudeSegment& s : segments) sum += s.samples.size();
  return sum;
}

void refuse_overlaps(const AttitudeHistory& history) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < history.segments.size(); ++i) {
    const AttitudeSegment& s = history.segments[i];
    if (!(s.last() < s.first())) order.push_back(i);  // else nothing of it can be used
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return history.segments[a].first() < history.segments[b].first();
  });
  for (std::size_t i = 1, farthest = 0; i < order.size(); ++i) {
    const AttitudeSegment &one = history.segments[order[farthest]], &other = history.segments[order[i]];
    const Instant stop = std::min(one.last(), other.last());
    const bool twice = one.first() == other.first() && one.last() == other.last();
    if (twice || other.first() + rounding < stop) {
      const auto date = [&](Instant time) { return format_date(time, history.scale, 3); };
      throw InputError(fmt::format(
          "segments {} and {} of the attitude history both hold from {} to {} {}; segments may share an instant at "
          "most: USEABLE_START_TIME and USEABLE_STOP_TIME say where each is to be used",
          std::min(order[farthest], order[i]) + 1, std::max(order[farthest], order[i]) + 1, date(other.first()),
          date(stop), name(history.scale)));
    }
    if (one.last() < other.last()) farthest = i;
  }
}

const AttitudeSegment& checked(const AttitudeSegment& segment) {
  const std::vector<AttitudeSample>& rows = segment.samples;
  if (rows.empty()) throw InputError("a segment of an attitude history has no rows");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto refuse = [i](const char* problem) {
      throw InputError(fmt::format("row {} of a segment of an attitude history {}", i + 1, problem));
    };
    const AttitudeSample& row = rows[i];
    if (i > 0 && !(rows[i - 1].time < row.time)) refuse("is not later than the one before it");
    if (!(std::abs(row.q_frame_from_body.norm() - 1.0) <= 1e-6)) refuse("holds a quaternion of another length than 1");
    if (row.omega_body_rad_s.has_value() != segment.has_rates()) refuse("has a rate where others have none, or none");
    if (row.omega_body_rad_s && !row.omega_body_rad_s->allFinite()) refuse("holds a rate that is not finite");
  }
  return segment;
}

AttitudeSample interpolate(const AttitudeSegment& segment, Instant time) {
  const std::vector<AttitudeSample>& rows = segment.samples;
  if (!holds(segment, time)) {
    throw InputError("an attitude is asked for outside of the rows of its segment");
  }
  // The rows on both sides: left <= time, right > time.
  auto right = static_cast<std::size_t>(std::upper_bound(rows.begin(), rows.end(), time, before) - rows.begin());
  right = std::max<std::size_t>(right, 1);
  if (rows.size() == 1) return rows[0];
  if (rows[right - 1].time == time && rows[right - 1].omega_body_rad_s) return rows[right - 1];
  right = std::min(right, rows.size() - 1);
  const std::size_t left = right - 1;
  const double span_s = (rows[right].time - rows[left].time).high;
  const double x = (time - rows[left].time).high / span_s;
  const bool rates = segment.has_rates();
  const Passage passage(rows[left], rows[right]);
  AttitudeSample out;
  out.time = time;

  const auto degree = static_cast<std::size_t>(std::max(segment.degree, 1));
  const bool use_rates = rates && segment.method == AttitudeInterpolation::hermite;
  std::size_t count = use_rates ? (std::min(degree, 2 * most_nodes) + 1) / 2 : std::min(degree, most_nodes) + 1;
  count = std::clamp<std::size_t>(count, 2, std::min(most_nodes, rows.size()));
  Quaternion base = rows[left].q_frame_from_body;
  if (segment.method == AttitudeInterpolation::linear) {
    out.q_frame_from_body = (base * passage.rotation(x)).normalized();
    out.omega_body_rad_s = rate_near(rows, right, time).value_or(passage.rate(x) / span_s);
    return out;
  }

  // With rates, components relative to a steady rotation: they stay near (0, 0, 0, 1), whatever the number of turns.
  // Without, those of the quaternion, as a file's writer means them that promises an error.
  Vector3 turn = passage.turn;
  if (!use_rates) {
    turn = Vector3::Zero();
    base = Quaternion::Identity();
  }
  const std::size_t first = std::min(right > count / 2 ? right - count / 2 : 0, rows.size() - count);
  std::vector<double> nodes;
  std::vector<Vector4> values;
  std::vector<Vector4> slopes;
  Quaternion before_it = rows[first].q_frame_from_body;  // with the sign that leads on
  for (std::size_t i = first; i < first + count; ++i) {
    const double node = (rows[i].time - rows[left].time).high / span_s;
    nodes.push_back(node);
    if (!use_rates) {
      Quaternion q = rows[i].q_frame_from_body;
      if (i > first && (before_it * Passage(rows[i - 1], rows[i]).rotation(1.0)).dot(q) < 0.0) q.coeffs() *= -1.0;
      values.push_back(components(q));
      before_it = q;
      continue;
    }
    Quaternion p = (base * from_rotation_vector(node * turn)).conjugate() * rows[i].q_frame_from_body;
    if (p.w() < 0.0) p.coeffs() *= -1.0;
    values.push_back(components(p));
    // q = r p with r' = r turn/2 and q' = q omega/2: p' = (p omega - turn p) / 2, per unit of x.
    Quaternion omega;
    omega.w() = 0.0;
    omega.vec() = span_s * rows[i].omega_body_rad_s.value();
    Quaternion steady;
    steady.w() = 0.0;
    steady.vec() = turn;
    slopes.push_back(0.5 * (components(p * omega) - components(steady * p)));
  }
  const auto [value, slope] = newton(nodes, values, slopes).at(x);
  const Quaternion p = of_components(value);
  out.q_frame_from_body = (base * from_rotation_vector(x * turn) * p).normalized();
  const Quaternion unit = p.normalized();
  const Vector3 rate = unit.conjugate() * turn + 2.0 * (unit.conjugate() * of_components(slope / p.norm())).vec();
  out.omega_body_rad_s = rate_near(rows, right, time).value_or(rate / span_s);
  return out;
}

std::optional<std::string> doubt_about_interpolation(const AttitudeSegment& segment) {
  const std::vector<AttitudeSample>& rows = segment.samples;
  const bool rates = segment.has_rates();
  if (rates && segment.method != AttitudeInterpolation::lagrange) return std::nullopt;  // turns are counted
  Vector3 before_it = Vector3::Zero();                                                  // the rate there
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double gap_s = (rows[i].time - rows[i - 1].time).high;
    const Passage passage(rows[i - 1], rows[i]);
    const Vector3 expected = gap_s * before_it;
    const Vector3 longer = passage.rest - 2.0 * std::numbers::pi * passage.rest.normalized();
    const bool far = rates ? passage.turn.norm() > std::numbers::pi
                           : i > 1 && (longer - expected).norm() < (passage.rest - expected).norm();
    if (far) {
      return fmt::format(
          "rows {} and {} are more than half a turn apart, by {}; {} takes the shortest way between rows", i, i + 1,
          rates ? "their rates" : "the turn before them", name(segment.method));
    }
    before_it = passage.rest / gap_s;
  }
  return std::nullopt;
}

void make_signs_continuous(AttitudeSegment& segment) {
  std::vector<AttitudeSample>& rows = segment.samples;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Quaternion arrived = rows[i - 1].q_frame_from_body * Passage(rows[i - 1], rows[i]).rotation(1.0);
    if (arrived.dot(rows[i].q_frame_from_body) < 0.0) rows[i].q_frame_from_body.coeffs() *= -1.0;
  }
}

namespace {

/// Angles, added up. Not a number is no angle.
class Statistics {
 public:
  void add(double angle_rad, Instant time) {
    if (!std::isfinite(angle_rad)) throw ComputationError("an attitude is not a number");
    if (result_.compared == 0 || angle_rad > result_.largest_rad) {
      result_.largest_rad = angle_rad;
      result_.time_of_largest = time;
    }
    ++result_.compared;
    squares_ += angle_rad * angle_rad;
  }
  void skip() { ++result_.outside; }

  AttitudeDifference finish() {
    if (result_.compared == 0) throw InputError("the two attitudes have no time in common");
    result_.root_mean_square_rad = std::sqrt(squares_ / static_cast<double>(result_.compared));
    return result_;
  }

 private:
  AttitudeDifference result_;
  double squares_ = 0.0;
};

void check_clock(const AttitudeHistory& history) {
  if (!history.absolute_time)
    throw InputError("the times of an attitude history are of a clock that cannot be related to others");
}

/// v_icrf = q v_frame q*, or nothing for a frame known by its name only.
std::optional<Quaternion> q_icrf_of(const AttitudeSegment& segment) {
  return segment.known_frame ? std::optional(q_icrf_from(*segment.known_frame)) : std::nullopt;
}

}  // namespace

AttitudeDifference compare(const AttitudeHistory& a, const AttitudeHistory& b) {
  check_clock(a);
  check_clock(b);
  refuse_overlaps(a);
  refuse_overlaps(b);
  Statistics statistics;
  for (const AttitudeSegment& segment : a.segments) {
    const std::optional<Quaternion> q_a = q_icrf_of(segment);
    for (const AttitudeSample& row : segment.samples) {
      if (!segment.is_usable_at(row.time)) continue;
      // Two segments may share an instant; one attitude in each.
      std::optional<double> least_rad;
      for (const AttitudeSegment& other : b.segments) {
        if (!other.is_usable_at(row.time)) continue;
        const std::optional<Quaternion> q_b = q_icrf_of(other);
        const bool related = q_a && q_b;
        if (!related && segment.frame != other.frame) {
          throw InputError("the frames " + segment.frame + " and " + other.frame + " cannot be related");
        }
        const Quaternion of_b = interpolate(other, row.time).q_frame_from_body;
        const double angle_rad = related ? rotation_angle_rad(*q_a * row.q_frame_from_body, *q_b * of_b)
                                         : rotation_angle_rad(row.q_frame_from_body, of_b);
        if (!least_rad || !(angle_rad >= *least_rad)) least_rad = angle_rad;
      }
      if (least_rad) {
        statistics.add(*least_rad, row.time);
      } else {
        statistics.skip();
      }
    }
  }
  return statistics.finish();
}

AttitudeDifference compare(const AttitudeHistory& a, const std::function<Quaternion(Instant)>& q_icrf_from_body) {
  check_clock(a);
  refuse_overlaps(a);
  Statistics statistics;
  for (const AttitudeSegment& segment : a.segments) {
    const std::optional<Quaternion> q_a = q_icrf_of(segment);
    if (!q_a) throw InputError("the frame " + segment.frame + " cannot be related to ICRF");
    for (const AttitudeSample& row : segment.samples) {
      if (!segment.is_usable_at(row.time)) continue;
      statistics.add(rotation_angle_rad(*q_a * row.q_frame_from_body, q_icrf_from_body(row.time)), row.time);
    }
  }
  return statistics.finish();
}

}  // namespace polhode
