#pragma once

// One instant. The same operations as in kernel.hpp, and so the same bits, but side by side: the sines and cosines of
// both phases in one register, and so the four series and the four components of the attitude.

#include "polhode/motion/theta/kernel.hpp"

namespace polhode::theta {
inline namespace POLHODE_TARGET {

/// One operation after the other. The attitude goes out as Eigen stores it, scalar last.
template <class At>
inline void evaluate_at(const At& at, double t_high, double t_low, double q_xyzw[4], double m[3]) {
  double qs[4], ms[3];
  at.state(at.phases(t_high, t_low), qs, ms);
  for (int k = 0; k < 4; ++k) q_xyzw[k] = qs[(k + 1) % 4];
  for (int k = 0; k < 3; ++k) m[k] = ms[k];
}

#if defined(__AVX2__) && defined(__FMA__)

/// (sin, sin, cos, cos) of two angles.
[[gnu::always_inline]] inline __m256d sines_cosines(__m128d y, __m128i quarter) {
  const __m128d u = _mm_mul_pd(y, y);
  const __m256d uu = _mm256_set_m128d(u, u), yu = _mm256_set_m128d(u, y);
  const auto both = [](double of_sine, double of_cosine) {
    return _mm256_setr_pd(of_sine, of_sine, of_cosine, of_cosine);
  };
  const auto pair = [&](int k) {
    return _mm256_fmadd_pd(uu, both(kSineTail[k + 1], kCosineTail[k + 1]), both(kSineTail[k], kCosineTail[k]));
  };
  const __m256d u2 = _mm256_mul_pd(uu, uu);
  __m256d tail = _mm256_fmadd_pd(u2, _mm256_fmadd_pd(u2, pair(4), pair(2)), pair(0));
  tail = _mm256_fmadd_pd(uu, tail, both(kHalfPiLow, -kEighthPi2));
  // y pi/2 + (y tail), u tail + 1
  const __m256d factor = _mm256_blend_pd(_mm256_set1_pd(kHalfPiHigh), tail, 0xc);
  const __m256d term = _mm256_blend_pd(_mm256_mul_pd(yu, tail), _mm256_set1_pd(1.0), 0xc);
  const __m256d straight = _mm256_fmadd_pd(yu, factor, term);
  const __m256d exchanged = _mm256_permute2f128_pd(straight, straight, 1);
  const __m256i quarters = _mm256_set_m128i(quarter, quarter);
  const __m256d chosen = _mm256_blendv_pd(straight, exchanged, _mm256_castsi256_pd(_mm256_slli_epi64(quarters, 63)));
  const __m256i sign = _mm256_slli_epi64(_mm256_add_epi64(quarters, _mm256_setr_epi64x(0, 0, 1, 1)), 62);
  return _mm256_xor_pd(chosen, _mm256_and_pd(_mm256_castsi256_pd(sign), _mm256_set1_pd(-0.0)));
}

template <int Degree>
[[gnu::always_inline]] inline __m256d polynomials_at(const double (&a)[kMaxDegree + 1][4], double x) {
  const __m256d xs = _mm256_set1_pd(x);
  __m256d sum = _mm256_loadu_pd(a[Degree]);
  for (int n = Degree - 1; n >= 0; --n) sum = _mm256_fmadd_pd(sum, xs, _mm256_loadu_pd(a[n]));
  return sum;
}

/// attitude_and_momentum of real = (Re alpha, Re beta), imaginary likewise, and twice the sine and the cosine.
[[gnu::always_inline]] inline void attitude_and_momentum(const OutputFrame& f, __m128d real, __m128d imaginary,
                                                         __m128d sine, __m128d cosine, double q_xyzw[4], double m[3]) {
  const __m128d squares = _mm_fmadd_pd(real, real, _mm_mul_pd(imaginary, imaginary));
  const double alpha2 = squares[0], beta2 = squares[1];
  const double reciprocal = 1.0 / (alpha2 + beta2);
  const double scale = square_root(reciprocal);
  const double twice = 2.0 * reciprocal;
  const double m1 = multiply_add(imaginary[0], real[1], -real[0] * imaginary[1]) * twice;
  const double m2 = multiply_add(real[0], real[1], imaginary[0] * imaginary[1]) * twice;
  const double m3 = (alpha2 - beta2) * reciprocal;
  m[0] = (f.exchange_1_3 ? m3 : m1) * f.momentum_scale[f.exchange_1_3 ? 2 : 0];
  m[1] = m2 * f.momentum_scale[1];
  m[2] = (f.exchange_1_3 ? m1 : m3) * f.momentum_scale[f.exchange_1_3 ? 0 : 2];
  const __m256d e01 = _mm256_castpd128_pd256(_mm_fmsub_pd(real, cosine, _mm_mul_pd(imaginary, sine)));
  const __m256d e32 = _mm256_castpd128_pd256(_mm_fmadd_pd(real, sine, _mm_mul_pd(imaginary, cosine)));
  __m256d q = _mm256_mul_pd(_mm256_loadu_pd(f.frame[0]), _mm256_permute4x64_pd(e01, 0x00));
  q = _mm256_fmadd_pd(_mm256_loadu_pd(f.frame[1]), _mm256_permute4x64_pd(e01, 0x55), q);
  q = _mm256_fmadd_pd(_mm256_loadu_pd(f.frame[2]), _mm256_permute4x64_pd(e32, 0x55), q);
  q = _mm256_fmadd_pd(_mm256_loadu_pd(f.frame[3]), _mm256_permute4x64_pd(e32, 0x00), q);
  q = _mm256_mul_pd(q, _mm256_set1_pd(scale));
  _mm256_storeu_pd(q_xyzw, _mm256_permute4x64_pd(q, 0x39));
}

template <int Degree>
inline void evaluate_at(const FourierAt<Degree>& at, double t_high, double t_low, double q_xyzw[4], double m[3]) {
  // Both angles as angle() has them.
  const FourierChart& s = at.s;
  const __m128d v = _mm_loadu_pd(&s.v_quarters_per_s.high), rho = _mm_loadu_pd(&s.rho_quarters_per_s.high);
  const __m128d rate = _mm_unpacklo_pd(v, rho), rate_low = _mm_unpackhi_pd(v, rho);
  const __m128d offset = _mm_set_sd(s.v_quarters_at_0);
  const __m128d magic = _mm_add_pd(_mm_set1_pd(kMagic), _mm_set_sd(s.v_whole_quarters_at_0));
  const __m128d t = _mm_set1_pd(t_high);
  const __m128d about = _mm_fmadd_pd(t, rate, offset);
  const __m128d size = _mm_andnot_pd(_mm_set1_pd(-0.0), about);
  if (_mm_movemask_pd(_mm_cmpnle_pd(size, _mm_set1_pd(kSafeQuarters))) != 0) [[unlikely]] {
    return evaluate_at<FourierAt<Degree>>(at, t_high, t_low, q_xyzw, m);
  }
  const __m128d rest = _mm_fmadd_pd(_mm_set1_pd(t_low), rate, _mm_mul_pd(t, rate_low));
  const __m128d shifted = _mm_add_pd(about, magic);
  const __m128d fraction = _mm_fmsub_pd(t, rate, _mm_sub_pd(shifted, magic));
  const __m256d phases = sines_cosines(_mm_add_pd(fraction, _mm_add_pd(offset, rest)), _mm_castpd_si128(shifted));

  const __m128d sine = _mm256_castpd256_pd128(phases), cosine = _mm256_extractf128_pd(phases, 1);
  const double two_sin = sine[0] + sine[0];
  const __m128d one = _mm_set1_pd(1.0);
  const __m256d c = polynomials_at<Degree>(s.polynomial, multiply_add(-two_sin, sine[0], 1.0));
  const __m128d sin_2v = _mm_set_sd(two_sin * cosine[0]);
  const __m128d real = _mm_mul_pd(_mm256_castpd256_pd128(c), _mm_unpacklo_pd(one, sine));
  const __m128d imaginary = _mm_mul_pd(_mm256_extractf128_pd(c, 1), _mm_unpacklo_pd(sin_2v, cosine));
  attitude_and_momentum(s.frame, real, imaginary, _mm_unpackhi_pd(sine, sine), _mm_unpackhi_pd(cosine, cosine), q_xyzw,
                        m);
}

template <int Degree>
inline void evaluate_at(const HyperbolicAt<Degree>& at, double t_high, double t_low, double q_xyzw[4], double m[3]) {
  const HyperbolicChart& s = at.s;
  const auto [x, n] = at.position(t_high, t_low);
  const Angle<double> phase = angle(s.rho_quarters_per_s, t_high, t_low, x * s.x_to_quarters);
  const __m256d phases = sines_cosines(_mm_set1_pd(phase.y), _mm_set1_epi64x(phase.quarter));
  double e, y;
  exponentials(magnitude(x), s.root_of_nome, e, y);
  const __m256d c =
      _mm256_fmadd_pd(_mm256_set1_pd(e), polynomials_at<Degree>(s.falling, e), polynomials_at<Degree>(s.growing, y));
  const __m128i side = _mm_castpd_si128(_mm_set_sd(x));
  const __m128i parity = _mm_slli_epi64(_mm_castpd_si128(_mm_set_sd(n + kMagic)), 63);
  const __m128d top = _mm_set1_pd(-0.0);
  const __m128d real_sign = _mm_castsi128_pd(_mm_unpacklo_epi64(_mm_setzero_si128(), _mm_xor_si128(side, parity)));
  const __m128d imaginary_sign = _mm_castsi128_pd(_mm_unpacklo_epi64(side, parity));
  const __m128d real = _mm_xor_pd(_mm256_castpd256_pd128(c), _mm_and_pd(real_sign, top));
  const __m128d imaginary = _mm_xor_pd(_mm256_extractf128_pd(c, 1), _mm_and_pd(imaginary_sign, top));
  attitude_and_momentum(s.frame, real, imaginary, _mm256_castpd256_pd128(phases), _mm256_extractf128_pd(phases, 1),
                        q_xyzw, m);
}

#endif

}  // namespace POLHODE_TARGET
}  // namespace polhode::theta
