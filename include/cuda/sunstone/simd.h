// SPDX-License-Identifier: Apache-2.0
// Device functions on words of two or four integers, their dot products, and clamped sums. Plain
// C++, because compilers have no instruction for most.
#ifndef SUNSTONE_SIMD_H
#define SUNSTONE_SIMD_H

#include "intrinsics.h"

namespace sunstone_simd {

// The type for lane arithmetic, which holds every sum and difference.
template <class Lane>
SUNSTONE_DEVICE int lane(unsigned int word, int i) {
    return (Lane)(word >> (i * (int)sizeof(Lane) * 8));
}
template <class Lane>
SUNSTONE_DEVICE unsigned int atLane(int value, int i) {
    constexpr unsigned int kMask = sizeof(Lane) == 1 ? 0xffu : 0xffffu;
    return ((unsigned int)value & kMask) << (i * (int)sizeof(Lane) * 8);
}
template <class Lane, class Operation>
SUNSTONE_DEVICE unsigned int each(unsigned int a, unsigned int b, Operation operation) {
    unsigned int result = 0;
#pragma unroll
    for (int i = 0; i < (int)(4 / sizeof(Lane)); ++i)
        result |= atLane<Lane>(operation(lane<Lane>(a, i), lane<Lane>(b, i)), i);
    return result;
}
template <class Lane, class Operation>
SUNSTONE_DEVICE unsigned int sum(unsigned int a, unsigned int b, Operation operation) {
    unsigned int result = 0;
#pragma unroll
    for (int i = 0; i < (int)(4 / sizeof(Lane)); ++i)
        result += (unsigned int)operation(lane<Lane>(a, i), lane<Lane>(b, i));
    return result;
}
template <class Lane>
SUNSTONE_DEVICE int limited(int x) {
    constexpr int kLargest = (Lane)-1 < (Lane)0 ? (1 << (sizeof(Lane) * 8 - 1)) - 1
                                                : (1 << (sizeof(Lane) * 8)) - 1;
    constexpr int kLeast = (Lane)-1 < (Lane)0 ? -kLargest - 1 : 0;
    return x > kLargest ? kLargest : x < kLeast ? kLeast : x;
}

} // namespace sunstone_simd

// S and U: the types of a lane, signed and unsigned; the count of lanes ends each name.
#define SUNSTONE_LANES(name, lanes, T, result)                                                     \
    SUNSTONE_DEVICE unsigned int name##lanes(unsigned int a, unsigned int b) {                     \
        return sunstone_simd::each<T>(a, b, [](int x, int y) -> int { return result; });           \
    }
#define SUNSTONE_UNARY_LANES(name, lanes, T, result)                                               \
    SUNSTONE_DEVICE unsigned int name##lanes(unsigned int a) {                                     \
        return sunstone_simd::each<T>(a, a, [](int x, int) -> int { return result; });             \
    }
#define SUNSTONE_SUM_LANES(name, lanes, T, result)                                                 \
    SUNSTONE_DEVICE unsigned int name##lanes(unsigned int a, unsigned int b) {                     \
        return sunstone_simd::sum<T>(a, b, [](int x, int y) -> int { return result; });            \
    }
