// A law is written once for a type R that is float, double or a bundle of lanes (64 bytes: 16
// floats or 8 doubles). Comparisons of lanes give masks; `select` replaces the branch.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#if defined(__AVX512F__) || defined(__AVX__)
#include <immintrin.h>
#endif

#include "core/lane_pair.hpp"

namespace vulnus {

#ifdef __AVX512F__
typedef float Float16 __attribute__((vector_size(64)));
typedef std::int32_t Int16 __attribute__((vector_size(64)));
#else
using Float16 = LanePair<FloatHalf>;
using Int16 = LanePair<IntHalf>;
#endif
typedef double Double8 __attribute__((vector_size(64)));
typedef std::int64_t Int8 __attribute__((vector_size(64)));
typedef double Double16 __attribute__((vector_size(128)));

// What goes with a scalar type T: a bundle of lanes, its integers, and a row of 16 values (four
// grid nodes with four components each).
template <class T>
struct LaneTraits;

template <>
struct LaneTraits<float> {
  using Real = Float16;
  using Integer = Int16;
  using Row = Float16;
  using IntegerScalar = std::int32_t;
  static constexpr int kWidth = 16;
};

template <>
struct LaneTraits<double> {
  using Real = Double8;
  using Integer = Int8;
  using Row = Double16;
  using IntegerScalar = std::int64_t;
  static constexpr int kWidth = 8;
};

template <class R>
struct ScalarOf {
  using Type = R;
};
template <>
struct ScalarOf<Float16> {
  using Type = float;
};
template <>
struct ScalarOf<Double8> {
  using Type = double;
};

// What a comparison of two R gives.
template <class R>
using Mask = decltype(R{} > R{});

template <class R, class T>
VULNUS_HD R broadcast(T value) {
  return R{} + static_cast<typename ScalarOf<R>::Type>(value);
}

VULNUS_HD float select(bool mask, float a, float b) { return mask ? a : b; }
VULNUS_HD double select(bool mask, double a, double b) { return mask ? a : b; }
VULNUS_HD Double8 select(Int8 mask, Double8 a, Double8 b) { return mask ? a : b; }
#ifdef __AVX512F__
VULNUS_HD Float16 select(Int16 mask, Float16 a, Float16 b) { return mask ? a : b; }
VULNUS_HD Int16 select(Int16 mask, Int16 a, Int16 b) { return mask ? a : b; }
#else
template <class H>
VULNUS_HD LanePair<H> select(Int16 mask, LanePair<H> a, LanePair<H> b) {
  return {mask.half[0] ? a.half[0] : b.half[0], mask.half[1] ? a.half[1] : b.half[1]};
}
#endif

// Lanes of numbers without their fraction, and back; `bits` reads a float's as an integer's.
#ifdef __AVX512F__
VULNUS_HD Int16 truncated(Float16 a) { return __builtin_convertvector(a, Int16); }
VULNUS_HD Float16 real(Int16 a) { return __builtin_convertvector(a, Float16); }
VULNUS_HD Int16 bits(Float16 a) { return reinterpret_cast<Int16>(a); }
VULNUS_HD Float16 from_bits(Int16 a) { return reinterpret_cast<Float16>(a); }
#else
VULNUS_HD Int16 truncated(Float16 a) {
  return {__builtin_convertvector(a.half[0], IntHalf), __builtin_convertvector(a.half[1], IntHalf)};
}
VULNUS_HD Float16 real(Int16 a) {
  return {__builtin_convertvector(a.half[0], FloatHalf),
          __builtin_convertvector(a.half[1], FloatHalf)};
}
VULNUS_HD Int16 bits(Float16 a) {
  return {reinterpret_cast<IntHalf>(a.half[0]), reinterpret_cast<IntHalf>(a.half[1])};
}
VULNUS_HD Float16 from_bits(Int16 a) {
  return {reinterpret_cast<FloatHalf>(a.half[0]), reinterpret_cast<FloatHalf>(a.half[1])};
}
#endif
VULNUS_HD Int8 truncated(Double8 a) { return __builtin_convertvector(a, Int8); }
VULNUS_HD Double8 real(Int8 a) { return __builtin_convertvector(a, Double8); }

// The largest power of two that is not above |a|.
VULNUS_HD Float16 magnitude(Float16 a) { return from_bits(bits(a) & 0x7f800000); }

VULNUS_HD bool any(bool mask) { return mask; }
VULNUS_HD bool any(Int16 mask) {
#ifdef __AVX512F__
  return _mm512_test_epi32_mask(reinterpret_cast<__m512i>(mask), reinterpret_cast<__m512i>(mask)) !=
         0;
#else
  const IntHalf both = mask.half[0] | mask.half[1];
  std::int32_t found = 0;
  for (int i = 0; i < 8; ++i) found |= both[i];
  return found != 0;
#endif
}
VULNUS_HD bool any(Int8 mask) {
  std::int64_t found = 0;
  for (int i = 0; i < 8; ++i) found |= mask[i];
  return found != 0;
}

template <class R>
VULNUS_HD R maximum(R a, R b) {
  return select(a > b, a, b);
}
template <class R>
VULNUS_HD R minimum(R a, R b) {
  return select(a < b, a, b);
}

VULNUS_HD float square_root(float a) { return std::sqrt(a); }
VULNUS_HD double square_root(double a) { return std::sqrt(a); }
VULNUS_HD Float16 square_root(Float16 a) {
#ifdef __AVX512F__
  return reinterpret_cast<Float16>(_mm512_maskz_sqrt_ps(0xffff, reinterpret_cast<__m512>(a)));
#elif defined(__AVX__)
  return {reinterpret_cast<FloatHalf>(_mm256_sqrt_ps(reinterpret_cast<__m256>(a.half[0]))),
          reinterpret_cast<FloatHalf>(_mm256_sqrt_ps(reinterpret_cast<__m256>(a.half[1])))};
#else
  Float16 r{};
  for (int i = 0; i < 16; ++i) r[i] = std::sqrt(a[i]);
  return r;
#endif
}
VULNUS_HD Double8 square_root(Double8 a) {
  Double8 r{};
  for (int i = 0; i < 8; ++i) r[i] = std::sqrt(a[i]);
  return r;
}

// 1 / sqrt(a) for a > 0; lanes of floats: an estimate and one Newton step, that leaves 3/2 of the
// square of the estimate's error: below 2 ulp of 2^-14 (AVX-512), below 4 ulp of 3/2 2^-12 (AVX).
VULNUS_HD float reciprocal_square_root(float a) { return 1.0f / std::sqrt(a); }
VULNUS_HD double reciprocal_square_root(double a) { return 1.0 / std::sqrt(a); }
VULNUS_HD Double8 reciprocal_square_root(Double8 a) { return 1.0 / square_root(a); }
VULNUS_HD Float16 reciprocal_square_root(Float16 a) {
#ifdef __AVX512F__
  const Float16 r =
      reinterpret_cast<Float16>(_mm512_maskz_rsqrt14_ps(0xffff, reinterpret_cast<__m512>(a)));
  return r * (1.5f - 0.5f * a * r * r);
#elif defined(__AVX__)
  const Float16 r{
      reinterpret_cast<FloatHalf>(_mm256_rsqrt_ps(reinterpret_cast<__m256>(a.half[0]))),
      reinterpret_cast<FloatHalf>(_mm256_rsqrt_ps(reinterpret_cast<__m256>(a.half[1])))};
  return r * (1.5f - 0.5f * a * r * r);
#else
  return 1.0f / square_root(a);
#endif
}

template <class R>
VULNUS_HD R absolute(R a) {
  return select(a < R{}, -a, a);
}

// log(1 + x), accurate relative to x for small x. Doubles go through libm (validation build).
VULNUS_HD float log_one_plus(float x) { return std::log1p(x); }
VULNUS_HD double log_one_plus(double x) { return std::log1p(x); }
VULNUS_HD Double8 log_one_plus(Double8 x) {
  Double8 r{};
  for (int i = 0; i < 8; ++i) r[i] = std::log1p(x[i]);
  return r;
}

// Natural logarithm of u > 0 in lanes: polynomial of the Cephes library (logf), |error| < 2 ulp.
VULNUS_HD Float16 logarithm(Float16 u) {
  Int16 exponent = (bits(u) >> 23) - 126;
  Float16 m = from_bits((bits(u) & 0x007fffff) | 0x3f000000);  // [0.5, 1)
  const Int16 low = m < 0.70710678f;
  m = select(low, m + m, m);
  exponent = select(low, exponent - 1, exponent);
  const Float16 e = real(exponent);
  const Float16 x = m - 1.0f;
  const Float16 z = x * x;
  Float16 y = Float16{} + 7.0376836292e-2f;
  y = y * x - 1.1514610310e-1f;
  y = y * x + 1.1676998740e-1f;
  y = y * x - 1.2420140846e-1f;
  y = y * x + 1.4249322787e-1f;
  y = y * x - 1.6668057665e-1f;
  y = y * x + 2.0000714765e-1f;
  y = y * x - 2.4999993993e-1f;
  y = y * x + 3.3333331174e-1f;
  y = y * x * z - 2.12194440e-4f * e - 0.5f * z;
  return x + y + 0.693359375f * e;
}
VULNUS_HD Float16 log_one_plus(Float16 x) {
  const Float16 u = 1.0f + x;
  return logarithm(u) + (x - (u - 1.0f)) / u;
}

VULNUS_HD float logarithm(float x) { return std::log(x); }
VULNUS_HD double logarithm(double x) { return std::log(x); }
VULNUS_HD Double8 logarithm(Double8 x) {
  Double8 r{};
  for (int i = 0; i < 8; ++i) r[i] = std::log(x[i]);
  return r;
}

// exp(x) - 1, accurate relative to x for small x.
VULNUS_HD float exp_minus_one(float x) { return std::expm1(x); }
VULNUS_HD double exp_minus_one(double x) { return std::expm1(x); }
VULNUS_HD Double8 exp_minus_one(Double8 x) {
  Double8 r{};
  for (int i = 0; i < 8; ++i) r[i] = std::expm1(x[i]);
  return r;
}
VULNUS_HD Float16 exp_minus_one(Float16 x) {
  x = minimum(maximum(x, Float16{} - 80.0f), Float16{} + 80.0f);
  const Float16 scaled = x * 1.44269504088896341f;
  const Int16 n = truncated(scaled + select(scaled < 0.0f, Float16{} - 0.5f, Float16{} + 0.5f));
  const Float16 nf = real(n);
  const Float16 r = (x - nf * 0.693359375f) + nf * 2.12194440e-4f;  // |r| <= ln 2 / 2
  Float16 p = Float16{} + 1.9841270e-4f;  // Taylor to r^7 / 7!: 2e-9 at |r| = 0.35
  p = p * r + 1.3888889e-3f;
  p = p * r + 8.3333333e-3f;
  p = p * r + 4.1666667e-2f;
  p = p * r + 1.6666667e-1f;
  p = p * r + 0.5f;
  p = p * r * r + r;
  const Float16 power = from_bits((n + 127) << 23);
  return power * p + (power - 1.0f);
}

// a^b for a > 0.
template <class R>
VULNUS_HD R power(R a, R b) {
  return exp_minus_one(b * logarithm(a)) + broadcast<R>(1);
}

// Lanes from and to memory of any alignment.
template <class R, class T>
VULNUS_HD R load_lanes(const T* p) {
  R r;
  if constexpr (std::is_same_v<R, LanePair<FloatHalf>>) {
    std::memcpy(&r.half[0], p, sizeof(FloatHalf));
    std::memcpy(&r.half[1], p + 8, sizeof(FloatHalf));
  } else {
    std::memcpy(&r, p, sizeof(R));
  }
  return r;
}
template <class R, class T>
VULNUS_HD void store_lanes(T* p, const R& r) {
  if constexpr (std::is_same_v<R, LanePair<FloatHalf>>) {
    std::memcpy(p, &r.half[0], sizeof(FloatHalf));
    std::memcpy(p + 8, &r.half[1], sizeof(FloatHalf));
  } else {
    std::memcpy(p, &r, sizeof(R));
  }
}

// Value of a 16-entry table at each lane's index.
VULNUS_HD Float16 look_up(const float* table, Int16 index) {
#ifdef __AVX512F__
  const Float16 t = *reinterpret_cast<const Float16*>(table);
  return __builtin_shuffle(t, index);
#else
  const Float16 t = *reinterpret_cast<const Float16*>(table);
  const Int16 upper = index > 7, lane = index & 7;
  const Float16 low{__builtin_shuffle(t.half[0], lane.half[0]),
                    __builtin_shuffle(t.half[0], lane.half[1])};
  const Float16 high{__builtin_shuffle(t.half[1], lane.half[0]),
                     __builtin_shuffle(t.half[1], lane.half[1])};
  return select(upper, high, low);
#endif
}
VULNUS_HD Double8 look_up(const double* table, Int8 index) {
  Double8 r{};
  for (int i = 0; i < 8; ++i) r[i] = table[index[i]];
  return r;
}

// Swaps the lanes of a that have the bit Step with those of b that have it not.
#ifdef __AVX512F__
template <int Step, std::size_t... Lane>
VULNUS_HD void exchange(Float16& a, Float16& b, std::index_sequence<Lane...>) {
  const Float16 x = a;
  const Float16 y = b;
  a = __builtin_shufflevector(x, y, ((Lane & Step) ? int(Lane) - Step + 16 : int(Lane))...);
  b = __builtin_shufflevector(x, y, ((Lane & Step) ? int(Lane) + 16 : int(Lane) + Step)...);
}
template <int Step>
VULNUS_HD void exchange(Float16& a, Float16& b) {
  exchange<Step>(a, b, std::make_index_sequence<16>{});
}
#else
template <int Step, std::size_t... Lane>
VULNUS_HD void exchange(FloatHalf& a, FloatHalf& b, std::index_sequence<Lane...>) {
  const FloatHalf x = a;
  const FloatHalf y = b;
  a = __builtin_shufflevector(x, y, ((Lane & Step) ? int(Lane) - Step + 8 : int(Lane))...);
  b = __builtin_shufflevector(x, y, ((Lane & Step) ? int(Lane) + 8 : int(Lane) + Step)...);
}
template <int Step>
VULNUS_HD void exchange(Float16& a, Float16& b) {
  if constexpr (Step == 8) {
    std::swap(a.half[1], b.half[0]);
  } else {
    for (int h = 0; h < 2; ++h) exchange<Step>(a.half[h], b.half[h], std::make_index_sequence<8>{});
  }
}
#endif

// Transposes 16 rows of 16 floats in place.
VULNUS_HD void transpose(Float16 (&row)[16]) {
#pragma GCC unroll 16
  for (int i = 0; i < 8; ++i) exchange<8>(row[i], row[i + 8]);
#pragma GCC unroll 16
  for (int i = 0; i < 16; ++i)
    if (!(i & 4)) exchange<4>(row[i], row[i + 4]);
#pragma GCC unroll 16
  for (int i = 0; i < 16; ++i)
    if (!(i & 2)) exchange<2>(row[i], row[i + 2]);
#pragma GCC unroll 16
  for (int i = 0; i < 16; ++i)
    if (!(i & 1)) exchange<1>(row[i], row[i + 1]);
}

}  // namespace vulnus
