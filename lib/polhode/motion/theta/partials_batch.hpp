#pragma once

// Many instants with their matrices.

#include "polhode/motion/theta/batch.hpp"
#include "polhode/motion/theta/partials_kernel.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

/// Writes the first `here` lanes of 54 components as rows, four components at a time; the last four overlap others.
inline void put_matrices(const Lanes (&c)[54], double* to, std::size_t here) {
  for (int group = 0; group < 14; ++group) {
    const int first = group == 13 ? 50 : 4 * group;
    const Lanes four[4] = {c[first], c[first + 1], c[first + 2], c[first + 3]};
    Lanes rows[4];
    rows_of_4(four, rows);
    for (std::size_t i = 0; i < here; ++i) {
      std::memcpy(to + 54 * i + first, reinterpret_cast<const char*>(rows) + 32 * i, 32);
    }
  }
}

template <class Sink, class At, class PartialsAt>
inline void partials_batch_into(const At& at, const PartialsAt& partials_at, const PartialsBatchArguments& arguments) {
  const BatchArguments& a = arguments.states;
  Sink sink(arguments.matrices);
  alignas(sizeof(Lanes)) double whole[54 * kLanes];
  for (std::size_t i = 0; i < a.count; i += kLanes) {
    const std::size_t here = a.count - i < kLanes ? a.count - i : kLanes;
    Pair<Lanes> t{};
    std::memcpy(&t.high, a.t_high + i, here * sizeof(double));
    if (a.t_low != nullptr) {
      std::memcpy(&t.low, a.t_low + i, here * sizeof(double));
      t = pair_sum(t.high, t.low);  // the parts may overlap
    }
    Lanes q[4], m[3], out[54];
    state_and_matrix(at, partials_at, t.high, t.low, q, m, out);
    for (std::size_t j = 0; j < here; ++j) {
      const auto row = static_cast<std::ptrdiff_t>(i + j);
      for (int k = 0; k < 4; ++k) a.q[k][row * a.q_stride] = q[k][j];
      if (a.m[0] == nullptr) continue;
      for (int k = 0; k < 3; ++k) a.m[k][row * a.m_stride] = m[k][j];
    }
    if (here == kLanes) [[likely]] {
      put_matrices(out, whole, kLanes);
      for (std::size_t k = 0; k < 54; ++k) sink.push(load<Lanes>(whole + k * kLanes));
    } else {
      sink.finish();
      put_matrices(out, arguments.matrices + 54 * i, here);
      return;
    }
  }
  sink.finish();
}

template <class At, class PartialsAt>
inline void partials_batch_with(const At& at, const PartialsAt& partials_at, const PartialsBatchArguments& arguments) {
  if (is_larger_than_caches(arguments.states.count * 54 * sizeof(double))) {
    return partials_batch_into<StreamingSink>(at, partials_at, arguments);
  }
  partials_batch_into<CachedSink>(at, partials_at, arguments);
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
