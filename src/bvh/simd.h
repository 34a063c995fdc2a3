// SPDX-License-Identifier: Apache-2.0
// Four and eight floats at once, for traversal. Compiled once per instruction set, with everything
// in a namespace named after the set, so that the linker cannot merge inline functions of two sets.
// Always included through traverse.h by the *_avx512.cpp, *_avx2.cpp and *_baseline.cpp files.
#pragma once

#include "base/inline.h"

#include <cstdint>
#if !defined(__NVPTX__)
#include <immintrin.h>
#endif

#if defined(__NVPTX__) // a further set, without vectors: a lane is a thread
#define SUNSTONE_ISA nvptx
#elif defined(__AVX512VL__) && defined(__AVX512DQ__)
#define SUNSTONE_ISA avx512
#elif defined(__AVX2__) && defined(__FMA__)
#define SUNSTONE_ISA avx2
#else
#define SUNSTONE_ISA baseline
#endif

namespace sunstone::bvh::SUNSTONE_ISA {

// Lanes as bits 0..N-1.
using Mask = uint32_t;

SUNSTONE_INLINE uint32_t lowestBit(Mask m) { return uint32_t(__builtin_ctz(m)); }

#if !defined(__NVPTX__)

struct F4 {
    static constexpr unsigned kLanes = 4;
    __m128 v;
};

SUNSTONE_INLINE F4 load(const float* p, F4*) { return {_mm_load_ps(p)}; }
SUNSTONE_INLINE void store(float* p, F4 a) { _mm_store_ps(p, a.v); }
SUNSTONE_INLINE F4 splat(float s, F4*) { return {_mm_set1_ps(s)}; }
SUNSTONE_INLINE F4 operator+(F4 a, F4 b) { return {_mm_add_ps(a.v, b.v)}; }
SUNSTONE_INLINE F4 operator-(F4 a, F4 b) { return {_mm_sub_ps(a.v, b.v)}; }
SUNSTONE_INLINE F4 operator*(F4 a, F4 b) { return {_mm_mul_ps(a.v, b.v)}; }
SUNSTONE_INLINE F4 operator/(F4 a, F4 b) { return {_mm_div_ps(a.v, b.v)}; }
SUNSTONE_INLINE F4 min(F4 a, F4 b) { return {_mm_min_ps(a.v, b.v)}; }
SUNSTONE_INLINE F4 max(F4 a, F4 b) { return {_mm_max_ps(a.v, b.v)}; }
#if defined(__AVX512VL__)
SUNSTONE_INLINE Mask lessEqual(F4 a, F4 b) { return _mm_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
SUNSTONE_INLINE Mask equal(F4 a, F4 b) { return _mm_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ); }
#else
SUNSTONE_INLINE Mask lessEqual(F4 a, F4 b) {
    return Mask(_mm_movemask_ps(_mm_cmple_ps(a.v, b.v)));
}
SUNSTONE_INLINE Mask equal(F4 a, F4 b) { return Mask(_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v))); }
#endif

