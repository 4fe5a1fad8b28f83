// Included once by each target_*.cpp, which is compiled for its own instruction set.

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "polhode/motion/theta/lanes.hpp"
#include "polhode/observe/kernel/target.hpp"

namespace polhode::brightness {
inline namespace POLHODE_TARGET {
namespace {

using theta::all;
using theta::kLanes;
using theta::Lanes;
using theta::multiply_add;
using theta::square_root;

/// A register of instants, or the last few.
inline Lanes load(const double* from) {
  Lanes out;
  std::memcpy(&out, from, sizeof out);
  return out;
}
inline Lanes load(const double* from, std::size_t count) {
  if (count == kLanes) return load(from);
  Lanes out = all<Lanes>(0.0);
  std::memcpy(&out, from, std::min<std::size_t>(count, kLanes) * sizeof(double));
  return out;
}
inline void store(double* to, Lanes value, std::size_t count) {
  if (count == kLanes) {
    std::memcpy(to, &value, sizeof value);
  } else {
    std::memcpy(to, &value, std::min<std::size_t>(count, kLanes) * sizeof(double));
  }
}

inline Lanes larger(Lanes a, Lanes b) {
#if defined(__AVX512F__)
  return _mm512_max_pd(a, b);
#elif defined(__AVX2__)
  return _mm256_max_pd(a, b);
#elif defined(__SSE2__)
  return _mm_max_pd(a, b);
#else
  for (int i = 0; i < kLanes; ++i) a[i] = a[i] > b[i] ? a[i] : b[i];
  return a;
#endif
}

/// a where b > 0, else 0.
inline Lanes where_positive(Lanes a, Lanes b) {
  const theta::LaneBits mask = b > all<Lanes>(0.0);
  return theta::value<Lanes>(theta::bits(a) & mask);
}

struct Three {
  Lanes x, y, z;
};

inline Lanes dot(const Three& a, const Three& b) { return multiply_add(a.x, b.x, multiply_add(a.y, b.y, a.z * b.z)); }

inline Three cross(const Three& a, const Three& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Calls work(first, how many) for each register of instants; for whole registers with a number known to the compiler.
template <class Task>
void for_registers(std::size_t count, const Task& task) {
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) task(i, std::integral_constant<std::size_t, kLanes>{});
  if (i < count) task(i, count - i);
}

/// Pointers of its own, which no store can change.
struct ThreeArrays {
  explicit ThreeArrays(const double* const from[3]) : x(from[0]), y(from[1]), z(from[2]) {}
  const double *x, *y, *z;
  template <class Count>
  Three load(std::size_t i, Count n) const {
    return {brightness::load(x + i, n), brightness::load(y + i, n), brightness::load(z + i, n)};
  }
};

template <bool mapped>
void turn_by(std::size_t count, const double* const q[4], const Directions& in, const double (&map)[9],
             double* const observer[3], double* const sun[3]) {
  const double* const scalar = q[0];
  const ThreeArrays vector(q + 1), from[2] = {ThreeArrays(in.observer), ThreeArrays(in.sun)};
  double* const to[2][3] = {{observer[0], observer[1], observer[2]}, {sun[0], sun[1], sun[2]}};
  const auto row_of_map = [&map](int row) {
    return Three{all<Lanes>(map[3 * row]), all<Lanes>(map[3 * row + 1]), all<Lanes>(map[3 * row + 2])};
  };
  const Three rows[3] = {row_of_map(0), row_of_map(1), row_of_map(2)};
  const Lanes one = all<Lanes>(1.0);
  for_registers(count, [&](std::size_t i, auto n) {
    const Lanes w = load(scalar + i, n);
    const Three p = vector.load(i, n);
    // The rows of R(q)^T.
    const Lanes x2 = p.x + p.x, y2 = p.y + p.y, z2 = p.z + p.z;
    const Lanes wx = w * x2, wy = w * y2, wz = w * z2;
    const Three first{one - multiply_add(p.y, y2, p.z * z2), multiply_add(p.x, y2, wz), multiply_add(p.x, z2, -wy)};
    const Three second{multiply_add(p.x, y2, -wz), one - multiply_add(p.x, x2, p.z * z2), multiply_add(p.y, z2, wx)};
    const Three third{multiply_add(p.x, z2, wy), multiply_add(p.y, z2, -wx), one - multiply_add(p.x, x2, p.y * y2)};
    for (int k = 0; k < 2; ++k) {
      const Three v = from[k].load(i, n);
      Three b{dot(first, v), dot(second, v), dot(third, v)};
      if constexpr (mapped) b = {dot(rows[0], b), dot(rows[1], b), dot(rows[2], b)};
      store(to[k][0] + i, b.x, n);
      store(to[k][1] + i, b.y, n);
      store(to[k][2] + i, b.z, n);
    }
  });
}

void turn(std::size_t count, const double* const q[4], const Directions& in, const double (&map)[9],
          double* const observer[3], double* const sun[3]) {
  constexpr double identity[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  if (std::equal(map, map + 9, identity)) {
    turn_by<false>(count, q, in, map, observer, sun);
  } else {
    turn_by<true>(count, q, in, map, observer, sun);
  }
}

void ellipsoid_area(std::size_t count, const Directions& stretched, double volume, double* area) {
  const Lanes factor = all<Lanes>(1.5707963267948966 * volume);
  const ThreeArrays observer(stretched.observer), sun(stretched.sun);
  for_registers(count, [&](std::size_t i, auto n) {
    const Three e = observer.load(i, n), s = sun.load(i, n);
    const Lanes es = dot(e, s), ee = dot(e, e), ss = dot(s, s);
    // |e| + e.s / |s|; where the two are opposite it is 0, up to rounding.
    const Lanes sum = square_root(ee) + es / square_root(ss);
    store(area + i, factor * larger(sum, all<Lanes>(0.0)), n);
  });
}

/// Natural logarithm of what is finite and at least 1, within 2e-15 (absolute below 1.5, else of itself).
inline Lanes logarithm(Lanes a) {
  constexpr std::int64_t half_up = 0x0009'5f61'9980'c433;  // the bits of 1 less those of 1/sqrt(2)
  const theta::LaneBits raw = theta::bits(a);
  const theta::LaneBits exponent = ((raw + half_up) >> 52) - 1023;
  const Lanes m = theta::value<Lanes>(raw - (exponent << 52));  // 0.7 to 1.42
  const Lanes one = all<Lanes>(1.0);
  const Lanes r = (m - one) / (m + one);
  const Lanes z = r * r;
  // 2 artanh(r) by its series: r^2 < 0.0295, the first term left out is below 1e-17.
  Lanes sum = all<Lanes>(1.0 / 19.0);
  for (const double odd : {17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0}) {
    sum = multiply_add(sum, z, all<Lanes>(1.0 / odd));
  }
  const Lanes log_m = multiply_add(r + r, sum * z, r + r);
  // A whole number below 2^51 as a double.
  constexpr double shift = 0x1.8p52;
  const Lanes k = theta::value<Lanes>(exponent + theta::bits(all<Lanes>(shift))) - all<Lanes>(shift);
  return multiply_add(k, all<Lanes>(0.6931471805599453), log_m);
}

void ellipsoid_lommel_seeliger(std::size_t count, const Directions& stretched, double volume, double* brightness) {
  // With p = e + s at the angle l from e and b from s, in the stretched space where the ellipsoid is a sphere:
  // (pi/2) V |e| |s| / |p| (cos l + cos b - sin l sin b ln(cot(l/2) cot(b/2))).
  const Lanes zero = all<Lanes>(0.0), one = all<Lanes>(1.0);
  const ThreeArrays observer(stretched.observer), sun(stretched.sun);
  for_registers(count, [&](std::size_t i, auto n) {
    const Three e = observer.load(i, n), s = sun.load(i, n);
    const Lanes ee = dot(e, e), ss = dot(s, s), es = dot(e, s);
    const Lanes pp = larger(ee + es + es + ss, all<Lanes>(1e-300));
    const Three c = cross(e, s);
    const Lanes cc = dot(c, c);
    const Lanes length_e = square_root(ee), length_s = square_root(ss), length_p = square_root(pp);
    const Lanes product = length_e * length_s;
    const Lanes cos_l = (ee + es) / (length_e * length_p), cos_b = (ss + es) / (length_s * length_p);
    const Lanes sines = cc / (product * pp);
    const Lanes tiny = all<Lanes>(1e-30);  // sines ln(1/sines) is 0 there to the last digit
    const Lanes cotangents = (one + cos_l) * (one + cos_b) / larger(sines, tiny);
    const Lanes sum = cos_l + cos_b - sines * logarithm(larger(cotangents, one));
    store(brightness + i, all<Lanes>(1.5707963267948966 * volume) * product / length_p * larger(sum, zero), n);
  });
}

enum class Law { area, lommel_seeliger, both };

/// `instants` at a time, so that a facet is read once for all of them.
template <Law law, int instants>
void sum_facets(std::size_t first, const Directions& in, const FacetArrays& facets, const LawWeights& weights,
                const Results& out) {
  const Lanes zero = all<Lanes>(0.0);
  const Lanes tiny = all<Lanes>(1e-300);  // 0 / tiny where a facet is neither lit nor seen
  Three e[instants], s[instants];
  Lanes seen[instants], scattered[instants], diffuse[instants];
  for (int j = 0; j < instants; ++j) {
    const std::size_t i = first + static_cast<std::size_t>(j);
    e[j] = {all<Lanes>(in.observer[0][i]), all<Lanes>(in.observer[1][i]), all<Lanes>(in.observer[2][i])};
    s[j] = {all<Lanes>(in.sun[0][i]), all<Lanes>(in.sun[1][i]), all<Lanes>(in.sun[2][i])};
    seen[j] = scattered[j] = diffuse[j] = zero;
  }
  for (std::size_t f = 0; f < facets.count; f += kLanes) {
    const Three normal{load(facets.normal[0] + f), load(facets.normal[1] + f), load(facets.normal[2] + f)};
    Lanes inverse_area = zero;
    if constexpr (law == Law::both) inverse_area = load(facets.inverse_area + f);
    for (int j = 0; j < instants; ++j) {
      const Lanes mu = larger(dot(normal, e[j]), zero), mu0 = larger(dot(normal, s[j]), zero);
      seen[j] += where_positive(mu, mu0);
      if constexpr (law != Law::area) {
        const Lanes product = mu * mu0;
        scattered[j] += product / (mu + mu0 + tiny);
        if constexpr (law == Law::both) diffuse[j] = multiply_add(product, inverse_area, diffuse[j]);
      }
    }
  }
  for (int j = 0; j < instants; ++j) {
    double sums[3] = {};
    for (int k = 0; k < kLanes; ++k) {
      sums[0] += seen[j][k];
      sums[1] += scattered[j][k];
      sums[2] += diffuse[j][k];
    }
    const std::size_t i = first + static_cast<std::size_t>(j);
    out.area[i] = sums[0];
    out.brightness[i] = law == Law::area ? sums[0] : weights.lommel_seeliger * sums[1] + weights.lambert * sums[2];
  }
}

template <Law law>
void facets_by(std::size_t count, const Directions& in, const FacetArrays& facets, const LawWeights& weights,
               const Results& out) {
  constexpr int together = kLanes == 8 ? 4 : 2;  // as the registers allow
  std::size_t i = 0;
  for (; i + together <= count; i += together) sum_facets<law, together>(i, in, facets, weights, out);
  for (; i < count; ++i) sum_facets<law, 1>(i, in, facets, weights, out);
}

void facets_at(std::size_t count, const Directions& in, const FacetArrays& facets, const LawWeights& law,
               const Results& out) {
  if (law.lambert != 0.0) {
    facets_by<Law::both>(count, in, facets, law, out);
  } else if (law.lommel_seeliger != 0.0) {
    facets_by<Law::lommel_seeliger>(count, in, facets, law, out);
  } else {
    facets_by<Law::area>(count, in, facets, law, out);
  }
}

}  // namespace
}  // namespace POLHODE_TARGET
}  // namespace polhode::brightness
