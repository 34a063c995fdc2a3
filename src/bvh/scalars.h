// SPDX-License-Identifier: Apache-2.0
// Single floats, in the namespace of the instruction set that the including file is compiled for.
#pragma once

#include "bvh/simd.h"

namespace sunstone::bvh::SUNSTONE_ISA {

SUNSTONE_INLINE float absolute(float a) {
    return __builtin_fabsf(a);
}
SUNSTONE_INLINE float smaller(float a, float b) {
    return a < b ? a : b;
}
SUNSTONE_INLINE float larger(float a, float b) {
    return a > b ? a : b;
}
SUNSTONE_INLINE uint32_t bitsOf(float a) {
    return __builtin_bit_cast(uint32_t, a);
}
SUNSTONE_INLINE bool finite(float a) {
    return (bitsOf(a) & 0x7F800000u) != 0x7F800000u;
}

} // namespace sunstone::bvh::SUNSTONE_ISA