#define SUNSTONE_COMPARE_LANES(word, lanes, T, operation)                                          \
    SUNSTONE_LANES(__vcmp##word, lanes, T, x operation y ? -1 : 0)                                 \
    SUNSTONE_LANES(__vset##word, lanes, T, x operation y ? 1 : 0)
#define SUNSTONE_WORDS_OF(lanes, S, U)                                                             \
    SUNSTONE_UNARY_LANES(__vabs, lanes, S, x < 0 ? -x : x)                                         \
    SUNSTONE_UNARY_LANES(__vabsss, lanes, S, sunstone_simd::limited<S>(x < 0 ? -x : x))            \
    SUNSTONE_UNARY_LANES(__vneg, lanes, S, -x)                                                     \
    SUNSTONE_UNARY_LANES(__vnegss, lanes, S, sunstone_simd::limited<S>(-x))                        \
    SUNSTONE_LANES(__vabsdiffs, lanes, S, x > y ? x - y : y - x)                                   \
    SUNSTONE_LANES(__vabsdiffu, lanes, U, x > y ? x - y : y - x)                                   \
    SUNSTONE_LANES(__vadd, lanes, S, x + y)                                                        \
    SUNSTONE_LANES(__vaddss, lanes, S, sunstone_simd::limited<S>(x + y))                           \
    SUNSTONE_LANES(__vaddus, lanes, U, sunstone_simd::limited<U>(x + y))                           \
    SUNSTONE_LANES(__vsub, lanes, S, x - y)                                                        \
    SUNSTONE_LANES(__vsubss, lanes, S, sunstone_simd::limited<S>(x - y))                           \
    SUNSTONE_LANES(__vsubus, lanes, U, sunstone_simd::limited<U>(x - y))                           \
    SUNSTONE_LANES(__vavgs, lanes, S, (x + y + (x + y >= 0 ? 1 : 0)) >> 1)                         \
    SUNSTONE_LANES(__vavgu, lanes, U, (x + y + 1) >> 1)                                            \
    SUNSTONE_LANES(__vhaddu, lanes, U, (x + y) >> 1)                                               \
    SUNSTONE_LANES(__vmaxs, lanes, S, x > y ? x : y)                                               \
    SUNSTONE_LANES(__vmaxu, lanes, U, x > y ? x : y)                                               \
    SUNSTONE_LANES(__vmins, lanes, S, x < y ? x : y)                                               \
    SUNSTONE_LANES(__vminu, lanes, U, x < y ? x : y)                                               \
    SUNSTONE_SUM_LANES(__vsads, lanes, S, x > y ? x - y : y - x)                                   \
    SUNSTONE_SUM_LANES(__vsadu, lanes, U, x > y ? x - y : y - x)                                   \
    SUNSTONE_COMPARE_LANES(eq, lanes, S, ==)                                                       \
    SUNSTONE_COMPARE_LANES(ne, lanes, S, !=)                                                       \
    SUNSTONE_COMPARE_LANES(ges, lanes, S, >=)                                                      \
    SUNSTONE_COMPARE_LANES(gts, lanes, S, >)                                                       \
    SUNSTONE_COMPARE_LANES(les, lanes, S, <=)                                                      \
    SUNSTONE_COMPARE_LANES(lts, lanes, S, <)                                                       \
    SUNSTONE_COMPARE_LANES(geu, lanes, U, >=)                                                      \
    SUNSTONE_COMPARE_LANES(gtu, lanes, U, >)                                                       \
    SUNSTONE_COMPARE_LANES(leu, lanes, U, <=)                                                      \
    SUNSTONE_COMPARE_LANES(ltu, lanes, U, <)
SUNSTONE_WORDS_OF(2, short, unsigned short)
SUNSTONE_WORDS_OF(4, signed char, unsigned char)
#undef SUNSTONE_WORDS_OF
#undef SUNSTONE_LANES
#undef SUNSTONE_UNARY_LANES
#undef SUNSTONE_SUM_LANES
#undef SUNSTONE_COMPARE_LANES

// ---- clamped sums, maximum and minimum of two or three -----------------------------------------
SUNSTONE_DEVICE int __sunstone_largest(int a, int b) { return a > b ? a : b; }
SUNSTONE_DEVICE int __sunstone_least(int a, int b) { return a < b ? a : b; }
SUNSTONE_DEVICE unsigned int __sunstone_largest(unsigned int a, unsigned int b) { return a > b ? a : b; }
SUNSTONE_DEVICE unsigned int __sunstone_least(unsigned int a, unsigned int b) { return a < b ? a : b; }
#define SUNSTONE_LIMITS(stem, of, ofPairs, comparison)                                             \
    SUNSTONE_DEVICE int __viadd##stem##_s32(int a, int b, int c) {                                 \
        return of((int)((unsigned int)a + (unsigned int)b), c);                                    \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __viadd##stem##_u32(unsigned int a, unsigned int b,               \
                                                     unsigned int c) {                             \
        return of(a + b, c);                                                                       \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __viadd##stem##_s16x2(unsigned int a, unsigned int b,             \
                                                       unsigned int c) {                           \
        return ofPairs##s2(__vadd2(a, b), c);                                                      \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __viadd##stem##_u16x2(unsigned int a, unsigned int b,             \
                                                       unsigned int c) {                           \
        return ofPairs##u2(__vadd2(a, b), c);                                                      \
    }                                                                                              \
    SUNSTONE_DEVICE int __viadd##stem##_s32_relu(int a, int b, int c) {                            \
        return __sunstone_largest(__viadd##stem##_s32(a, b, c), 0);                                \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __viadd##stem##_s16x2_relu(unsigned int a, unsigned int b,        \
                                                            unsigned int c) {                      \
        return __vmaxs2(__viadd##stem##_s16x2(a, b, c), 0);                                        \
    }                                                                                              \
    SUNSTONE_DEVICE int __vi##stem##3_s32(int a, int b, int c) { return of(of(a, b), c); }         \
    SUNSTONE_DEVICE unsigned int __vi##stem##3_u32(unsigned int a, unsigned int b,                 \
                                                   unsigned int c) {                               \
        return of(of(a, b), c);                                                                    \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __vi##stem##3_s16x2(unsigned int a, unsigned int b,               \
                                                     unsigned int c) {                             \
        return ofPairs##s2(ofPairs##s2(a, b), c);                                                  \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __vi##stem##3_u16x2(unsigned int a, unsigned int b,               \
                                                     unsigned int c) {                             \
        return ofPairs##u2(ofPairs##u2(a, b), c);                                                  \
    }                                                                                              \
    SUNSTONE_DEVICE int __vi##stem##3_s32_relu(int a, int b, int c) {                              \
        return __sunstone_largest(of(of(a, b), c), 0);                                             \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __vi##stem##3_s16x2_relu(unsigned int a, unsigned int b,          \
                                                          unsigned int c) {                        \
        return __vmaxs2(__vi##stem##3_s16x2(a, b, c), 0);                                          \
    }                                                                                              \
    SUNSTONE_DEVICE int __vi##stem##_s32_relu(int a, int b) {                                      \
        return __sunstone_largest(of(a, b), 0);                                                    \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __vi##stem##_s16x2_relu(unsigned int a, unsigned int b) {         \
        return __vmaxs2(ofPairs##s2(a, b), 0);                                                     \
    }                                                                                              \
    SUNSTONE_DEVICE int __vib##stem##_s32(int a, int b, bool* first) {                             \
        *first = a comparison b;                                                                   \
        return of(a, b);                                                                           \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __vib##stem##_u32(unsigned int a, unsigned int b, bool* first) {  \
        *first = a comparison b;                                                                   \
        return of(a, b);                                                                           \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __vib##stem##_s16x2(unsigned int a, unsigned int b, bool* high,   \
                                                     bool* low) {                                  \
        *high = (short)(a >> 16) comparison(short)(b >> 16);                                       \
        *low = (short)a comparison(short) b;                                                       \
        return ofPairs##s2(a, b);                                                                  \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __vib##stem##_u16x2(unsigned int a, unsigned int b, bool* high,   \
                                                     bool* low) {                                  \
        *high = (unsigned short)(a >> 16) comparison(unsigned short)(b >> 16);                     \
        *low = (unsigned short)a comparison(unsigned short) b;                                     \
        return ofPairs##u2(a, b);                                                                  \
    }
