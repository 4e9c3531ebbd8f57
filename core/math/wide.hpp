#pragma once
// Numbers that are processed at once, in one register: eight where the processor has such, else
// four.
#include <cstdint>
#include <cstring>
#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace flexopt {

#ifdef __AVX512F__
inline constexpr int wide = 8;
#else
inline constexpr int wide = 4;
#endif
using Wide = double __attribute__((vector_size(8 * wide)));

namespace detail {

// The compiler's own conversions of short numbers take five instructions each.
template <class Number>
inline Wide loaded(const Number* from) {
  using Whole = std::int32_t __attribute__((vector_size(4 * wide)));
  Number __attribute__((vector_size(sizeof(Number) * wide))) x;
  std::memcpy(&x, from, sizeof x);
  if constexpr (sizeof(Number) < sizeof(std::int32_t))
    return __builtin_convertvector(__builtin_convertvector(x, Whole), Wide);
  else
    return __builtin_convertvector(x, Wide);
}

}  // namespace detail

/// Loads so many numbers.
inline Wide load_wide(const double* from) {
  Wide x;
  std::memcpy(&x, from, sizeof x);
  return x;
}
inline Wide load_wide(const float* from) {
#ifdef __AVX512F__
  return (Wide)_mm512_cvtps_pd(_mm256_loadu_ps(from));
#else
  return detail::loaded(from);
#endif
}
inline Wide load_wide(const std::int32_t* from) { return detail::loaded(from); }
inline Wide load_wide(const std::int16_t* from) {
#ifdef __AVX512F__
  __m128i x;
  std::memcpy(&x, from, sizeof x);
  return (Wide)_mm512_cvtepi32_pd(_mm256_cvtepi16_epi32(x));
#elif defined(__AVX2__)
  return (Wide)_mm256_cvtepi32_pd(
      _mm_cvtepi16_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from))));
#else
  return detail::loaded(from);
#endif
}
inline Wide load_wide(const std::int8_t* from) {
#ifdef __AVX512F__
  return (Wide)_mm512_cvtepi32_pd(
      _mm256_cvtepi8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from))));
#elif defined(__AVX2__)
  int x = 0;
  std::memcpy(&x, from, sizeof x);
  return (Wide)_mm256_cvtepi32_pd(_mm_cvtepi8_epi32(_mm_cvtsi32_si128(x)));
#else
  return detail::loaded(from);
#endif
}
inline void store_wide(const Wide& x, double* to) { std::memcpy(to, &x, sizeof x); }

/// Eight numbers in as many registers as they take. A vector type that is wider than the registers
/// passes through memory at every operation.
struct Eight {
  static constexpr int parts = 8 / wide;
  Wide part[parts];

  static Eight load(const double* from) {
    Eight x;
    for (int p = 0; p < parts; ++p) x.part[p] = load_wide(from + p * wide);
    return x;
  }
  static Eight all(double value) {
    Eight x;
    for (Wide& p : x.part) p = Wide{} + value;
    return x;
  }
  double operator[](int i) const { return part[i / wide][i % wide]; }
  void set(int i, double value) { part[i / wide][i % wide] = value; }

  Eight& operator+=(const Eight& b) {
    for (int p = 0; p < parts; ++p) part[p] += b.part[p];
    return *this;
  }
  Eight& operator-=(const Eight& b) {
    for (int p = 0; p < parts; ++p) part[p] -= b.part[p];
    return *this;
  }
  Eight& operator*=(const Eight& b) {
    for (int p = 0; p < parts; ++p) part[p] *= b.part[p];
    return *this;
  }
  Eight& operator+=(double b) {
    for (Wide& p : part) p += b;
    return *this;
  }
  Eight& operator-=(double b) {
    for (Wide& p : part) p -= b;
    return *this;
  }
  Eight& operator*=(double b) {
    for (Wide& p : part) p *= b;
    return *this;
  }
  friend Eight operator+(Eight a, const Eight& b) { return a += b; }
  friend Eight operator-(Eight a, const Eight& b) { return a -= b; }
  friend Eight operator*(Eight a, const Eight& b) { return a *= b; }
  friend Eight operator*(Eight a, double b) { return a *= b; }
  friend Eight operator*(double a, Eight b) { return b *= a; }
};

}  // namespace flexopt
