#include "polhode/motion/values/edge_corrections.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace polhode {
namespace {

namespace dp = dormand_prince;
using Array4 = Eigen::Array4d;

/// The coefficients of powers of the polynomial that has these values at 0, 1/4, 1/2, 3/4, 1.
template <class Value>
std::array<Value, 5> powers(const std::array<Value, 5>& v) {
  constexpr double third = 1.0 / 3.0;
  return {v[0], third * (-25.0 * v[0] + 48.0 * v[1] - 36.0 * v[2] + 16.0 * v[3] - 3.0 * v[4]),
          third * (70.0 * v[0] - 208.0 * v[1] + 228.0 * v[2] - 112.0 * v[3] + 22.0 * v[4]),
          third * (-80.0 * v[0] + 288.0 * v[1] - 384.0 * v[2] + 224.0 * v[3] - 48.0 * v[4]),
          third * (32.0 * v[0] - 128.0 * v[1] + 192.0 * v[2] - 128.0 * v[3] + 32.0 * v[4])};
}

double value(const std::array<double, 5>& p, double x) {
  return p[0] + x * (p[1] + x * (p[2] + x * (p[3] + x * p[4])));
}

/// The same polynomial in powers of x - to.
template <class Value>
void shift(std::array<Value, 5>& p, double to) {
  for (std::size_t lowest = 0; lowest < 4; ++lowest) {
    for (std::size_t k = 4; k-- > lowest;) p[k] += to * p[k + 1];
  }
}

/// Where it is 0, between two places where its signs are different.
double root(const std::array<double, 5>& p, double low, double high) {
  const double at_low = value(p, low), at_high = value(p, high);
  double x = low + (high - low) * at_low / (at_low - at_high);
  for (int i = 0; i < 30; ++i) {
    const double c = value(p, x);
    ((c > 0.0) == (at_low > 0.0) ? low : high) = x;
    const double slope = p[1] + x * (2.0 * p[2] + x * (3.0 * p[3] + x * 4.0 * p[4]));
    double next = x - c / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const bool done = std::abs(next - x) < 1e-9;
    x = next;
    if (done) break;
  }
  return x;
}

/// For the powers 1 to 4 of the time since x, 0 before: what their integral over the step is more than what the stages
/// make of it, and what the stages make of the estimates, with the sign of a correction.
struct Missing {
  Array4 increment, fifth, third;

  explicit Missing(double x) : fifth(Array4::Zero()), third(Array4::Zero()) {
    const double rest = 1.0 - x, rest2 = rest * rest;
    increment = rest2 * Array4(1.0 / 2.0, rest / 3.0, rest2 / 4.0, rest2 * rest / 5.0);
    for (std::size_t i = 0; i < dp::kStages; ++i) {
      const double since = dp::kAbscissae[i] - x, weight = dp::kWeights[dp::kStages][i];
      if (!(since > 0.0) || (weight == 0.0 && dp::kFifthOrderError[i] == 0.0 && dp::kThirdOrder[i] == 0.0)) continue;
      const double since2 = since * since;
      const Array4 powers_of_it(since, since2, since2 * since, since2 * since2);
      increment -= weight * powers_of_it;
      fifth -= dp::kFifthOrderError[i] * powers_of_it;
      third -= (weight - dp::kThirdOrder[i]) * powers_of_it;
    }
  }
};

/// One stream along a step.
class Along {
 public:
  Along(const std::array<EdgeCorrections::Place, 5>& places, std::size_t stream) : places_(places), stream_(stream) {
    for (std::size_t i = 0; i < 5; ++i) from_[i] = places[i].streams[stream].from_body;
  }

  /// The cosines of an edge at the five places.
  std::array<double, 5> cosines(const FacetNormal& edge) const {
    std::array<double, 5> c{};
    for (std::size_t i = 0; i < 5; ++i) c[i] = edge.normal.dot(from_[i]);
    return c;
  }

  /// The derivatives of the unknowns per cosine, at the five places.
  std::array<Array4, 5> per_cosine(const FacetNormal& edge, const std::array<double, 5>& c) const {
    std::array<Array4, 5> f{};
    for (std::size_t i = 0; i < 5; ++i) {
      const Vector3 torque = edge.along_m3.cross(from_[i]) + c[i] * edge.square_m3 + edge.linear_m3;
      f[i] = (places_[i].columns * (-places_[i].streams[stream_].pressure_pa * torque)).array();
    }
    return f;
  }

 private:
  const std::array<EdgeCorrections::Place, 5>& places_;
  std::size_t stream_;
  std::array<Vector3, 5> from_;
};

}  // namespace

bool EdgeCorrections::find(const std::array<Place, 5>& places, double h) {
  increment.setZero(), fifth.setZero(), third.setZero();
  bool found = false;
  for (std::size_t stream = 0; stream < places[0].streams.size(); ++stream) {
    if (places[2].streams[stream].pressure_pa == 0.0) continue;
    const Along along(places, stream);
    for (const FacetNormal& edge : places[0].streams[stream].edges) {
      const std::array<double, 5> c = along.cosines(edge);
      const bool is_lit[3] = {c[0] > 0.0, c[2] > 0.0, c[4] > 0.0};
      if (is_lit[0] == is_lit[1] && is_lit[1] == is_lit[2]) continue;
      found = true;
      const std::array<double, 5> cosine = powers(c);
      const std::array<Array4, 5> per_cosine = powers(along.per_cosine(edge, c));
      for (std::size_t half = 0; half < 2; ++half) {
        if (is_lit[half] == is_lit[half + 1]) continue;
        const double x = root(cosine, 0.5 * static_cast<double>(half), 0.5 * static_cast<double>(half + 1));
        std::array<double, 5> g = cosine;
        std::array<Array4, 5> f = per_cosine;
        shift(g, x), shift(f, x);
        // Their product in powers of the time since x; the cosine begins with the first.
        const Array4 part[4] = {g[1] * f[0], g[1] * f[1] + g[2] * f[0], g[1] * f[2] + g[2] * f[1] + g[3] * f[0],
                                g[1] * f[3] + g[2] * f[2] + g[3] * f[1] + g[4] * f[0]};
        const Missing missing(x);
        const double sign = is_lit[half] ? -1.0 : 1.0;
        for (int n = 0; n < 4; ++n) {
          increment.head<4>() += sign * missing.increment[n] * part[n];
          fifth.head<4>() += sign * missing.fifth[n] * part[n];
          third.head<4>() += sign * missing.third[n] * part[n];
        }
      }
    }
  }
  increment *= h;
  return found;
}

}  // namespace polhode