SUNSTONE_LIMITS(max, __sunstone_largest, __vmax, >=)
SUNSTONE_LIMITS(min, __sunstone_least, __vmin, <=)
#undef SUNSTONE_LIMITS

// ---- dot products -----------------------------------------------------------------------------------
#define SUNSTONE_DOT(name, opcode, T, A, B)                                                       \
    SUNSTONE_DEVICE T name(T a, T b, T c) {                                                        \
        T result;                                                                                  \
        asm(opcode " %0, %1, %2, %3;" : "=r"(result) : "r"(a), "r"(b), "r"(c));                    \
        return result;                                                                             \
    }                                                                                              \
    SUNSTONE_DEVICE T name(A a, B b, T c) {                                                        \
        return name(__builtin_bit_cast(T, a), __builtin_bit_cast(T, b), c);                        \
    }
SUNSTONE_DOT(__dp4a, "dp4a.s32.s32", int, char4, char4)
SUNSTONE_DOT(__dp4a, "dp4a.u32.u32", unsigned int, uchar4, uchar4)
SUNSTONE_DOT(__dp2a_lo, "dp2a.lo.s32.s32", int, short2, char4)
SUNSTONE_DOT(__dp2a_hi, "dp2a.hi.s32.s32", int, short2, char4)
SUNSTONE_DOT(__dp2a_lo, "dp2a.lo.u32.u32", unsigned int, ushort2, uchar4)
SUNSTONE_DOT(__dp2a_hi, "dp2a.hi.u32.u32", unsigned int, ushort2, uchar4)
#undef SUNSTONE_DOT

#endif
