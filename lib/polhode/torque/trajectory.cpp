#include "polhode/torque/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

constexpr int kHighestDegree = 15;

std::size_t points(const OrbitTable& table) {
  const auto nodes = static_cast<std::size_t>(table.degree) + 1;
  return table.velocities_m_s.empty() ? nodes : (nodes + 1) / 2;
}

void check(const OrbitTable& table) {
  if (table.degree < 1 || table.degree > kHighestDegree) {
    throw InputError(fmt::format("the interpolation degree is {}, 1 to {} is allowed", table.degree, kHighestDegree));
  }
  const std::size_t count = table.times_s.size();
  if (table.positions_m.size() != count || (!table.velocities_m_s.empty() && table.velocities_m_s.size() != count) ||
      count < std::max<std::size_t>(points(table), 2)) {
    throw InputError(fmt::format(
        "the trajectory has {} times, {} positions and {} velocities; as many of each (velocities may be missing) and "
        "{} at least are wanted for degree {}",
        count, table.positions_m.size(), table.velocities_m_s.size(), std::max<std::size_t>(points(table), 2),
        table.degree));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 velocity = table.velocities_m_s.empty() ? Vector3::Zero() : table.velocities_m_s[i];
    if (!std::isfinite(table.times_s[i]) || !table.positions_m[i].allFinite() || !velocity.allFinite()) {
      throw InputError(fmt::format("row {} of the trajectory holds a number that is not finite", i + 1));
    }
    if (!(table.positions_m[i].norm() > 0.0)) {
      throw InputError(fmt::format("row {} of the trajectory is where the mass is; another place is wanted", i + 1));
    }
  }
  if (std::adjacent_find(table.times_s.begin(), table.times_s.end(), [](double a, double b) { return !(a < b); }) !=
      table.times_s.end()) {
    throw InputError("the times of the trajectory do not increase");
  }
  if (!(table.times_s.front() <= table.first_s() && table.first_s() <= table.last_s() &&
        table.last_s() <= table.times_s.back())) {
    throw InputError(fmt::format("the useable times, {} s to {} s, do not lie within those of the rows, {} s to {} s",
                                 table.first_s(), table.last_s(), table.times_s.front(), table.times_s.back()));
  }
}

/// The first of the rows through which the polynomial goes between row `after` and the one before it.
std::size_t first_row(const OrbitTable& table, std::ptrdiff_t after) {
  const auto rows = static_cast<std::ptrdiff_t>(points(table)),
             count = static_cast<std::ptrdiff_t>(table.times_s.size());
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - (rows + 1) / 2, 0, count - rows));
}

template <class Real>
OrbitState<Real> interpolated(const OrbitTable& table, Real t_s) {
  const std::size_t rows = points(table);
  const std::size_t first =
      first_row(table, std::upper_bound(table.times_s.begin(), table.times_s.end(), static_cast<double>(t_s)) -
                           table.times_s.begin());
  // Neville's scheme, with its derivative by t beside it. With velocities each row is two nodes at the same time,
  // between which the slope is the velocity.
  const std::size_t of_row = table.velocities_m_s.empty() ? 1 : 2, nodes = of_row * rows;
  Vector3Of<Real> p[kHighestDegree + 1], v[kHighestDegree + 1];
  for (std::size_t i = 0; i < nodes; ++i) {
    p[i] = table.positions_m[first + i / of_row].template cast<Real>();
    v[i].setZero();
  }
  for (std::size_t k = 1; k < nodes; ++k) {
    for (std::size_t i = 0; i + k < nodes; ++i) {
      const std::size_t left = first + i / of_row, right = first + (i + k) / of_row;
      const Real a = table.times_s[left], b = table.times_s[right];
      if (left == right) {
        v[i] = table.velocities_m_s[left].template cast<Real>();
        p[i] += v[i] * (t_s - a);
        continue;
      }
      const Vector3Of<Real> slope = (p[i + 1] - p[i]) / (b - a);
      v[i] += (v[i + 1] - v[i]) * ((t_s - a) / (b - a)) + slope;
      p[i] += slope * (t_s - a);
    }
  }
  return {p[0], v[0]};
}

}  // namespace

