// SPDX-License-Identifier: Apache-2.0
// Atomic functions of device code: relaxed order; device scope, _block and _system variants.
#ifndef SUNSTONE_ATOMICS_H
#define SUNSTONE_ATOMICS_H

#include "intrinsics.h"

// Defines name##suffix: op is the instruction's operation and type, r the constraint of its
// operands. A generic atom instruction names no address space, so p may point to any space.
#define SUNSTONE_ATOMIC_IN(name, suffix, scope, T, op, r)                                          \
    SUNSTONE_DEVICE T name##suffix(T* p, T v) {                                                    \
        T old;                                                                                     \
        asm volatile("atom" scope "." op " %0, [%1], %2;" : "=" r(old) : "l"(p), r(v) : "memory"); \
        return old;                                                                                \
    }
#define SUNSTONE_CAS_IN(suffix, scope, T, type, r)                                                 \
    SUNSTONE_DEVICE T atomicCAS##suffix(T* p, T compare, T v) {                                    \
        T old;                                                                                     \
        asm volatile("atom" scope ".cas." type " %0, [%1], %2, %3;"                                \
                     : "=" r(old)                                                                  \
                     : "l"(p), r(compare), r(v)                                                    \
                     : "memory");                                                                  \
        return old;                                                                                \
    }
#define SUNSTONE_ATOMIC(name, T, op, r)                                                            \
    SUNSTONE_ATOMIC_IN(name, , "", T, op, r)                                                       \
    SUNSTONE_ATOMIC_IN(name, _block, ".cta", T, op, r)                                             \
    SUNSTONE_ATOMIC_IN(name, _system, ".sys", T, op, r)
#define SUNSTONE_CAS(T, type, r)                                                                   \
    SUNSTONE_CAS_IN(, "", T, type, r)                                                              \
    SUNSTONE_CAS_IN(_block, ".cta", T, type, r)                                                    \
    SUNSTONE_CAS_IN(_system, ".sys", T, type, r)
#define SUNSTONE_MIN_MAX(name, op)                                                                 \
    SUNSTONE_ATOMIC(name, int, op ".s32", "r")                                                     \
    SUNSTONE_ATOMIC(name, unsigned int, op ".u32", "r")                                            \
    SUNSTONE_ATOMIC(name, long long, op ".s64", "l")                                               \
    SUNSTONE_ATOMIC(name, unsigned long long, op ".u64", "l")
#define SUNSTONE_BITWISE(name, op)                                                                 \
    SUNSTONE_ATOMIC(name, int, op ".b32", "r")                                                     \
    SUNSTONE_ATOMIC(name, unsigned int, op ".b32", "r")                                            \
    SUNSTONE_ATOMIC(name, unsigned long long, op ".b64", "l")

SUNSTONE_ATOMIC(atomicAdd, int, "add.s32", "r")
SUNSTONE_ATOMIC(atomicAdd, unsigned int, "add.u32", "r")
SUNSTONE_ATOMIC(atomicAdd, unsigned long long, "add.u64", "l")
SUNSTONE_ATOMIC(atomicAdd, float, "add.f32", "f")
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 600
SUNSTONE_ATOMIC(atomicAdd, double, "add.f64", "d")
#endif
SUNSTONE_MIN_MAX(atomicMin, "min")
SUNSTONE_MIN_MAX(atomicMax, "max")
SUNSTONE_BITWISE(atomicAnd, "and")
SUNSTONE_BITWISE(atomicOr, "or")
SUNSTONE_BITWISE(atomicXor, "xor")
SUNSTONE_BITWISE(atomicExch, "exch")
SUNSTONE_ATOMIC(atomicInc, unsigned int, "inc.u32", "r")
SUNSTONE_ATOMIC(atomicDec, unsigned int, "dec.u32", "r")
SUNSTONE_CAS(int, "b32", "r")
SUNSTONE_CAS(unsigned int, "b32", "r")
SUNSTONE_CAS(unsigned long long, "b64", "l")
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 700
SUNSTONE_CAS(unsigned short, "b16", "h")
#endif

