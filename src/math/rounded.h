// SPDX-License-Identifier: Apache-2.0
// Arithmetic with defined rounding. Each operation has a name and is rounded separately: no
// compiler fuses a product with a sum on GPUs, where that is the default. The same lines compile
// for CPUs, for nvptx64 and as CUDA, and give the same bits.
#pragma once

#include "base/inline.h"

namespace sunstone::math {

#if defined(__NVPTX__)
SUNSTONE_INLINE float mul(float a, float b) {
    return __nvvm_mul_rn_f(a, b);
}
SUNSTONE_INLINE float add(float a, float b) {
    return __nvvm_add_rn_f(a, b);
}
SUNSTONE_INLINE float sub(float a, float b) {
    return __nvvm_add_rn_f(a, -b);
}
SUNSTONE_INLINE float divide(float a, float b) {
    return __nvvm_div_rn_f(a, b);
}
SUNSTONE_INLINE float root(float a) {
    return __nvvm_sqrt_rn_f(a);
}
SUNSTONE_INLINE double mul(double a, double b) {
    return __nvvm_mul_rn_d(a, b);
}
SUNSTONE_INLINE double add(double a, double b) {
    return __nvvm_add_rn_d(a, b);
}
SUNSTONE_INLINE double sub(double a, double b) {
    return __nvvm_add_rn_d(a, -b);
}
#else
SUNSTONE_INLINE float mul(float a, float b) {
    return a * b;
}
SUNSTONE_INLINE float add(float a, float b) {
    return a + b;
}
SUNSTONE_INLINE float sub(float a, float b) {
    return a - b;
}
SUNSTONE_INLINE float divide(float a, float b) {
    return a / b;
}
SUNSTONE_INLINE float root(float a) {
    return __builtin_sqrtf(a);
}
SUNSTONE_INLINE double mul(double a, double b) {
    return a * b;
}
SUNSTONE_INLINE double add(double a, double b) {
    return a + b;
}
SUNSTONE_INLINE double sub(double a, double b) {
    return a - b;
}
#endif

} // namespace sunstone::math
