// SPDX-License-Identifier: Apache-2.0
// Shared by cuda_fp16.h and cuda_bf16.h: rounding to 16 bits and back, with the same bits in host
// and device code. narrow_types.h and narrow_functions.h, which both headers include once for each
// format, build on it.
#ifndef SUNSTONE_NARROW_FLOATS_H
#define SUNSTONE_NARROW_FLOATS_H

#include "../host_defines.h"
#include "../vector_functions.h"
#include "../vector_types.h"

#ifdef SUNSTONE_CUDA_COMPILATION
#define SUNSTONE_BOTH static __inline__ __attribute__((host, device))
#define SUNSTONE_MEMBER __attribute__((host, device))
#else
#define SUNSTONE_BOTH static inline
#define SUNSTONE_MEMBER
#endif

namespace sunstone_narrow {

enum class Rounding { kNearest, kZero, kDown, kUp };

// The number's bits with 1 + (15 - kFraction) + kFraction of them; every NaN becomes 0x7fff.
template <int kFraction>
SUNSTONE_BOTH unsigned short roundTo(double x, Rounding rounding) {
    constexpr int kBias = (1 << (14 - kFraction)) - 1;
    constexpr unsigned kInfinity = ((1u << (15 - kFraction)) - 1) << kFraction;
    const unsigned long long bits = __builtin_bit_cast(unsigned long long, x);
    const unsigned sign = (unsigned)(bits >> 63) << 15;
    const int exponent = (int)(bits >> 52 & 0x7ff) - 1023;
    const unsigned long long fraction = bits & 0xfffffffffffffull;
    if (exponent == 1024 && fraction != 0)
        return 0x7fff;
    const bool outwards = rounding == (sign ? Rounding::kDown : Rounding::kUp);
    const unsigned overflow =
        rounding == Rounding::kNearest || outwards || exponent == 1024 ? kInfinity : kInfinity - 1;
    if (exponent > kBias)
        return (unsigned short)(sign | overflow);
    // Bits to drop; below the smallest normal number one more for each power of two.
    int shift = 52 - kFraction;
    const int biased = exponent + kBias;
    if (biased <= 0)
        shift = shift + 1 - biased < 63 ? shift + 1 - biased : 63;
    const unsigned long long whole = exponent == -1023 ? fraction : fraction | 1ull << 52;
    const unsigned long long rest = whole & ((1ull << shift) - 1), half = 1ull << (shift - 1);
    const unsigned kept = (unsigned)(whole >> shift);
    const bool up = rounding == Rounding::kNearest ? rest > half || (rest == half && (kept & 1))
                                                   : outwards && rest != 0;
    const unsigned magnitude =
        (biased > 0 ? kept + ((unsigned)(biased - 1) << kFraction) : kept) + (up ? 1 : 0);
    return (unsigned short)(sign | (magnitude < kInfinity ? magnitude : overflow));
}

// A 64-bit integer as a double that rounds to the same 16 bits: dropped bits set a sticky bit.
SUNSTONE_BOTH double sticky(unsigned long long x) {
    return (double)(x >> 53 ? (x & ~0xfffull) | (x & 0xfff ? 0x800 : 0) : x);
}
SUNSTONE_BOTH double exactly(long long x) {
    return x < 0 ? -sticky(0ull - (unsigned long long)x) : sticky((unsigned long long)x);
}
SUNSTONE_BOTH double exactly(unsigned long long x) { return sticky(x); }
SUNSTONE_BOTH double exactly(long x) { return exactly((long long)x); }
SUNSTONE_BOTH double exactly(unsigned long x) { return exactly((unsigned long long)x); }
SUNSTONE_BOTH double exactly(int x) { return x; }
SUNSTONE_BOTH double exactly(unsigned x) { return x; }
SUNSTONE_BOTH double exactly(short x) { return x; }
SUNSTONE_BOTH double exactly(unsigned short x) { return x; }
SUNSTONE_BOTH double exactly(double x) { return x; }
SUNSTONE_BOTH double exactly(float x) { return x; }

// Converts to an integer, clamped to the type's limits. NaN becomes 0, or the top bit for 64-bit
// types.
template <class T>
SUNSTONE_BOTH T integerOf(float x, Rounding rounding) {
    constexpr bool kSigned = (T)-1 < (T)0;
    constexpr int kBits = sizeof(T) * 8 - (kSigned ? 1 : 0);
    constexpr T kLargest = (T)(~0ull >> (64 - kBits));
    constexpr T kLeast = kSigned ? (T)(-kLargest - 1) : (T)0;
    if (x != x)
        return sizeof(T) == 8 ? (T)(1ull << 63) : (T)0;
    const float whole = rounding == Rounding::kNearest ? __builtin_rintf(x)
                        : rounding == Rounding::kZero  ? __builtin_truncf(x)
                        : rounding == Rounding::kDown  ? __builtin_floorf(x)
                                                       : __builtin_ceilf(x);
    if (whole >= 2.0f * (float)(1ull << (kBits - 1)))
        return kLargest;
    return kSigned ? (whole <= -2.0f * (float)(1ull << (kBits - 1)) ? kLeast : (T)whole)
                   : (whole <= 0 ? (T)0 : (T)whole);
}

// a * b + c of numbers with at most 24 bits, as a double that rounds to fewer bits like the exact
// sum: the product is exact, and an inexact sum gets an odd last bit.
SUNSTONE_BOTH double fused(double a, double b, double c) {
    const double product = a * b, sum = product + c;
    const double part = sum - product;
    const double error = (product - (sum - part)) + (c - part);
    long long bits = __builtin_bit_cast(long long, sum);
    if (error == 0 || error != error || (bits & 1))
        return sum;
    bits += (error > 0) == (sum > 0) ? 1 : -1;
    return __builtin_bit_cast(double, bits);
}

// One operation that a compiler must not contract with another.
SUNSTONE_BOTH float add(float a, float b) {
#ifdef __CUDA_ARCH__
    return __fadd_rn(a, b);
#else
    return a + b;
#endif
}
SUNSTONE_BOTH float multiply(float a, float b) {
#ifdef __CUDA_ARCH__
    return __fmul_rn(a, b);
#else
    return a * b;
#endif
}
SUNSTONE_BOTH float divide(float a, float b) {
#ifdef __CUDA_ARCH__
    return __fdiv_rn(a, b);
#else
    return a / b;
#endif
}

} // namespace sunstone_narrow

#endif
