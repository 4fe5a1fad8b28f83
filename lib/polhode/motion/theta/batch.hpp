#pragma once

// Many instants: lanes in, rows or separate arrays out.

#include "polhode/motion/theta/kernel.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

/// The phases at the lanes from instant i on, of which `here` exist; the others repeat the time 0.
template <class At>
[[gnu::always_inline]] inline auto phases(const At& at, const BatchArguments& a, std::size_t i,
                                          std::size_t here = kLanes) {
  Pair<Lanes> t{};
  if (here == kLanes) [[likely]] {
    t.high = load<Lanes>(a.t_high + i);
    if (a.t_low != nullptr) t.low = load<Lanes>(a.t_low + i);
  } else {
    std::memcpy(&t.high, a.t_high + i, here * sizeof(double));
    if (a.t_low != nullptr) std::memcpy(&t.low, a.t_low + i, here * sizeof(double));
  }
  if (a.t_low != nullptr) t = pair_sum(t.high, t.low);  // the parts may overlap
  return at.phases(t.high, t.low);
}

/// Calls `use` with the states at all whole lanes in turn, and returns how many instants these are. The phases of a
/// block are computed before its states: two short loops of which the processor overlaps several rounds, where of one
/// long loop it holds little more than one.
template <class At, class Use>
[[gnu::always_inline]] inline std::size_t whole_lanes(const At& at, const BatchArguments& a, const Use& use) {
  constexpr std::size_t block = 8;
  const std::size_t whole = a.count / kLanes;
  typename At::template Phases<Lanes> p[block];
  for (std::size_t begin = 0; begin < whole; begin += block) {
    const std::size_t size = whole - begin < block ? whole - begin : block;
    for (std::size_t j = 0; j < size; ++j) p[j] = phases(at, a, (begin + j) * kLanes);
    for (std::size_t j = 0; j < size; ++j) {
      Lanes q[4], m[3];
      at.state(p[j], q, m);
      use((begin + j) * kLanes, q, m);
    }
  }
  return whole * kLanes;
}

template <class Sink, bool with_m, class At>
inline void batch_of_structures(const At& at, const BatchArguments& a) {
  Sink q_sink(a.q[0]), m_sink(a.m[0]);
  Lanes q_rows[4], m_rows[3];
  const std::size_t i = whole_lanes(at, a, [&](std::size_t, const Lanes(&q)[4], const Lanes(&m)[3]) {
    rows_of_4(q, q_rows);
    for (const Lanes& row : q_rows) q_sink.push(row);
    if constexpr (with_m) {
      rows_of_3(m, m_rows);
      for (const Lanes& row : m_rows) m_sink.push(row);
    }
  });
  q_sink.finish();
  if constexpr (with_m) m_sink.finish();
  const std::size_t here = a.count - i;
  if (here == 0) return;
  Lanes q[4], m[3];
  at.state(phases(at, a, i, here), q, m);
  rows_of_4(q, q_rows);
  std::memcpy(a.q[0] + 4 * i, q_rows, 4 * here * sizeof(double));
  if constexpr (with_m) {
    rows_of_3(m, m_rows);
    std::memcpy(a.m[0] + 3 * i, m_rows, 3 * here * sizeof(double));
  }
}

template <class Sink, bool with_m, class At>
inline void batch_of_arrays(const At& at, const BatchArguments& a) {
  Sink q_sinks[4] = {Sink(a.q[0]), Sink(a.q[1]), Sink(a.q[2]), Sink(a.q[3])};
  Sink m_sinks[3] = {Sink(a.m[0]), Sink(a.m[1]), Sink(a.m[2])};
  const std::size_t i = whole_lanes(at, a, [&](std::size_t, const Lanes(&q)[4], const Lanes(&m)[3]) {
    for (int k = 0; k < 4; ++k) q_sinks[k].push(q[k]);
    if constexpr (with_m) {
      for (int k = 0; k < 3; ++k) m_sinks[k].push(m[k]);
    }
  });
  for (Sink& sink : q_sinks) sink.finish();
  if constexpr (with_m) {
    for (Sink& sink : m_sinks) sink.finish();
  }
  const std::size_t here = a.count - i;
  if (here == 0) return;
  Lanes q[4], m[3];
  at.state(phases(at, a, i, here), q, m);
  for (int k = 0; k < 4; ++k) std::memcpy(a.q[k] + i, &q[k], here * sizeof(double));
  if constexpr (with_m) {
    for (int k = 0; k < 3; ++k) std::memcpy(a.m[k] + i, &m[k], here * sizeof(double));
  }
}

/// Any strides.
template <bool with_m, class At>
inline void batch_scattered(const At& at, const BatchArguments& a) {
  for (std::size_t i = 0; i < a.count; i += kLanes) {
    const std::size_t here = a.count - i < kLanes ? a.count - i : kLanes;
    Lanes q[4], m[3];
    at.state(phases(at, a, i, here), q, m);
    for (std::size_t j = 0; j < here; ++j) {
      const auto row = static_cast<std::ptrdiff_t>(i + j);
      for (int k = 0; k < 4; ++k) a.q[k][row * a.q_stride] = q[k][j];
      if constexpr (with_m) {
        for (int k = 0; k < 3; ++k) a.m[k][row * a.m_stride] = m[k][j];
      }
    }
  }
}

inline bool are_structures(double* const* p, int components, std::ptrdiff_t stride) {
  if (stride != components) return false;
  for (int k = 1; k < components; ++k) {
    if (p[k] != p[0] + k) return false;
  }
  return true;
}

/// Whether so many bytes of output are better written past the caches.
inline bool is_larger_than_caches(std::size_t bytes) { return bytes > std::size_t{4} << 20U; }

template <bool with_m, class At>
inline void batch_with(const At& at, const BatchArguments& a) {
  const bool streamed = is_larger_than_caches(a.count * (with_m ? 7 : 4) * sizeof(double));
  if (are_structures(a.q, 4, a.q_stride) && (!with_m || are_structures(a.m, 3, a.m_stride))) {
    return streamed ? batch_of_structures<StreamingSink, with_m>(at, a)
                    : batch_of_structures<CachedSink, with_m>(at, a);
  }
  if (a.q_stride == 1 && (!with_m || a.m_stride == 1)) {
    return streamed ? batch_of_arrays<StreamingSink, with_m>(at, a) : batch_of_arrays<CachedSink, with_m>(at, a);
  }
  batch_scattered<with_m>(at, a);
}

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