#if defined(__AVX2__)
struct F8 {
    static constexpr unsigned kLanes = 8;
    __m256 v;
};
SUNSTONE_INLINE F8 load(const float* p, F8*) { return {_mm256_load_ps(p)}; }
SUNSTONE_INLINE void store(float* p, F8 a) { _mm256_store_ps(p, a.v); }
SUNSTONE_INLINE F8 splat(float s, F8*) { return {_mm256_set1_ps(s)}; }
SUNSTONE_INLINE F8 operator+(F8 a, F8 b) { return {_mm256_add_ps(a.v, b.v)}; }
SUNSTONE_INLINE F8 operator-(F8 a, F8 b) { return {_mm256_sub_ps(a.v, b.v)}; }
SUNSTONE_INLINE F8 operator*(F8 a, F8 b) { return {_mm256_mul_ps(a.v, b.v)}; }
SUNSTONE_INLINE F8 operator/(F8 a, F8 b) { return {_mm256_div_ps(a.v, b.v)}; }
SUNSTONE_INLINE F8 min(F8 a, F8 b) { return {_mm256_min_ps(a.v, b.v)}; }
SUNSTONE_INLINE F8 max(F8 a, F8 b) { return {_mm256_max_ps(a.v, b.v)}; }
#if defined(__AVX512VL__)
SUNSTONE_INLINE Mask lessEqual(F8 a, F8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
SUNSTONE_INLINE Mask equal(F8 a, F8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ); }
#else
SUNSTONE_INLINE Mask lessEqual(F8 a, F8 b) {
    return Mask(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)));
}
SUNSTONE_INLINE Mask equal(F8 a, F8 b) {
    return Mask(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)));
}
#endif
#else
struct F8 {
    static constexpr unsigned kLanes = 8;
    __m128 lo, hi;
};
SUNSTONE_INLINE F8 load(const float* p, F8*) { return {_mm_load_ps(p), _mm_load_ps(p + 4)}; }
SUNSTONE_INLINE void store(float* p, F8 a) {
    _mm_store_ps(p, a.lo);
    _mm_store_ps(p + 4, a.hi);
}
SUNSTONE_INLINE F8 splat(float s, F8*) { return {_mm_set1_ps(s), _mm_set1_ps(s)}; }
SUNSTONE_INLINE F8 operator+(F8 a, F8 b) {
    return {_mm_add_ps(a.lo, b.lo), _mm_add_ps(a.hi, b.hi)};
}
SUNSTONE_INLINE F8 operator-(F8 a, F8 b) {
    return {_mm_sub_ps(a.lo, b.lo), _mm_sub_ps(a.hi, b.hi)};
}
SUNSTONE_INLINE F8 operator*(F8 a, F8 b) {
    return {_mm_mul_ps(a.lo, b.lo), _mm_mul_ps(a.hi, b.hi)};
}
SUNSTONE_INLINE F8 operator/(F8 a, F8 b) {
    return {_mm_div_ps(a.lo, b.lo), _mm_div_ps(a.hi, b.hi)};
}
SUNSTONE_INLINE F8 min(F8 a, F8 b) { return {_mm_min_ps(a.lo, b.lo), _mm_min_ps(a.hi, b.hi)}; }
SUNSTONE_INLINE F8 max(F8 a, F8 b) { return {_mm_max_ps(a.lo, b.lo), _mm_max_ps(a.hi, b.hi)}; }
SUNSTONE_INLINE Mask lessEqual(F8 a, F8 b) {
    return Mask(_mm_movemask_ps(_mm_cmple_ps(a.lo, b.lo)) |
                _mm_movemask_ps(_mm_cmple_ps(a.hi, b.hi)) << 4);
}
SUNSTONE_INLINE Mask equal(F8 a, F8 b) {
    return Mask(_mm_movemask_ps(_mm_cmpeq_ps(a.lo, b.lo)) |
                _mm_movemask_ps(_mm_cmpeq_ps(a.hi, b.hi)) << 4);
}
#endif

// The power of two by which the magnitude of a lane comes into [1, 2); undefined beyond 2^127.
SUNSTONE_INLINE __m128 inversePower(__m128 a) {
    const __m128i exponent = _mm_and_si128(_mm_castps_si128(a), _mm_set1_epi32(0x7F800000));
    return _mm_castsi128_ps(_mm_sub_epi32(_mm_set1_epi32(0x7F000000), exponent));
}
SUNSTONE_INLINE F4 inversePower(F4 a) { return {inversePower(a.v)}; }
#if defined(__AVX2__)
SUNSTONE_INLINE F8 inversePower(F8 a) {
    const __m256i exponent =
        _mm256_and_si256(_mm256_castps_si256(a.v), _mm256_set1_epi32(0x7F800000));
    return {_mm256_castsi256_ps(_mm256_sub_epi32(_mm256_set1_epi32(0x7F000000), exponent))};
}
#else
SUNSTONE_INLINE F8 inversePower(F8 a) { return {inversePower(a.lo), inversePower(a.hi)}; }
#endif

#if defined(__FMA__)
SUNSTONE_INLINE F8 fusedMultiplyAdd(F8 a, F8 b, F8 c) { return {_mm256_fmadd_ps(a.v, b.v, c.v)}; }
#else
F8 fusedMultiplyAdd(F8 a, F8 b, F8 c); // missing: callers check kFusedSlab first
#endif

// Distances to a plane of eight boxes, see ray_setup.h: with FMA plane * r + c, else (plane - org)
// * r + c with a c that does not contain -org * r.
SUNSTONE_INLINE F8 slab(F8 plane, [[maybe_unused]] F8 org, F8 r, F8 c) {
#if defined(__FMA__)
    return {_mm256_fmadd_ps(plane.v, r.v, c.v)};
#else
    return (plane - org) * r + c;
#endif
}
#if defined(__FMA__)
constexpr bool kFusedSlab = true;
#else
constexpr bool kFusedSlab = false;
#endif

SUNSTONE_INLINE F4 lowHalf(F8 a) {
#if defined(__AVX2__)
    return {_mm256_castps256_ps128(a.v)};
#else
    return {a.lo};
#endif
}

#endif // __NVPTX__

} // namespace sunstone::bvh::SUNSTONE_ISA
