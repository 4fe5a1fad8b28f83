// Included once by each target_*.cpp, which is compiled for its own instruction set.

#include "polhode/motion/theta/lanes.hpp"
#include "polhode/motion/variation/window.hpp"

namespace polhode::variation {
inline namespace POLHODE_TARGET {
namespace {

using theta::all;
using theta::kLanes;
using theta::Lanes;
using theta::load;
using theta::magnitude;
using theta::multiply_add;
using theta::square_root;
using theta::store;

/// Inertial, at one point or as many as a register holds.
template <class V>
struct Three {
  V x, y, z;
};
template <class V>
inline Three<V> operator+(Three<V> a, Three<V> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class V>
inline Three<V> operator-(Three<V> a, Three<V> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class V>
inline Three<V> operator*(V s, Three<V> a) {
  return {s * a.x, s * a.y, s * a.z};
}
/// s a + b
template <class V>
inline Three<V> multiply_add(V s, Three<V> a, Three<V> b) {
  return {multiply_add(s, a.x, b.x), multiply_add(s, a.y, b.y), multiply_add(s, a.z, b.z)};
}
template <class V>
inline V dot(Three<V> a, Three<V> b) {
  return multiply_add(a.x, b.x, multiply_add(a.y, b.y, V(a.z * b.z)));
}
template <class V>
inline Three<V> cross(Three<V> a, Three<V> b) {
  return {multiply_add(a.y, b.z, V(-(a.z * b.y))), multiply_add(a.z, b.x, V(-(a.x * b.z))),
          multiply_add(a.x, b.y, V(-(a.y * b.x)))};
}
template <class V>
inline Three<V> all_of(const double* a) {
  return {all<V>(a[0]), all<V>(a[1]), all<V>(a[2])};
}
template <class V>
inline Three<V> get(const AtPoints* v, int i) {
  return {load<V>(v[0] + i), load<V>(v[1] + i), load<V>(v[2] + i)};
}
template <class V>
inline void put(Three<V> a, AtPoints* v, int i) {
  store(v[0] + i, a.x);
  store(v[1] + i, a.y);
  store(v[2] + i, a.z);
}
/// Symmetric matrix (11, 22, 33, 23, 31, 12) times vector.
template <class V>
inline Three<V> times(const AtPoints* matrix, int i, Three<V> v) {
  const V j1 = load<V>(matrix[0] + i), j2 = load<V>(matrix[1] + i), j3 = load<V>(matrix[2] + i);
  const V j23 = load<V>(matrix[3] + i), j31 = load<V>(matrix[4] + i), j12 = load<V>(matrix[5] + i);
  return {multiply_add(j1, v.x, multiply_add(j12, v.y, V(j31 * v.z))),
          multiply_add(j12, v.x, multiply_add(j2, v.y, V(j23 * v.z))),
          multiply_add(j31, v.x, multiply_add(j23, v.y, V(j3 * v.z)))};
}

void find_places(const Reference& r, int points, Places& p) {
  using V = Lanes;
  const V one = all<V>(1.0), two = all<V>(2.0);
  const Three<V> along = all_of<V>(r.along);
  for (int i = 0; i < points; i += kLanes) {
    const V w = load<V>(p.q[0] + i), x = load<V>(p.q[1] + i), y = load<V>(p.q[2] + i), z = load<V>(p.q[3] + i);
    const Three<V> e[3] = {{one - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)},
                           {two * (x * y - w * z), one - two * (x * x + z * z), two * (y * z + w * x)},
                           {two * (x * z + w * y), two * (y * z - w * x), one - two * (x * x + y * y)}};
    const auto tensor = [&](const double* of, AtPoints* out) {
      const Three<V> f1 = all<V>(of[0]) * e[0], f2 = all<V>(of[1]) * e[1], f3 = all<V>(of[2]) * e[2];
      const auto entry = [&](int at, V a1, V b1, V a2, V b2, V a3, V b3) {
        store(out[at] + i, multiply_add(a1, b1, multiply_add(a2, b2, V(a3 * b3))));
      };
      entry(0, e[0].x, f1.x, e[1].x, f2.x, e[2].x, f3.x);
      entry(1, e[0].y, f1.y, e[1].y, f2.y, e[2].y, f3.y);
      entry(2, e[0].z, f1.z, e[1].z, f2.z, e[2].z, f3.z);
      entry(3, e[0].y, f1.z, e[1].y, f2.z, e[2].y, f3.z);
      entry(4, e[0].z, f1.x, e[1].z, f2.x, e[2].z, f3.x);
      entry(5, e[0].x, f1.y, e[1].x, f2.y, e[2].x, f3.y);
    };
    tensor(r.moments, p.inertia);
    tensor(r.inverse_moments, p.inverse_inertia);
    const V m1 = dot(e[0], along), m2 = dot(e[1], along), m3 = dot(e[2], along);  // in the body
    const Three<V> omega = (all<V>(r.magnitude * r.inverse_moments[0]) * m1) * e[0] +
                           ((all<V>(r.magnitude * r.inverse_moments[1]) * m2) * e[1] +
                            (all<V>(r.magnitude * r.inverse_moments[2]) * m3) * e[2]);
    const Three<V> across = omega - all<V>(r.along_rad_s) * along;
    const V square = dot(across, across), reciprocal = one / square;
    put(omega, p.omega, i);
    put(across, p.across, i);
    store(p.reciprocal_square + i, reciprocal);
    store(p.shear_rate + i, V(all<V>(r.shear_by_rate) * square));
    store(p.shear_swing + i, V(all<V>(r.shear_by_swing) * (m1 * m2 * m3 * reciprocal)));
  }
}

void find_series(const double* coefficients, int degree, double base_s, double scale_1_s, const AtPoints& since_base_s,
                 AtPoints* states) {
  using V = Lanes;
  for (int i = 0; i < kPoints; i += kLanes) {
    const V x = all<V>(scale_1_s) * (load<V>(since_base_s + i) + all<V>(base_s)), twice = x + x;
    V b[6] = {}, after[6] = {};
    for (int j = degree; j > 0; --j) {
      for (int k = 0; k < 6; ++k) {
        const V next = multiply_add(twice, b[k], V(all<V>(coefficients[6 * j + k]) - after[k]));
        after[k] = b[k];
        b[k] = next;
      }
    }
    for (int k = 0; k < 6; ++k) store(states[k] + i, multiply_add(x, b[k], V(all<V>(coefficients[k]) - after[k])));
  }
}

void find_pull(const AtPoints* position_m, double root_of_three_mu, AtPoints* pull) {
  using V = Lanes;
  for (int i = 0; i < kPoints; i += kLanes) {
    const Three<V> r = get<V>(position_m, i);
    const V square = dot(r, r);
    put(V(all<V>(root_of_three_mu) / (square * square_root(square_root(square)))) * r, pull, i);
  }
}

/// The rotation vector of the deviation; mu in units of the free motion's momentum.
template <class V>
inline Three<V> angle_of(const Reference& r, const Places& p, int i, Three<V> mu, V a0, V a1, V a2) {
  const Three<V> along = all_of<V>(r.along), across = get<V>(p.across, i);
  const V s = load<V>(p.since_base_s + i), sheared = all<V>(r.across_rad_s) * a2;
  const V shear = load<V>(p.shear_swing + i) + load<V>(p.shear + i);
  const Three<V> rest = multiply_add(V(dot(along, mu) * s), get<V>(p.omega, i), V(a0 - s * sheared) * along);
  const Three<V> by_first =
      multiply_add(V(multiply_add(shear, a2, V(all<V>(1.0 / r.across_rad_s) * a1))), across, rest);
  return cross(along, multiply_add(V(load<V>(p.reciprocal_square + i) * sheared), across, mu)) + by_first;
}

template <class V>
inline Three<V> relative_momentum(const Reference& r, const AtPoints* y, int i) {
  return all<V>(1.0 / r.magnitude) * get<V>(y, i);
}

template <class V>
inline Three<V> angle_in(const Reference& r, const Places& p, const AtPoints* y, int i) {
  return angle_of(r, p, i, relative_momentum<V>(r, y, i), load<V>(y[3] + i), load<V>(y[4] + i), load<V>(y[5] + i));
}

void angle(const Reference& r, const Places& p, const AtPoints* y, int point, double* rotation_vector) {
  const Three<double> theta = angle_in<double>(r, p, y, point);
  rotation_vector[0] = theta.x, rotation_vector[1] = theta.y, rotation_vector[2] = theta.z;
}

void feel_gravity_gradients(const Reference& r, const Places& p, const AtPoints* pulls, std::size_t masses,
                            const AtPoints* y, int points, Felt& felt) {
  using V = Lanes;
  const V half = all<V>(0.5);
  for (int i = 0; i < points; i += kLanes) {
    const Three<V> theta = angle_in<V>(r, p, y, i);
    put(theta, felt.angle, i);
    const V c = square_root(magnitude(V(all<V>(1.0) - all<V>(0.25) * dot(theta, theta))));
    Three<V> sum{};
    for (std::size_t k = 0; k < masses; ++k) {
      // In the axes of the free motion: turned back by the deviation, and forth again.
      const Three<V> there = get<V>(pulls + 3 * k, i), turned = cross(theta, there);
      const Three<V> u = multiply_add(half, cross(theta, turned), multiply_add(V(-c), turned, there));
      sum = sum + cross(u, times(p.inertia, i, u));
    }
    const Three<V> turned = cross(theta, sum);
    put(multiply_add(half, cross(theta, turned), multiply_add(c, turned, sum)), felt.torque, i);
  }
}

void find_gradients(const Reference& r, const Places& p, const AtPoints* pulls, std::size_t masses, const AtPoints* y,
                    Felt& felt) {
  using V = Lanes;
  const V one = all<V>(1.0), half = all<V>(0.5);
  for (int i = 0; i < kPoints; i += kLanes) {
    // Half way from where it was felt: so it takes the second order with it.
    const Three<V> theta = half * (get<V>(felt.angle, i) + angle_in<V>(r, p, y, i));
    const V c = square_root(magnitude(V(one - all<V>(0.25) * dot(theta, theta)))), quarter = all<V>(0.25) / c;
    // In the axes of the free motion: by what turn there a step of each component goes with.
    const V along[3] = {quarter * theta.x, quarter * theta.y, quarter * theta.z};
    const Three<V> turn[3] = {{multiply_add(along[0], theta.x, c), multiply_add(along[0], theta.y, V(-half * theta.z)),
                               multiply_add(along[0], theta.z, V(half * theta.y))},
                              {multiply_add(along[1], theta.x, V(half * theta.z)), multiply_add(along[1], theta.y, c),
                               multiply_add(along[1], theta.z, V(-half * theta.x))},
                              {multiply_add(along[2], theta.x, V(-half * theta.y)),
                               multiply_add(along[2], theta.y, V(half * theta.x)), multiply_add(along[2], theta.z, c)}};
    Three<V> sum[3] = {};
    for (std::size_t k = 0; k < masses; ++k) {
      const Three<V> there = get<V>(pulls + 3 * k, i), turned = cross(theta, there);
      const Three<V> u = multiply_add(half, cross(theta, turned), multiply_add(V(-c), turned, there));
      const Three<V> w = times(p.inertia, i, u), torque = cross(u, w);
      for (int l = 0; l < 3; ++l) {
        const Three<V> moved = cross(turn[l], u);
        sum[l] = sum[l] + ((cross(turn[l], torque) - cross(moved, w)) - cross(u, times(p.inertia, i, moved)));
      }
    }
    for (int l = 0; l < 3; ++l) {
      const Three<V> turned = cross(theta, sum[l]);
      put(multiply_add(half, cross(theta, turned), multiply_add(c, turned, sum[l])), felt.gradient + 3 * l, i);
    }
  }
}

inline double largest_of(Lanes a) {
  double largest = a[0];
  for (int i = 1; i < kLanes; ++i) largest = largest < a[i] ? a[i] : largest;
  return largest;
}
inline Lanes larger(Lanes a, Lanes b) { return -theta::smaller(-a, -b); }

void find_rates(const Reference& r, const Places& p, const Felt& felt, const AtPoints* y, AtPoints* rates,
                double* away_rad) {
  using V = Lanes;
  const V one = all<V>(1.0), half = all<V>(0.5), unit = all<V>(r.magnitude), reciprocal = all<V>(1.0 / r.magnitude);
  const Three<V> along = all_of<V>(r.along);
  for (int i = 0; i < kPoints; i += kLanes) {
    const Three<V> mu = relative_momentum<V>(r, y, i);  // all momenta in units of the free motion's
    const Three<V> theta = angle_of(r, p, i, mu, load<V>(y[3] + i), load<V>(y[4] + i), load<V>(y[5] + i));
    const V s = all<V>(0.25) * dot(theta, theta);
    const V c = square_root(magnitude(V(one - s))), less = s / (one + c);  // 1 - c
    // The momentum turned back, less the free motion's; `second` is its part of second order.
    const Three<V> turned = cross(theta, along), turned_mu = cross(theta, mu);
    const Three<V> second =
        multiply_add(half, cross(theta, turned + turned_mu), multiply_add(less, turned, V(-c) * turned_mu));
    const Three<V> momentum = (mu - turned) + second;
    // N, and the rate less the free motion's.
    const Three<V> omega = get<V>(p.omega, i), rate = unit * times(p.inverse_inertia, i, momentum);
    const Three<V> relaxation = get<V>(felt.relaxation, i);
    const Three<V> turned_omega = cross(theta, omega), turned_rate = cross(theta, rate);
    const Three<V> once = turned_omega + turned_rate, twice = half * cross(theta, once);
    const Three<V> more = multiply_add(c, once, rate + twice + relaxation);
    Three<V> n = multiply_add(unit, times(p.inverse_inertia, i, second), half * cross(more, theta));
    n = multiply_add(V(-less), rate, multiply_add(V(-s), turned_omega, n));
    n = multiply_add(c, multiply_add(c, turned_rate, twice + relaxation), n);
    const Three<V> moved = theta - get<V>(felt.angle, i);
    store(away_rad + i, square_root(dot(moved, moved)));
    Three<V> torque = get<V>(felt.torque, i);
    torque = multiply_add(moved.x, get<V>(felt.gradient, i), torque);
    torque = multiply_add(moved.y, get<V>(felt.gradient + 3, i), torque);
    torque = multiply_add(moved.z, get<V>(felt.gradient + 6, i), torque);
    const Three<V> relative = reciprocal * torque;
    const V since_base_s = load<V>(p.since_base_s + i);
    const Three<V> rest = multiply_add(V(-dot(along, relative) * since_base_s), omega, n - cross(along, relative));
    put(torque, rates, i);
    const Three<V> across = get<V>(p.across, i);
    const V first = all<V>(r.across_rad_s), a2 = all<V>(1.0 / r.across_rad_s) * dot(rest, cross(along, across));
    const V shear = load<V>(p.shear_swing + i) + load<V>(p.shear + i);
    store(rates[3] + i, multiply_add(V(first * since_base_s), a2, dot(rest, along)));
    store(rates[4] + i, V(first * multiply_add(dot(rest, across), load<V>(p.reciprocal_square + i), V(-(shear * a2)))));
    store(rates[5] + i, a2);
  }
}

/// As many components as leave registers free.
#if defined(__AVX__)
constexpr int kTogether = 6;
#else
constexpr int kTogether = 3;
#endif

void integrate(const Grid& grid, const AtPoints* rates, double half_s, const double* start, AtPoints* y,
               double* changes) {
  constexpr int kRegisters = kRegister / kLanes;
  for (int done = 0; done < kCoefficients; done += kTogether) {
    Lanes change[kTogether] = {};
    for (int first = 0; first < kPoints; first += kRegister) {
      Lanes sum[kTogether][kRegisters] = {};
      for (int j = 0; j < kPoints; ++j) {
        Lanes row[kRegisters];
        for (int i = 0; i < kRegisters; ++i) row[i] = load<Lanes>(grid.integral[j] + first + i * kLanes);
        for (int c = 0; c < kTogether; ++c) {
          const Lanes rate = all<Lanes>(rates[done + c][j]);
          for (int i = 0; i < kRegisters; ++i) sum[c][i] = multiply_add(rate, row[i], sum[c][i]);
        }
      }
      for (int c = 0; c < kTogether; ++c) {
        for (int i = 0; i < kRegisters; ++i) {
          double* at = y[done + c] + first + i * kLanes;
          const Lanes now = multiply_add(all<Lanes>(half_s), sum[c][i], all<Lanes>(start[done + c]));
          change[c] = larger(change[c], magnitude(now - load<Lanes>(at)));
          store(at, now);
        }
      }
    }
    for (int c = 0; c < kTogether; ++c) changes[done + c] = largest_of(change[c]);
  }
}

void add_products(const AtPoints* rows, int count, const AtPoints* values, int components, double by, AtPoints* to) {
  constexpr int kRegisters = kPoints / kLanes;
  for (int c = 0; c < components; ++c) {
    Lanes sum[kRegisters] = {};
    for (int j = 0; j < count; ++j) {
      const Lanes value = all<Lanes>(by * values[c][j]);
      for (int i = 0; i < kRegisters; ++i) sum[i] = multiply_add(value, load<Lanes>(rows[j] + i * kLanes), sum[i]);
    }
    for (int i = 0; i < kRegisters; ++i) store(to[c] + i * kLanes, load<Lanes>(to[c] + i * kLanes) + sum[i]);
  }
}

void find_spectrum(const Grid& grid, const AtPoints* values, int components, Spectrum& spectrum) {
  for (int k = 0; k < components; ++k) {
    Lanes sums[4] = {}, largest = {};
    for (int i = 0; i < kPoints; i += kLanes) {
      const Lanes value = load<Lanes>(values[k] + i);
      for (int l = 0; l < 4; ++l) sums[l] = multiply_add(load<Lanes>(grid.coefficients[l] + i), value, sums[l]);
      largest = larger(largest, magnitude(value));
    }
    for (int l = 0; l < 4; ++l) {
      double sum = 0.0;
      for (int i = 0; i < kLanes; ++i) sum += sums[l][i];
      spectrum.coefficients[l][k] = sum;
    }
    spectrum.largest[k] = largest_of(largest);
  }
}

constexpr Kernel kernel(const char* name) {
  return {name,      find_places,  find_series,   find_pull, feel_gravity_gradients, find_gradients, find_rates,
          integrate, add_products, find_spectrum, angle};
}

}  // namespace
}  // namespace POLHODE_TARGET
}  // namespace polhode::variation
