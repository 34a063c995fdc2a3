// SPDX-License-Identifier: Apache-2.0
// Hides the differences between compilers, so that the same code compiles as CUDA (builder
// kernels), as freestanding C++ for nvptx64 (run-time of device programs) and for the CPU (tests).
// Operations whose rounding matters have names (math/rounded.h); with any compiler flags, only
// fused() is fused.
#pragma once

#include "base/inline.h"
#include "math/rounded.h"

#include <cstdint>

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

using math::add;
using math::divide;
using math::mul;
using math::root;
using math::sub;

using U4 = uint32_t __attribute__((ext_vector_type(4)));
using U2 = uint32_t __attribute__((ext_vector_type(2)));

#if defined(__NVPTX__)
SUNSTONE_INLINE float fused(float a, float b, float c) {
    return __nvvm_fma_rn_f(a, b, c);
}
// Selects bytes of a (0..3) and b (4..7) by the four digits of the selector, the lowest first.
SUNSTONE_INLINE uint32_t permute(uint32_t a, uint32_t b, uint32_t selector) {
    return uint32_t(__nvvm_prmt(int(a), int(b), int(selector)));
}
// The reciprocal of a normal number, with an error of one unit in the last place.
SUNSTONE_INLINE float roughReciprocal(float a) {
    return __nvvm_rcp_approx_ftz_f(a);
}
// Memory that stays constant while the kernel runs.
SUNSTONE_INLINE U4 loadConstant(const U4* address) {
    return __nvvm_ldg_ui4(address);
}
SUNSTONE_INLINE uint32_t loadConstant(const uint32_t* address) {
    return __nvvm_ldg_ui(address);
}
#else
SUNSTONE_INLINE float fused(float a, float b, float c) {
    return __builtin_fmaf(a, b, c);
}
SUNSTONE_INLINE uint32_t permute(uint32_t a, uint32_t b, uint32_t selector) {
    uint32_t result = 0;
    for (uint32_t i = 0; i < 4; ++i) {
        const uint32_t from = selector >> 4 * i & 7;
        result |= ((from < 4 ? a >> 8 * from : b >> 8 * (from - 4)) & 255u) << 8 * i;
    }
    return result;
}
SUNSTONE_INLINE float roughReciprocal(float a) {
    return 1.0f / a;
}
SUNSTONE_INLINE U4 loadConstant(const U4* address) {
    return *address;
}
SUNSTONE_INLINE uint32_t loadConstant(const uint32_t* address) {
    return *address;
}
#endif

SUNSTONE_INLINE float smaller(float a, float b) {
    return __builtin_fminf(a, b);
}
SUNSTONE_INLINE float larger(float a, float b) {
    return __builtin_fmaxf(a, b);
}
SUNSTONE_INLINE float magnitude(float a) {
    return __builtin_fabsf(a);
}
// Shifts by the low five bits of `by`.
SUNSTONE_INLINE uint32_t shiftLeft(uint32_t a, uint32_t by) {
#if defined(__NVPTX__)
    uint32_t result; // one instruction; a shift by a masked amount would be two
    __asm__("shf.l.wrap.b32 %0, %1, %2, %3;" : "=r"(result) : "r"(0u), "r"(a), "r"(by));
    return result;
#else
    return a << (by & 31u);
#endif
}
SUNSTONE_INLINE uint32_t bitsOf(float a) {
    return __builtin_bit_cast(uint32_t, a);
}
SUNSTONE_INLINE float floatOf(uint32_t bits) {
    return __builtin_bit_cast(float, bits);
}

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
