// SPDX-License-Identifier: Apache-2.0
// Loads and stores with a cache hint. Hints do not change results; __ldg requires data that does
// not change while the kernel runs.
#ifndef SUNSTONE_CACHED_LOADS_H
#define SUNSTONE_CACHED_LOADS_H

#include "intrinsics.h"

#define SUNSTONE_LOAD(name, mode, T, type, letter)                                                 \
    SUNSTONE_DEVICE T name(const T* p) {                                                           \
        T r;                                                                                       \
        asm volatile("ld." mode "." type " %0, [%1];" : "=" letter(r) : "l"(p) : "memory");        \
        return r;                                                                                  \
    }
#define SUNSTONE_LOAD_BYTE(name, mode, T, type, R)                                                 \
    SUNSTONE_DEVICE T name(const T* p) {                                                           \
        R r;                                                                                       \
        asm volatile("ld." mode "." type " %0, [%1];" : "=h"(r) : "l"(p) : "memory");              \
        return (T)r;                                                                               \
    }
#define SUNSTONE_LOAD2(name, mode, T, type, letter)                                                \
    SUNSTONE_DEVICE T name(const T* p) {                                                           \
        T r;                                                                                       \
        asm volatile("ld." mode ".v2." type " {%0, %1}, [%2];"                                     \
                     : "=" letter(r.x), "=" letter(r.y)                                            \
                     : "l"(p)                                                                      \
                     : "memory");                                                                  \
        return r;                                                                                  \
    }
#define SUNSTONE_LOAD4(name, mode, T, type, letter)                                                \
    SUNSTONE_DEVICE T name(const T* p) {                                                           \
        T r;                                                                                       \
        asm volatile("ld." mode ".v4." type " {%0, %1, %2, %3}, [%4];"                             \
                     : "=" letter(r.x), "=" letter(r.y), "=" letter(r.z), "=" letter(r.w)          \
                     : "l"(p)                                                                      \
                     : "memory");                                                                  \
        return r;                                                                                  \
    }
#define SUNSTONE_LOAD_AS(name, T, R)                                                               \
    SUNSTONE_DEVICE T name(const T* p) {                                                           \
        return __builtin_bit_cast(T, name((const R*)p));                                           \
    }
#define SUNSTONE_LOADS(name, mode)                                                                 \
    SUNSTONE_LOAD(name, mode, float, "f32", "f")                                                   \
    SUNSTONE_LOAD(name, mode, double, "f64", "d")                                                  \
    SUNSTONE_LOAD(name, mode, int, "s32", "r")                                                     \
    SUNSTONE_LOAD(name, mode, unsigned int, "u32", "r")                                            \
    SUNSTONE_LOAD(name, mode, short, "s16", "h")                                                   \
    SUNSTONE_LOAD(name, mode, unsigned short, "u16", "h")                                          \
    SUNSTONE_LOAD(name, mode, long long, "s64", "l")                                               \
    SUNSTONE_LOAD(name, mode, unsigned long long, "u64", "l")                                      \
    SUNSTONE_LOAD(name, mode, long, "s64", "l")                                                    \
    SUNSTONE_LOAD(name, mode, unsigned long, "u64", "l")                                           \
    SUNSTONE_LOAD_BYTE(name, mode, char, "s8", short)                                              \
    SUNSTONE_LOAD_BYTE(name, mode, signed char, "s8", short)                                       \
    SUNSTONE_LOAD_BYTE(name, mode, unsigned char, "u8", unsigned short)                            \
    SUNSTONE_LOAD2(name, mode, float2, "f32", "f")                                                 \
    SUNSTONE_LOAD2(name, mode, int2, "s32", "r")                                                   \
    SUNSTONE_LOAD2(name, mode, uint2, "u32", "r")                                                  \
    SUNSTONE_LOAD2(name, mode, short2, "s16", "h")                                                 \
    SUNSTONE_LOAD2(name, mode, ushort2, "u16", "h")                                                \
    SUNSTONE_LOAD2(name, mode, double2, "f64", "d")                                                \
    SUNSTONE_LOAD2(name, mode, longlong2, "s64", "l")                                              \
    SUNSTONE_LOAD2(name, mode, ulonglong2, "u64", "l")                                             \
    SUNSTONE_LOAD4(name, mode, float4, "f32", "f")                                                 \
    SUNSTONE_LOAD4(name, mode, int4, "s32", "r")                                                   \
    SUNSTONE_LOAD4(name, mode, uint4, "u32", "r")                                                  \
    SUNSTONE_LOAD4(name, mode, short4, "s16", "h")                                                 \
    SUNSTONE_LOAD4(name, mode, ushort4, "u16", "h")                                                \
    SUNSTONE_LOAD_AS(name, uchar4, unsigned int)                                                   \
    SUNSTONE_LOAD_AS(name, char4, unsigned int)                                                    \
    SUNSTONE_LOAD_AS(name, uchar2, unsigned short)                                                 \
    SUNSTONE_LOAD_AS(name, char2, unsigned short)