// PTX has no atomic subtraction and no exchange of floats.
#define SUNSTONE_DERIVED_ATOMICS(suffix)                                                           \
    SUNSTONE_DEVICE float atomicExch##suffix(float* p, float v) {                                  \
        return __uint_as_float(atomicExch##suffix((unsigned int*)p, __float_as_uint(v)));          \
    }                                                                                              \
    SUNSTONE_DEVICE int atomicSub##suffix(int* p, int v) {                                         \
        return atomicAdd##suffix(p, int(0u - unsigned(v)));                                        \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int atomicSub##suffix(unsigned int* p, unsigned int v) {              \
        return atomicAdd##suffix(p, 0u - v);                                                       \
    }
SUNSTONE_DERIVED_ATOMICS()
SUNSTONE_DERIVED_ATOMICS(_block)
SUNSTONE_DERIVED_ATOMICS(_system)

#undef SUNSTONE_DERIVED_ATOMICS
#undef SUNSTONE_BITWISE
#undef SUNSTONE_MIN_MAX
#undef SUNSTONE_CAS
#undef SUNSTONE_ATOMIC
#undef SUNSTONE_CAS_IN
#undef SUNSTONE_ATOMIC_IN

// Any type of 16 bytes with 16-byte alignment, on sm_90 and later.
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 900
#ifdef __cplusplus
template <bool is, class T>
struct __sunstone_if_wide {};
template <class T>
struct __sunstone_if_wide<true, T> {
    typedef T type;
};
#define SUNSTONE_WIDE(T)                                                                           \
    typename __sunstone_if_wide<sizeof(T) == 16 && alignof(T) >= 16 && __is_trivially_copyable(T), \
                                T>::type
#define SUNSTONE_WIDE_ATOMICS(suffix, scope)                                                       \
    template <class T>                                                                             \
    SUNSTONE_DEVICE SUNSTONE_WIDE(T) atomicExch##suffix(T* p, T v) {                               \
        unsigned long long in[2], out[2];                                                          \
        __builtin_memcpy(in, &v, 16);                                                              \
        asm volatile("{ .reg .b128 v, old; mov.b128 v, {%3, %4}; "                                 \
                     "atom" scope ".exch.b128 old, [%2], v; mov.b128 {%0, %1}, old; }"             \
                     : "=l"(out[0]), "=l"(out[1])                                                  \
                     : "l"(p), "l"(in[0]), "l"(in[1])                                              \
                     : "memory");                                                                  \
        __builtin_memcpy(&v, out, 16);                                                             \
        return v;                                                                                  \
    }                                                                                              \
    template <class T>                                                                             \
    SUNSTONE_DEVICE SUNSTONE_WIDE(T) atomicCAS##suffix(T* p, T compare, T v) {                     \
        unsigned long long in[4], out[2];                                                          \
        __builtin_memcpy(in, &compare, 16);                                                        \
        __builtin_memcpy(in + 2, &v, 16);                                                          \
        asm volatile("{ .reg .b128 c, v, old; mov.b128 c, {%3, %4}; mov.b128 v, {%5, %6}; "        \
                     "atom" scope ".cas.b128 old, [%2], c, v; mov.b128 {%0, %1}, old; }"           \
                     : "=l"(out[0]), "=l"(out[1])                                                  \
                     : "l"(p), "l"(in[0]), "l"(in[1]), "l"(in[2]), "l"(in[3])                      \
                     : "memory");                                                                  \
        __builtin_memcpy(&v, out, 16);                                                             \
        return v;                                                                                  \
    }
SUNSTONE_WIDE_ATOMICS(, "")
SUNSTONE_WIDE_ATOMICS(_block, ".cta")
SUNSTONE_WIDE_ATOMICS(_system, ".sys")
#undef SUNSTONE_WIDE_ATOMICS
#undef SUNSTONE_WIDE
#endif
#endif

// The elements are added separately.
SUNSTONE_DEVICE float2 atomicAdd(float2* p, float2 v) {
    float2 old;
    old.x = atomicAdd(&p->x, v.x);
    old.y = atomicAdd(&p->y, v.y);
    return old;
}
SUNSTONE_DEVICE float4 atomicAdd(float4* p, float4 v) {
    float4 old;
    old.x = atomicAdd(&p->x, v.x);
    old.y = atomicAdd(&p->y, v.y);
    old.z = atomicAdd(&p->z, v.z);
    old.w = atomicAdd(&p->w, v.w);
    return old;
}

#endif
