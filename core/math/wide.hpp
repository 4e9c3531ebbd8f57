#pragma once
// Eight numbers that are processed at once, in one register where the processor has it.
#include <cstdint>
#include <cstring>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace flexopt {

inline constexpr int wide = 8;
using Wide = double __attribute__((vector_size(8 * wide)));

/// Loads eight numbers. The compiler's own conversions take five instructions each.
inline Wide load_wide(const double* from) {
  Wide x;
  std::memcpy(&x, from, sizeof x);
  return x;
}
inline Wide load_wide(const float* from) {
#ifdef __AVX512F__
  return (Wide)_mm512_cvtps_pd(_mm256_loadu_ps(from));
#else
  float __attribute__((vector_size(4 * wide))) x;
  std::memcpy(&x, from, sizeof x);
  return __builtin_convertvector(x, Wide);
#endif
}
inline Wide load_wide(const std::int16_t* from) {
#ifdef __AVX512F__
  __m128i x;
  std::memcpy(&x, from, sizeof x);
  return (Wide)_mm512_cvtepi32_pd(_mm256_cvtepi16_epi32(x));
#else
  using Whole = std::int32_t __attribute__((vector_size(4 * wide)));
  std::int16_t __attribute__((vector_size(2 * wide))) x;
  std::memcpy(&x, from, sizeof x);
  return __builtin_convertvector(__builtin_convertvector(x, Whole), Wide);
#endif
}
inline Wide load_wide(const std::int8_t* from) {
#ifdef __AVX512F__
  return (Wide)_mm512_cvtepi32_pd(
      _mm256_cvtepi8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from))));
#else
  using Whole = std::int32_t __attribute__((vector_size(4 * wide)));
  std::int8_t __attribute__((vector_size(wide))) x;
  std::memcpy(&x, from, sizeof x);
  return __builtin_convertvector(__builtin_convertvector(x, Whole), Wide);
#endif
}
inline void store_wide(const Wide& x, double* to) { std::memcpy(to, &x, sizeof x); }

}  // namespace flexopt
