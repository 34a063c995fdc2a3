// SPDX-License-Identifier: Apache-2.0
// bfloat16: __nv_bfloat16 and __nv_bfloat162 with the functions that cuda_fp16.h has for halves.
// They need no special instruction, so every target compiles them.
#ifndef SUNSTONE_CUDA_BF16_H
#define SUNSTONE_CUDA_BF16_H
#ifndef __CUDA_BF16_H__
#define __CUDA_BF16_H__ // disables a toolkit's header
#endif

#include "cuda_runtime.h"
#include "sunstone/narrow_floats.h"

namespace sunstone_narrow {

SUNSTONE_BOTH float widenBfloat16(unsigned short bits) {
    return __builtin_bit_cast(float, (unsigned)bits << 16);
}
SUNSTONE_BOTH unsigned short nearestBfloat16(float x) {
    const unsigned bits = __builtin_bit_cast(unsigned, x);
    if ((bits & 0x7fffffffu) > 0x7f800000u)
        return 0x7fff;
    return (unsigned short)((bits + 0x7fffu + (bits >> 16 & 1)) >> 16);
}

} // namespace sunstone_narrow

#define SUNSTONE_NARROW __nv_bfloat16
#define SUNSTONE_NARROW2 __nv_bfloat162
#define SUNSTONE_WORD bfloat16
#define SUNSTONE_WORD2 bfloat162
#define SUNSTONE_FRACTION 7
#define SUNSTONE_WIDEN(bits) sunstone_narrow::widenBfloat16(bits)
#define SUNSTONE_NEAREST(x) sunstone_narrow::nearestBfloat16(x)
#define SUNSTONE_FUSED(a, b, c)                                                                    \
    sunstone_narrow::roundTo<7>(sunstone_narrow::fused(sunstone_narrow::widen(a),                  \
                                                       sunstone_narrow::widen(b),                  \
                                                       sunstone_narrow::widen(c)),                 \
                                sunstone_narrow::Rounding::kNearest)
#include "sunstone/narrow_types.h"
#include "sunstone/narrow_functions.h"

typedef __nv_bfloat16 nv_bfloat16;
typedef __nv_bfloat162 nv_bfloat162;

#define CUDART_INF_BF16 __ushort_as_bfloat16((unsigned short)0x7f80u)
#define CUDART_NAN_BF16 __ushort_as_bfloat16((unsigned short)0x7fffu)
#define CUDART_MIN_DENORM_BF16 __ushort_as_bfloat16((unsigned short)0x0001u)
#define CUDART_MAX_NORMAL_BF16 __ushort_as_bfloat16((unsigned short)0x7f7fu)
#define CUDART_NEG_ZERO_BF16 __ushort_as_bfloat16((unsigned short)0x8000u)
#define CUDART_ZERO_BF16 __ushort_as_bfloat16((unsigned short)0x0000u)
#define CUDART_ONE_BF16 __ushort_as_bfloat16((unsigned short)0x3f80u)

#ifdef __CUDACC_RTC__
#include "cuda_fp16.h" // toolkit headers define both types with either include
#endif

#endif
