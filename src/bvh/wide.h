// SPDX-License-Identifier: Apache-2.0
// Vectors of the width of the instruction set's registers, for loops over rays in lanes. Included
// by files that are compiled once per instruction set (see simd.h).
#pragma once

#include "bvh/simd.h"

namespace sunstone::bvh::SUNSTONE_ISA {

#if defined(__AVX512F__)

struct F16 {
    static constexpr unsigned kLanes = 16;
    __m512 v;
};
SUNSTONE_INLINE F16 load(const float* p, F16*) {
    return {_mm512_load_ps(p)};
}
SUNSTONE_INLINE void store(float* p, F16 a) {
    _mm512_store_ps(p, a.v);
}
SUNSTONE_INLINE F16 splat(float s, F16*) {
    return {_mm512_set1_ps(s)};
}
SUNSTONE_INLINE F16 operator+(F16 a, F16 b) {
    return {_mm512_add_ps(a.v, b.v)};
}
SUNSTONE_INLINE F16 operator-(F16 a, F16 b) {
    return {_mm512_sub_ps(a.v, b.v)};
}
SUNSTONE_INLINE F16 operator*(F16 a, F16 b) {
    return {_mm512_mul_ps(a.v, b.v)};
}
SUNSTONE_INLINE F16 operator/(F16 a, F16 b) {
    return {_mm512_div_ps(a.v, b.v)};
}
SUNSTONE_INLINE F16 min(F16 a, F16 b) {
    return {_mm512_min_ps(a.v, b.v)};
}
SUNSTONE_INLINE F16 max(F16 a, F16 b) {
    return {_mm512_max_ps(a.v, b.v)};
}
SUNSTONE_INLINE Mask lessEqual(F16 a, F16 b) {
    return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ);
}
SUNSTONE_INLINE Mask equal(F16 a, F16 b) {
    return _mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ);
}
SUNSTONE_INLINE F16 inversePower(F16 a) {
    const __m512i exponent =
        _mm512_and_si512(_mm512_castps_si512(a.v), _mm512_set1_epi32(0x7F800000));
    return {_mm512_castsi512_ps(_mm512_sub_epi32(_mm512_set1_epi32(0x7F000000), exponent))};
}
SUNSTONE_INLINE F16 magnitude(F16 a) {
    return {_mm512_abs_ps(a.v)};
}
SUNSTONE_INLINE F16 negative(F16 a) {
    return {_mm512_xor_ps(a.v, _mm512_set1_ps(-0.0f))};
}
// a, which must be positive, with the sign of b.
SUNSTONE_INLINE F16 withSign(F16 a, F16 b) {
    return {_mm512_or_ps(a.v, _mm512_and_ps(b.v, _mm512_set1_ps(-0.0f)))};
}
SUNSTONE_INLINE Mask signBits(F16 a) {
    return _mm512_movepi32_mask(_mm512_castps_si512(a.v));
}
SUNSTONE_INLINE F16 slab(F16 plane, F16, F16 r, F16 c) {
    return {_mm512_fmadd_ps(plane.v, r.v, c.v)};
}
using WideLanes = F16;

#elif defined(__AVX2__)

SUNSTONE_INLINE F8 negative(F8 a) {
    return {_mm256_xor_ps(a.v, _mm256_set1_ps(-0.0f))};
}
SUNSTONE_INLINE F8 magnitude(F8 a) {
    return {_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v)};
}
SUNSTONE_INLINE F8 withSign(F8 a, F8 b) {
    return {_mm256_or_ps(a.v, _mm256_and_ps(b.v, _mm256_set1_ps(-0.0f)))};
}
SUNSTONE_INLINE Mask signBits(F8 a) {
    return Mask(_mm256_movemask_ps(a.v));
}
using WideLanes = F8;

#else

SUNSTONE_INLINE F4 negative(F4 a) {
    return {_mm_xor_ps(a.v, _mm_set1_ps(-0.0f))};
}
SUNSTONE_INLINE F4 magnitude(F4 a) {
    return {_mm_andnot_ps(_mm_set1_ps(-0.0f), a.v)};
}
SUNSTONE_INLINE F4 withSign(F4 a, F4 b) {
    return {_mm_or_ps(a.v, _mm_and_ps(b.v, _mm_set1_ps(-0.0f)))};
}
SUNSTONE_INLINE Mask signBits(F4 a) {
    return Mask(_mm_movemask_ps(a.v));
}
SUNSTONE_INLINE F4 slab(F4 plane, F4 org, F4 r, F4 c) {
    return (plane - org) * r + c;
}
using WideLanes = F4;

#endif

} // namespace sunstone::bvh::SUNSTONE_ISA
