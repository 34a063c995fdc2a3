// SPDX-License-Identifier: Apache-2.0
// Half precision: __half and __half2 with their functions. Sums, products, comparisons and
// conversions are for host and device code; mathematics, atomics and shuffles for device code only.
#ifndef SUNSTONE_CUDA_FP16_H
#define SUNSTONE_CUDA_FP16_H
#ifndef __CUDA_FP16_H__
#define __CUDA_FP16_H__ // disables a toolkit's header
#endif

#include "cuda_runtime.h"
#include "sunstone/narrow_floats.h"

namespace sunstone_narrow {

SUNSTONE_BOTH float widenHalf(unsigned short bits) {
#ifdef __CUDA_ARCH__
    float wide;
    asm("cvt.f32.f16 %0, %1;" : "=f"(wide) : "h"(bits));
    return wide;
#else
    const unsigned sign = (bits & 0x8000u) << 16, exponent = bits >> 10 & 31, fraction = bits & 0x3ff;
    if (exponent == 0) {
        const float wide = (float)fraction * 5.9604644775390625e-8f;
        return sign ? -wide : wide;
    }
    return __builtin_bit_cast(float, sign | (exponent == 31 ? 255 : exponent + 112) << 23 |
                                         fraction << 13);
#endif
}
SUNSTONE_BOTH unsigned short nearestHalf(float x) {
#ifdef __CUDA_ARCH__
    unsigned short bits;
    asm("cvt.rn.f16.f32 %0, %1;" : "=h"(bits) : "f"(x));
    return bits;
#else
    return roundTo<10>(x, Rounding::kNearest);
#endif
}
SUNSTONE_BOTH unsigned short fusedHalf(unsigned short a, unsigned short b, unsigned short c) {
#ifdef __CUDA_ARCH__
    unsigned short bits;
    asm("fma.rn.f16 %0, %1, %2, %3;" : "=h"(bits) : "h"(a), "h"(b), "h"(c));
    return bits;
#else
    return roundTo<10>(fused(widenHalf(a), widenHalf(b), widenHalf(c)), Rounding::kNearest);
#endif
}

} // namespace sunstone_narrow

#define SUNSTONE_NARROW __half
#define SUNSTONE_NARROW2 __half2
#define SUNSTONE_WORD half
#define SUNSTONE_WORD2 half2
#define SUNSTONE_FRACTION 10
#define SUNSTONE_WIDEN(bits) sunstone_narrow::widenHalf(bits)
#define SUNSTONE_NEAREST(x) sunstone_narrow::nearestHalf(x)
#define SUNSTONE_FUSED(a, b, c) sunstone_narrow::fusedHalf((a).__x, (b).__x, (c).__x)
#include "sunstone/narrow_types.h"
#include "sunstone/narrow_functions.h"

typedef __half __nv_half;
typedef __half2 __nv_half2;
typedef __half_raw __nv_half_raw;
typedef __half2_raw __nv_half2_raw;
typedef __half nv_half;
typedef __half2 nv_half2;
#ifndef CUDA_NO_HALF
typedef __half half;
typedef __half2 half2;
#endif

#define CUDART_INF_FP16 __ushort_as_half((unsigned short)0x7c00u)
#define CUDART_NAN_FP16 __ushort_as_half((unsigned short)0x7fffu)
#define CUDART_MIN_DENORM_FP16 __ushort_as_half((unsigned short)0x0001u)
#define CUDART_MAX_NORMAL_FP16 __ushort_as_half((unsigned short)0x7bffu)
#define CUDART_NEG_ZERO_FP16 __ushort_as_half((unsigned short)0x8000u)
#define CUDART_ZERO_FP16 __ushort_as_half((unsigned short)0x0000u)
#define CUDART_ONE_FP16 __ushort_as_half((unsigned short)0x3c00u)

#ifdef __CUDACC_RTC__
#include "cuda_bf16.h" // toolkit headers define both types with either include
#endif

#endif
