#pragma once

// A few operations that one text of the evaluation needs, for `double` (one instant) and for `Lanes` (as many as the
// target's registers hold; the vector extension of GCC and Clang gives + - * / and comparisons).

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "polhode/base/target.hpp"

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace polhode::theta {
inline namespace POLHODE_TARGET {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX2__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

using Lanes __attribute__((vector_size(8 * kLanes))) = double;
using LaneBits __attribute__((vector_size(8 * kLanes))) = std::int64_t;

template <class V>
struct BitsOf;
template <>
struct BitsOf<double> {
  using type = std::int64_t;
};
template <>
struct BitsOf<Lanes> {
  using type = LaneBits;
};

template <class V>
inline typename BitsOf<V>::type bits(V a) {
  typename BitsOf<V>::type b;
  std::memcpy(&b, &a, sizeof b);
  return b;
}
template <class V>
inline V value(typename BitsOf<V>::type b) {
  V a;
  std::memcpy(&a, &b, sizeof a);
  return a;
}

template <class V>
inline V all(double a);
template <>
inline double all<double>(double a) {
  return a;
}
template <>
inline Lanes all<Lanes>(double a) {
  return a - Lanes{};  // a broadcast: a - 0 is a for every a
}

// sqrt, and fma where the machine has it. Elsewhere the text below asks for two_product and multiply_add separately.
inline double square_root(double a) { return __builtin_sqrt(a); }
inline Lanes square_root(Lanes a) {
#if defined(__AVX512F__)
  return _mm512_sqrt_pd(a);
#elif defined(__AVX2__)
  return _mm256_sqrt_pd(a);
#elif defined(__SSE2__)
  return _mm_sqrt_pd(a);
#else
  for (int i = 0; i < kLanes; ++i) a[i] = __builtin_sqrt(a[i]);
  return a;
#endif
}

#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
inline double multiply_add(double a, double b, double c) { return __builtin_fma(a, b, c); }
inline Lanes multiply_add(Lanes a, Lanes b, Lanes c) {
#if defined(__AVX512F__)
  return _mm512_fmadd_pd(a, b, c);
#elif defined(__AVX2__)
  return _mm256_fmadd_pd(a, b, c);
#else
  for (int i = 0; i < kLanes; ++i) c[i] = __builtin_fma(a[i], b[i], c[i]);
  return c;
#endif
}
/// error = a b - product, exactly
template <class V>
inline V product_error(V a, V b, V product) {
  return multiply_add(a, b, -product);
}
/// a b - c with one rounding
template <class V>
inline V product_minus(V a, V b, V c) {
  return multiply_add(a, b, -c);
}
#else
template <class V>
inline V multiply_add(V a, V b, V c) {
  return a * b + c;
}
/// error = a b - product, exactly (Dekker and Veltkamp; |a|, |b| < 2^996)
template <class V>
inline V product_error(V a, V b, V product) {
  const V splitter = all<V>(0x1p27 + 1.0);
  const V ta = a * splitter, tb = b * splitter;
  const V ah = ta - (ta - a), bh = tb - (tb - b);
  const V al = a - ah, bl = b - bh;
  return ((ah * bh - product) + ah * bl + al * bh) + al * bl;
}
/// a b - c with one rounding where c is near a b
template <class V>
inline V product_minus(V a, V b, V c) {
  const V product = a * b;
  return (product - c) + product_error(a, b, product);
}
#endif

/// Nearest integer, ties to even, for any size.
inline double nearest_integer(double a) { return __builtin_rint(a); }
inline Lanes nearest_integer(Lanes a) {
#if defined(__AVX512F__)
  return _mm512_roundscale_pd(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#elif defined(__AVX2__)
  return _mm256_round_pd(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#else
  const Lanes whole = all<Lanes>(0x1p52);  // from there on there are only whole numbers
  const Lanes size = value<Lanes>(bits(a) & INT64_MAX);
  const Lanes rounded = (size + whole) - whole;
  const LaneBits small = size < whole;
  return value<Lanes>((bits(rounded) & small) | (bits(a) & ~small) | (bits(a) & INT64_MIN));
#endif
}

/// a where the lowest bit of `chooser` is 0, else b.
template <class V>
inline V choose(typename BitsOf<V>::type chooser, V a, V b) {
  const typename BitsOf<V>::type mask = -(chooser & 1);
  return value<V>((bits(a) & ~mask) | (bits(b) & mask));
}
#if defined(__AVX512DQ__)
template <>
inline Lanes choose<Lanes>(LaneBits chooser, Lanes a, Lanes b) {
  return _mm512_mask_blend_pd(_mm512_movepi64_mask(reinterpret_cast<__m512i>(chooser << 63)), a, b);
}
#endif

/// a with its sign changed where bit 63 of `sign` is set.
template <class V>
inline V flip(V a, typename BitsOf<V>::type sign) {
  constexpr std::int64_t top = INT64_MIN;
  return value<V>(bits(a) ^ (sign & top));
}

template <class V>
inline V magnitude(V a) {
  return value<V>(bits(a) & INT64_MAX);
}

/// True if a lane of a is above the limit or NaN.
inline bool any_above(double a, double limit) { return !(a <= limit); }
inline bool any_above(Lanes a, double limit) {
#if defined(__AVX512F__)
  return _mm512_cmp_pd_mask(a, all<Lanes>(limit), _CMP_NLE_UQ) != 0;
#elif defined(__AVX2__)
  return _mm256_movemask_pd(_mm256_cmp_pd(a, all<Lanes>(limit), _CMP_NLE_UQ)) != 0;
#else
  bool above = false;
  for (int i = 0; i < kLanes; ++i) above = above || !(a[i] <= limit);
  return above;
#endif
}

/// All bits set where a is above the limit or NaN.
inline std::int64_t above(double a, double limit) { return a <= limit ? 0 : -1; }
inline LaneBits above(Lanes a, double limit) { return ~(a <= limit); }

inline double smaller(double a, double b) { return b < a ? b : a; }
inline Lanes smaller(Lanes a, Lanes b) {
#if defined(__AVX512F__)
  return _mm512_min_pd(b, a);
#elif defined(__AVX2__)
  return _mm256_min_pd(b, a);
#elif defined(__SSE2__)
  return _mm_min_pd(b, a);
#else
  for (int i = 0; i < kLanes; ++i) a[i] = smaller(a[i], b[i]);
  return a;
#endif
}
template <class V>
inline V load(const double* p) {
  V a;
  std::memcpy(&a, p, sizeof a);
  return a;
}
template <class V>
inline void store(double* p, V a) {
  std::memcpy(p, &a, sizeof a);
}

/// The lanes of four components as rows: row i is (c[0][i], ..., c[3][i]), one after the other.
inline void rows_of_4(const Lanes (&c)[4], Lanes (&rows)[4]) {
#if defined(__AVX512F__)
  // Pairs of components of rows 0 to 3 and of rows 4 to 7, then pairs of pairs.
  const __m512i pairs_0 = _mm512_setr_epi64(0, 8, 1, 9, 2, 10, 3, 11),
                pairs_4 = _mm512_setr_epi64(4, 12, 5, 13, 6, 14, 7, 15);
  const __m512i rows_0 = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11),
                rows_2 = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
  const __m512d ab_0 = _mm512_permutex2var_pd(c[0], pairs_0, c[1]), ab_4 = _mm512_permutex2var_pd(c[0], pairs_4, c[1]);
  const __m512d cd_0 = _mm512_permutex2var_pd(c[2], pairs_0, c[3]), cd_4 = _mm512_permutex2var_pd(c[2], pairs_4, c[3]);
  rows[0] = _mm512_permutex2var_pd(ab_0, rows_0, cd_0);
  rows[1] = _mm512_permutex2var_pd(ab_0, rows_2, cd_0);
  rows[2] = _mm512_permutex2var_pd(ab_4, rows_0, cd_4);
  rows[3] = _mm512_permutex2var_pd(ab_4, rows_2, cd_4);
#elif defined(__AVX2__)
  const __m256d ab_low = _mm256_unpacklo_pd(c[0], c[1]), ab_high = _mm256_unpackhi_pd(c[0], c[1]);
  const __m256d cd_low = _mm256_unpacklo_pd(c[2], c[3]), cd_high = _mm256_unpackhi_pd(c[2], c[3]);
  rows[0] = _mm256_permute2f128_pd(ab_low, cd_low, 0x20);
  rows[1] = _mm256_permute2f128_pd(ab_high, cd_high, 0x20);
  rows[2] = _mm256_permute2f128_pd(ab_low, cd_low, 0x31);
  rows[3] = _mm256_permute2f128_pd(ab_high, cd_high, 0x31);
#else
  for (int word = 0; word < 4 * kLanes; ++word) rows[word / kLanes][word % kLanes] = c[word % 4][word / 4];
#endif
}

/// The lanes of three components as rows of three, one after the other.
inline void rows_of_3(const Lanes (&c)[3], Lanes (&rows)[3]) {
#if defined(__AVX512F__)
  // Words 0 to 7, 8 to 15, 16 to 23: first components 0 and 1 are merged, then component 2.
  const __m512i ab_0 = _mm512_setr_epi64(0, 8, 0, 1, 9, 0, 2, 10), c_0 = _mm512_setr_epi64(0, 1, 8, 3, 4, 9, 6, 7);
  const __m512i ab_1 = _mm512_setr_epi64(0, 3, 11, 0, 4, 12, 0, 5), c_1 = _mm512_setr_epi64(10, 1, 2, 11, 4, 5, 12, 7);
  const __m512i ab_2 = _mm512_setr_epi64(13, 0, 6, 14, 0, 7, 15, 0), c_2 = _mm512_setr_epi64(0, 13, 2, 3, 14, 5, 6, 15);
  rows[0] = _mm512_permutex2var_pd(_mm512_permutex2var_pd(c[0], ab_0, c[1]), c_0, c[2]);
  rows[1] = _mm512_permutex2var_pd(_mm512_permutex2var_pd(c[0], ab_1, c[1]), c_1, c[2]);
  rows[2] = _mm512_permutex2var_pd(_mm512_permutex2var_pd(c[0], ab_2, c[1]), c_2, c[2]);
#elif defined(__AVX2__)
  // (a0 b0 c0 a1) (b1 c1 a2 b2) (c2 a3 b3 c3)
  const __m256d ab_low = _mm256_unpacklo_pd(c[0], c[1]);   // a0 b0 a2 b2
  const __m256d ca = _mm256_shuffle_pd(c[2], c[0], 0xa);   // c0 a1 c2 a3
  const __m256d bc_high = _mm256_unpackhi_pd(c[1], c[2]);  // b1 c1 b3 c3
  rows[0] = _mm256_permute2f128_pd(ab_low, ca, 0x20);
  rows[1] = _mm256_blend_pd(bc_high, ab_low, 0xc);
  rows[2] = _mm256_permute2f128_pd(ca, bc_high, 0x31);
#else
  for (int word = 0; word < 3 * kLanes; ++word) rows[word / kLanes][word % kLanes] = c[word % 3][word / 3];
#endif
}

/// Where lanes go, one after the other.
class CachedSink {
 public:
  explicit CachedSink(double* to) : to_(to) {}
  void push(Lanes a) {
    store(to_, a);
    to_ += kLanes;
  }
  void finish() {}

 private:
  double* to_;
};

#if defined(__AVX512F__)
/// The same, written past the caches in whole lines: a result larger than the caches need not be read first. A place
/// that does not start at a line is served by moving each lane over.
class StreamingSink {
 public:
  explicit StreamingSink(double* to)
      : head_(-(reinterpret_cast<std::intptr_t>(to) >> 3) & 7), line_(to + head_), first_(to) {
    index_ = _mm512_add_epi64(_mm512_set1_epi64(head_), _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7));
  }
  void push(Lanes a) {
    if (first_ != nullptr) [[unlikely]] {
      _mm512_mask_storeu_pd(first_, static_cast<__mmask8>((1u << head_) - 1u), a);
      first_ = nullptr;
    } else {
      _mm512_stream_pd(line_, _mm512_permutex2var_pd(previous_, index_, a));
      line_ += kLanes;
    }
    previous_ = a;
  }
  void finish() {
    if (first_ != nullptr) return;
    // words head .. 7 of the last lanes
    const __m512d rest = _mm512_permutexvar_pd(index_, previous_);
    _mm512_mask_storeu_pd(line_, static_cast<__mmask8>(0xffu >> head_), rest);
    _mm_sfence();
  }

 private:
  std::int64_t head_;  // words before the first whole line
  double* line_;
  double* first_;  // until the first push
  __m512i index_;
  Lanes previous_ = {};
};
#else
using StreamingSink = CachedSink;
#endif

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
