#include <algorithm>
#include <cmath>

#include "polhode/motion/taylor/equations.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode::taylor {

void exact_orbit(const Equations& equations, double t_high, double t_low, long double (&state)[3]) {
  const Equations::Orbit& o = equations.orbit;
  const long double t_s = (static_cast<long double>(t_high) + t_low) * equations.unit_s;
  const Vector3Of<long double> place = o.orbit->state(t_s).position_m;
  const auto axes = o.orbit->axes();
  const long double distance = place.norm();
  state[0] = place.dot(axes[0]) / distance;
  state[1] = place.dot(axes[1]) / distance;
  state[2] = std::sqrt(o.parameter_m / distance);
}

namespace {

constexpr double kShareOfTimeScale = 0.7;  // of a step in r/v: an encounter is never stepped over
constexpr double kCounts = 1e-18;          // of a coefficient, beside the first

/// A function of time by its coefficients up to an order.
using Coefficients = std::array<double, kMostOrder + 2>;

double product(const Coefficients& a, const Coefficients& b, int n) {
  double sum = 0.0;
  for (int j = 0; j <= n; ++j) sum += a[static_cast<std::size_t>(j)] * b[static_cast<std::size_t>(n - j)];
  return sum;
}

/// The coefficient n of a^exponent, from those before it.
double power(const Coefficients& a, double exponent, const Coefficients& result, int n) {
  if (n == 0) return std::pow(a[0], exponent);
  double sum = 0.0;
  for (int j = 1; j <= n; ++j) {
    sum += (j * exponent - (n - j)) * a[static_cast<std::size_t>(j)] * result[static_cast<std::size_t>(n - j)];
  }
  return sum / (n * a[0]);
}

/// The place of a body on its way, r, and powers of the distance.
struct Way {
  std::array<Coefficients, 3> r{};
  Coefficients square{}, per_cube{}, per_fifth{};
  int orders = 0;
  double longest = 0.0;
};

Way way_of(const Trajectory& trajectory, const Equations& equations, const StepStart& start, int order,
           double longest) {
  const double unit_s = equations.unit_s;
  const long double t_exact_s = (static_cast<long double>(start.t_high) + start.t_low) * unit_s;
  Way way;
  double rate = 0.0;
  const TabulatedOrbit* table = trajectory.table();
  if (table == nullptr) {
    const OrbitState<long double> state = trajectory.state(t_exact_s);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      way.r[i][0] = static_cast<double>(state.position_m[k]);
      way.r[i][1] = static_cast<double>(state.velocity_m_s[k] * unit_s);
    }
    rate = static_cast<double>(state.velocity_m_s.norm() / state.position_m.norm()) * unit_s;
    way.longest = kShareOfTimeScale / rate;
  } else {
    const double t_s = std::clamp(static_cast<double>(t_exact_s), table->first_s(), table->last_s());
    const TabulatedOrbit::Piece piece = table->piece(t_s, start.direction > 0);
    double scale = 1.0;
    for (int n = 0; n <= std::min(piece.degree, order); ++n) {
      for (std::size_t i = 0; i < 3; ++i) {
        way.r[i][static_cast<std::size_t>(n)] =
            piece.coefficients[static_cast<std::size_t>(n)][static_cast<Eigen::Index>(i)] * scale;
      }
      scale *= unit_s;
    }
    rate = piece.coefficients[1].norm() / piece.coefficients[0].norm() * unit_s;
    way.longest = std::min(kShareOfTimeScale / rate, std::abs(piece.end_s - t_s) / unit_s);
  }
  // From where on the coefficients no longer count within the step: those of r^-5 fall like (rate times the step)^n.
  const double shrink = rate * std::min(longest, way.longest);
  way.orders = shrink < 0.9 ? std::clamp(static_cast<int>(std::log(kCounts) / std::log(shrink)) + 1, 4, order) : order;
  const KeplerOrbit* orbit = trajectory.orbit();
  const double pull = orbit != nullptr ? -orbit->elements().mu_m3_s2 * unit_s * unit_s : 0.0;
  for (int n = 0; n <= way.orders; ++n) {
    const auto at = static_cast<std::size_t>(n);
    way.square[at] = product(way.r[0], way.r[0], n) + product(way.r[1], way.r[1], n) + product(way.r[2], way.r[2], n);
    way.per_cube[at] = power(way.square, -1.5, way.per_cube, n);
    way.per_fifth[at] = power(way.square, -2.5, way.per_fifth, n);
    if (orbit == nullptr || n + 2 > order) continue;
    for (Coefficients& r : way.r) r[at + 2] = pull * product(r, way.per_cube, n) / ((n + 1.0) * (n + 2.0));
  }
  return way;
}

}  // namespace

void find_surroundings(const Equations& equations, const StepStart& start, int order, double longest,
                       Surroundings& out) {
  const auto orders = static_cast<std::size_t>(order) + 1;
  for (auto& series : out.tide) std::fill_n(series, orders, 0.0);
  for (auto& series : out.field) std::fill_n(series, orders, 0.0);
  for (auto& series : out.change) std::fill_n(series, orders, 0.0);
  out.longest = longest;
  const double unit_s = equations.unit_s;
  for (const Torque& torque : equations.torques->list()) {
    if (const auto* pull = std::get_if<GravityGradient>(&torque)) {
      const Way way = way_of(pull->trajectory, equations, start, order, longest);
      out.longest = std::min(out.longest, way.longest);
      const double strength = 3.0 * pull->mu_m3_s2 * unit_s * unit_s;
      constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}};
      for (std::size_t p = 0; p < 6; ++p) {
        Coefficients both{};
        for (int n = 0; n <= way.orders; ++n) {
          both[static_cast<std::size_t>(n)] =
              product(way.r[static_cast<std::size_t>(pairs[p][0])], way.r[static_cast<std::size_t>(pairs[p][1])], n);
          out.tide[p][n] += strength * product(both, way.per_fifth, n);
        }
      }
    } else if (const auto* eddy = std::get_if<EddyCurrents>(&torque)) {
      const Way way = way_of(eddy->trajectory, equations, start, order, longest);
      out.longest = std::min(out.longest, way.longest);
      Coefficients along{};  // of the dipole
      for (int n = 0; n <= way.orders; ++n) {
        const auto at = static_cast<std::size_t>(n);
        for (std::size_t i = 0; i < 3; ++i) {
          along[at] += eddy->dipole_axis[static_cast<Eigen::Index>(i)] * way.r[i][at];
        }
      }
      for (std::size_t i = 0; i < 3; ++i) {
        Coefficients both{};
        const double axis = eddy->dipole_axis[static_cast<Eigen::Index>(i)];
        for (int n = 0; n <= way.orders; ++n) {
          both[static_cast<std::size_t>(n)] = product(along, way.r[i], n);
          out.field[i][n] = eddy->dipole_t_m3 *
                            (3.0 * product(both, way.per_fifth, n) - axis * way.per_cube[static_cast<std::size_t>(n)]);
          if (n > 0) out.change[i][n - 1] = n * out.field[i][n];
        }
      }
    }
  }
}

}  // namespace polhode::taylor
