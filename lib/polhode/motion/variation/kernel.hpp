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
inline Three<V> get(const InSlots* v, int i) {
  return {load<V>(v[0] + i), load<V>(v[1] + i), load<V>(v[2] + i)};
}
template <class V>
inline void put(Three<V> a, InSlots* v, int i) {
  store(v[0] + i, a.x);
  store(v[1] + i, a.y);
  store(v[2] + i, a.z);
}
/// Symmetric matrix (11, 22, 33, 23, 31, 12) times vector.
template <class V>
inline Three<V> times(const InSlots* matrix, int i, Three<V> v) {
  const V j1 = load<V>(matrix[0] + i), j2 = load<V>(matrix[1] + i), j3 = load<V>(matrix[2] + i);
  const V j23 = load<V>(matrix[3] + i), j31 = load<V>(matrix[4] + i), j12 = load<V>(matrix[5] + i);
  return {multiply_add(j1, v.x, multiply_add(j12, v.y, V(j31 * v.z))),
          multiply_add(j12, v.x, multiply_add(j2, v.y, V(j23 * v.z))),
          multiply_add(j31, v.x, multiply_add(j23, v.y, V(j3 * v.z)))};
}

void find_places(const Reference& r, int from, int to, Places& p) {
  using V = Lanes;
  const V one = all<V>(1.0), two = all<V>(2.0);
  const Three<V> along = all_of<V>(r.along);
  for (int i = from; i < to; i += kLanes) {
    const V w = load<V>(p.q[0] + i), x = load<V>(p.q[1] + i), y = load<V>(p.q[2] + i), z = load<V>(p.q[3] + i);
    const Three<V> e[3] = {{one - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)},
                           {two * (x * y - w * z), one - two * (x * x + z * z), two * (y * z + w * x)},
                           {two * (x * z + w * y), two * (y * z - w * x), one - two * (x * x + y * y)}};
    const auto tensor = [&](const double* of, InSlots* out) {
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

void find_series(const double* coefficients, int degree, double base_s, double scale_1_s, const InSlots& since_base_s,
                 int from, int to, InSlots* states) {
  using V = Lanes;
  for (int i = from; i < to; i += kLanes) {
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

void find_pull(const InSlots* position_m, double root_of_three_mu, int from, int to, InSlots* pull) {
  using V = Lanes;
  for (int i = from; i < to; i += kLanes) {
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
  const Three<V> by_first = multiply_add(V(multiply_add(shear, a2, V(a1 / all<V>(r.across_rad_s)))), across, rest);
  return cross(along, multiply_add(V(load<V>(p.reciprocal_square + i) * sheared), across, mu)) + by_first;
}

template <class V>
inline Three<V> relative_momentum(const Reference& r, const InSlots* y, int i) {
  return all<V>(1.0 / r.magnitude) * get<V>(y, i);
}

template <class V>
inline Three<V> angle_in(const Reference& r, const Places& p, const InSlots* y, int i) {
  return angle_of(r, p, i, relative_momentum<V>(r, y, i), load<V>(y[3] + i), load<V>(y[4] + i), load<V>(y[5] + i));
}

void angle(const Reference& r, const Places& p, const InSlots* y, int slot, double* rotation_vector) {
  const Three<double> theta = angle_in<double>(r, p, y, slot);
  rotation_vector[0] = theta.x, rotation_vector[1] = theta.y, rotation_vector[2] = theta.z;
}

void add_gravity_gradients(const Reference& r, const Places& p, const InSlots* pulls, std::size_t masses,
                           const InSlots* y, int slots, InSlots* torque) {
  using V = Lanes;
  const V half = all<V>(0.5);
  for (int i = 0; i < slots; i += kLanes) {
    const Three<V> theta = angle_in<V>(r, p, y, i);
    const V c = square_root(magnitude(V(all<V>(1.0) - all<V>(0.25) * dot(theta, theta))));
    Three<V> sum{};
    for (std::size_t k = 0; k < masses; ++k) {
      // In the axes of the free motion: turned back by the deviation, and forth again.
      const Three<V> there = get<V>(pulls + 3 * k, i), turned = cross(theta, there);
      const Three<V> u = multiply_add(half, cross(theta, turned), multiply_add(V(-c), turned, there));
      sum = sum + cross(u, times(p.inertia, i, u));
    }
    const Three<V> turned = cross(theta, sum);
    put(get<V>(torque, i) + multiply_add(half, cross(theta, turned), multiply_add(c, turned, sum)), torque, i);
  }
}

void find_rates(const Reference& r, const Places& p, const Felt& felt, const InSlots* y, int slots, InSlots* rates) {
  using V = Lanes;
  const V one = all<V>(1.0), half = all<V>(0.5), unit = all<V>(r.magnitude), reciprocal = all<V>(1.0 / r.magnitude);
  const Three<V> along = all_of<V>(r.along);
  for (int i = 0; i < slots; i += kLanes) {
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
    const Three<V> torque = get<V>(felt.torque, i), relative = reciprocal * torque;
    const V since_base_s = load<V>(p.since_base_s + i);
    const Three<V> rest = multiply_add(V(-dot(along, relative) * since_base_s), omega, n - cross(along, relative));
    put(torque, rates, i);
    const Three<V> across = get<V>(p.across, i);
    const V first = all<V>(r.across_rad_s), a2 = dot(rest, cross(along, across)) / first;
    const V shear = load<V>(p.shear_swing + i) + load<V>(p.shear + i);
    store(rates[3] + i, multiply_add(V(first * since_base_s), a2, dot(rest, along)));
    store(rates[4] + i, V(first * multiply_add(dot(rest, across), load<V>(p.reciprocal_square + i), V(-(shear * a2)))));
    store(rates[5] + i, a2);
  }
}

/// As many components as leave registers free.
#if defined(__AVX512F__)
constexpr int kTogether = 6;
#else
constexpr int kTogether = 3;
#endif

/// Sixteen slots of several components: by times the values times the rows, each to be used by `take`.
template <int kComponents, class Take>
inline void products(const InSlots* values, int rows, const InSlots* matrix, int first, double by, const Take& take) {
  constexpr int kRegisters = kCoarseSlots / kLanes;
  Lanes sum[kComponents][kRegisters] = {};
  for (int j = 0; j < rows; ++j) {
    Lanes row[kRegisters];
    for (int i = 0; i < kRegisters; ++i) row[i] = load<Lanes>(matrix[j] + first + i * kLanes);
    for (int c = 0; c < kComponents; ++c) {
      const Lanes value = all<Lanes>(values[c][j]);
      for (int i = 0; i < kRegisters; ++i) sum[c][i] = multiply_add(value, row[i], sum[c][i]);
    }
  }
  for (int c = 0; c < kComponents; ++c) {
    for (int i = 0; i < kRegisters; ++i) take(c, first + i * kLanes, all<Lanes>(by) * sum[c][i]);
  }
}

void add_products(const InSlots* values, int components, int rows, const InSlots* matrix, int from_slot, int to_slot,
                  double by, InSlots* to) {
  const auto add = [&](int c, int i, Lanes sum) { store(to[c] + i, load<Lanes>(to[c] + i) + sum); };
  while (components > 0) {
    const int done = components >= 3 ? 3 : 1;
    for (int first = from_slot; first < to_slot; first += kCoarseSlots) {
      if (done == 3) {
        products<3>(values, rows, matrix, first, by, add);
      } else {
        products<1>(values, rows, matrix, first, by, add);
      }
    }
    components -= done, values += done, to += done;
  }
}

inline double largest_of(Lanes a) {
  double largest = a[0];
  for (int i = 1; i < kLanes; ++i) largest = largest < a[i] ? a[i] : largest;
  return largest;
}
inline Lanes larger(Lanes a, Lanes b) { return -theta::smaller(-a, -b); }

void integrate(const Grid& grid, const InSlots* rates, double half_s, const InSlots* start, InSlots* y,
               double* changes) {
  for (int done = 0; done < kCoefficients; done += kTogether) {
    Lanes change[kTogether] = {};
    for (int first = 0; first < grid.slots; first += kCoarseSlots) {
      products<kTogether>(rates + done, grid.rows, grid.integral, first, half_s, [&](int c, int i, Lanes sum) {
        const Lanes now = load<Lanes>(start[done + c] + i) + sum;
        change[c] = larger(change[c], magnitude(now - load<Lanes>(y[done + c] + i)));
        store(y[done + c] + i, now);
      });
    }
    for (int c = 0; c < kTogether; ++c) changes[done + c] = largest_of(change[c]);
  }
}

void find_spectrum(const Grid& grid, const InSlots* rates, Spectrum& spectrum) {
  for (int k = 0; k < kCoefficients; ++k) {
    Lanes sums[4] = {}, largest = {};
    for (int i = 0; i < grid.slots; i += kLanes) {
      const Lanes rate = load<Lanes>(rates[k] + i);
      for (int l = 0; l < 4; ++l) sums[l] = multiply_add(load<Lanes>(grid.coefficients[l] + i), rate, sums[l]);
      largest = larger(largest, magnitude(rate));
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
  return {name,       find_places, find_series,  find_pull,     add_gravity_gradients,
          find_rates, integrate,   add_products, find_spectrum, angle};
}

}  // namespace
}  // namespace POLHODE_TARGET
}  // namespace polhode::variation