SUNSTONE_LOADS(__ldg, "global.nc")
SUNSTONE_LOADS(__ldca, "global.ca")
SUNSTONE_LOADS(__ldcg, "global.cg")
SUNSTONE_LOADS(__ldcs, "global.cs")
SUNSTONE_LOADS(__ldlu, "global.lu")
SUNSTONE_LOADS(__ldcv, "global.cv")

#define SUNSTONE_STORE(name, mode, T, type, letter)                                                \
    SUNSTONE_DEVICE void name(T* p, T v) {                                                         \
        asm volatile("st." mode "." type " [%0], %1;" ::"l"(p), letter(v) : "memory");             \
    }
#define SUNSTONE_STORE2(name, mode, T, type, letter)                                               \
    SUNSTONE_DEVICE void name(T* p, T v) {                                                         \
        asm volatile("st." mode ".v2." type " [%0], {%1, %2};" ::"l"(p), letter(v.x), letter(v.y)  \
                     : "memory");                                                                  \
    }
#define SUNSTONE_STORE4(name, mode, T, type, letter)                                               \
    SUNSTONE_DEVICE void name(T* p, T v) {                                                         \
        asm volatile("st." mode ".v4." type " [%0], {%1, %2, %3, %4};" ::"l"(p), letter(v.x),      \
                     letter(v.y), letter(v.z), letter(v.w)                                         \
                     : "memory");                                                                  \
    }
#define SUNSTONE_STORES(name, mode)                                                                \
    SUNSTONE_STORE(name, mode, float, "f32", "f")                                                  \
    SUNSTONE_STORE(name, mode, double, "f64", "d")                                                 \
    SUNSTONE_STORE(name, mode, int, "s32", "r")                                                    \
    SUNSTONE_STORE(name, mode, unsigned int, "u32", "r")                                           \
    SUNSTONE_STORE(name, mode, short, "s16", "h")                                                  \
    SUNSTONE_STORE(name, mode, unsigned short, "u16", "h")                                         \
    SUNSTONE_STORE(name, mode, long long, "s64", "l")                                              \
    SUNSTONE_STORE(name, mode, unsigned long long, "u64", "l")                                     \
    SUNSTONE_STORE(name, mode, long, "s64", "l")                                                   \
    SUNSTONE_STORE(name, mode, unsigned long, "u64", "l")                                          \
    SUNSTONE_STORE2(name, mode, float2, "f32", "f")                                                \
    SUNSTONE_STORE2(name, mode, int2, "s32", "r")                                                  \
    SUNSTONE_STORE2(name, mode, uint2, "u32", "r")                                                 \
    SUNSTONE_STORE2(name, mode, short2, "s16", "h")                                                \
    SUNSTONE_STORE2(name, mode, ushort2, "u16", "h")                                               \
    SUNSTONE_STORE2(name, mode, double2, "f64", "d")                                               \
    SUNSTONE_STORE2(name, mode, longlong2, "s64", "l")                                             \
    SUNSTONE_STORE2(name, mode, ulonglong2, "u64", "l")                                            \
    SUNSTONE_STORE4(name, mode, float4, "f32", "f")                                                \
    SUNSTONE_STORE4(name, mode, int4, "s32", "r")                                                  \
    SUNSTONE_STORE4(name, mode, uint4, "u32", "r")                                                 \
    SUNSTONE_STORE4(name, mode, short4, "s16", "h")                                                \
    SUNSTONE_STORE4(name, mode, ushort4, "u16", "h")
SUNSTONE_STORES(__stwb, "global.wb")
SUNSTONE_STORES(__stcg, "global.cg")
SUNSTONE_STORES(__stcs, "global.cs")
SUNSTONE_STORES(__stwt, "global.wt")
#undef SUNSTONE_LOAD
#undef SUNSTONE_LOAD_BYTE
#undef SUNSTONE_LOAD2
#undef SUNSTONE_LOAD4
#undef SUNSTONE_LOAD_AS
#undef SUNSTONE_LOADS
#undef SUNSTONE_STORE
#undef SUNSTONE_STORE2
#undef SUNSTONE_STORE4
#undef SUNSTONE_STORES

#endif
