// SPDX-License-Identifier: Apache-2.0
// Vectors of one, four and eight floats with arithmetic, comparison and selection as operators, for
// intersection tests with much arithmetic. Comparisons give vectors of 0 and -1, `m ? a : b`
// selects. Included by files compiled once per instruction set (see simd.h).
#pragma once

#include "bvh/simd.h"

namespace sunstone::bvh::SUNSTONE_ISA {

using V1 = float __attribute__((vector_size(4)));
using V4 = float __attribute__((vector_size(16)));
using V8 = float __attribute__((vector_size(32)));

// The ABI of arguments does not matter, because all functions are inlined.
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpsabi"

template <unsigned N>
struct VectorOf;
template <>
struct VectorOf<1> {
    using Type = V1;
};
template <>
struct VectorOf<4> {
    using Type = V4;
};
template <>
struct VectorOf<8> {
    using Type = V8;
};
template <unsigned N>
using Lanes = typename VectorOf<N>::Type;

template <class V>
SUNSTONE_INLINE V all(float a) {
    return V{} + a;
}
// a * b + c, in one rounding where the processor can.
template <class V>
SUNSTONE_INLINE V fused(V a, V b, V c) {
#if defined(__FMA__) || defined(__NVPTX__)
    return __builtin_elementwise_fma(a, b, c);
#else
    return a * b + c;
#endif
}
template <class V>
SUNSTONE_INLINE V leastOf(V a, V b) {
    return a < b ? a : b;
}
template <class V>
SUNSTONE_INLINE V mostOf(V a, V b) {
    return a > b ? a : b;
}
template <class V>
SUNSTONE_INLINE V rootOf(V a) {
    return __builtin_elementwise_sqrt(a);
}
// The root of a number, or 0 where it is negative. On GPUs the root of zero takes a slow path, in
// the driver's compiler too.
template <class V>
SUNSTONE_INLINE V rootOrZero(V a) {
#if defined(__NVPTX__)
    const auto isUsual = a > 0.0f;
    return isUsual ? rootOf(isUsual ? a : all<V>(1)) : V{};
#else
    return rootOf(mostOf(a, V{}));
#endif
}
template <class V>
SUNSTONE_INLINE V magnitude(V a) {
    return __builtin_elementwise_abs(a);
}
SUNSTONE_INLINE Mask bitsOfMask(__attribute__((vector_size(4))) int m) {
    return Mask(m[0]) & 1;
}
#if !defined(__NVPTX__)
SUNSTONE_INLINE Mask bitsOfMask(__attribute__((vector_size(32))) int m) {
    using Bits = bool __attribute__((ext_vector_type(8)));
    return __builtin_bit_cast(uint8_t, __builtin_convertvector(m, Bits));
}
SUNSTONE_INLINE Mask bitsOfMask(__attribute__((vector_size(16))) int m) {
    return Mask(_mm_movemask_ps(__builtin_bit_cast(__m128, m)));
}
#endif
template <class V>
SUNSTONE_INLINE V loadLanes(const float* p) {
    V v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
}

#pragma clang diagnostic pop

} // namespace sunstone::bvh::SUNSTONE_ISA