TabulatedOrbit::TabulatedOrbit(std::vector<OrbitTable> tables) : tables_(std::move(tables)) {
  if (tables_.empty()) throw InputError("the trajectory is empty");
  for (std::size_t i = 0; i < tables_.size(); ++i) {
    check(tables_[i]);
    if (i == 0) continue;
    const double end_s = tables_[i - 1].last_s(), start_s = tables_[i].first_s();
    if (!(start_s <= end_s && end_s < tables_[i].last_s() && tables_[i - 1].first_s() < start_s)) {
      throw InputError(fmt::format("part {} of the trajectory, from {} s, does not follow on the part before, to {} s",
                                   i + 1, start_s, end_s));
    }
  }
}

std::vector<double> TabulatedOrbit::seams_s() const {
  std::vector<double> times_s;
  for (std::size_t i = 1; i < tables_.size(); ++i) times_s.push_back(tables_[i].first_s());
  return times_s;
}

TabulatedOrbit::Piece TabulatedOrbit::piece(double t_s, bool forward) const {
  const OrbitTable& table = table_at(t_s);
  const std::vector<double>& times = table.times_s;
  std::ptrdiff_t after = (forward ? std::upper_bound(times.begin(), times.end(), t_s)
                                  : std::lower_bound(times.begin(), times.end(), t_s)) -
                         times.begin();
  after = std::clamp<std::ptrdiff_t>(after, 1, static_cast<std::ptrdiff_t>(times.size()) - 1);
  const std::size_t first = first_row(table, after), rows = points(table);
  const std::size_t of_row = table.velocities_m_s.empty() ? 1 : 2, nodes = of_row * rows;
  // Newton's form, from divided differences; with velocities each row is two nodes at the same time.
  using Extended = long double;
  Vector3Of<Extended> difference[kHighestDegree + 1], sum[kHighestDegree + 1];
  const auto time = [&](std::size_t node) -> Extended { return times[first + node / of_row]; };
  for (std::size_t i = 0; i < nodes; ++i) difference[i] = table.positions_m[first + i / of_row].cast<Extended>();
  for (std::size_t k = 1; k < nodes; ++k) {
    for (std::size_t i = nodes - 1; i >= k; --i) {
      if (time(i) == time(i - k)) {
        difference[i] = table.velocities_m_s[first + i / of_row].cast<Extended>();
      } else {
        difference[i] = (difference[i] - difference[i - 1]) / (time(i) - time(i - k));
      }
    }
  }
  sum[0] = difference[nodes - 1];
  for (std::size_t k = 1; k < nodes; ++k) sum[k].setZero();
  for (std::size_t i = nodes - 1; i-- > 0;) {
    const Extended back = t_s - time(i);
    for (std::size_t k = nodes - 1; k > 0; --k) sum[k] = sum[k] * back + sum[k - 1];
    sum[0] = sum[0] * back + difference[i];
  }
  Piece piece{};
  piece.degree = static_cast<int>(nodes) - 1;
  for (std::size_t k = 0; k < nodes; ++k) piece.coefficients[k] = sum[k].cast<double>();
  const auto end = static_cast<std::size_t>(forward ? after : after - 1);
  piece.end_s = forward ? std::min(times[end], table.last_s()) : std::max(times[end], table.first_s());
  return piece;
}

const OrbitTable& TabulatedOrbit::table_at(double t_s) const {
  return *std::find_if(tables_.rbegin(), tables_.rend() - 1,
                       [t_s](const OrbitTable& table) { return table.first_s() <= t_s; });
}

double Trajectory::least_distance_m() const {
  if (const KeplerOrbit* const kepler = orbit()) return kepler->elements().periapsis_m;
  double least_m = std::numeric_limits<double>::infinity();
  for (const OrbitTable& one : std::get<1>(orbit_)->tables()) {
    for (const Vector3& position_m : one.positions_m) least_m = std::min(least_m, position_m.norm());
  }
  return least_m;
}

template <class Real>
OrbitState<Real> TabulatedOrbit::state(Real t_s) const {
  if (!(t_s >= Real(first_s()) && t_s <= Real(last_s()))) {
    throw InputError(fmt::format("the trajectory covers {} s to {} s, it was asked for at {} s", first_s(), last_s(),
                                 static_cast<double>(t_s)));
  }
  return interpolated(table_at(static_cast<double>(t_s)), t_s);
}

template OrbitState<double> TabulatedOrbit::state(double) const;
template OrbitState<long double> TabulatedOrbit::state(long double) const;

}  // namespace polhode
