// SPDX-License-Identifier: Apache-2.0
// Device intrinsics of one instruction each: bit casts, arithmetic with explicit rounding,
// conversions, bit operations, cached loads, clocks. Read next: warp.h, atomics.h, math.h.
#ifndef SUNSTONE_INTRINSICS_H
#define SUNSTONE_INTRINSICS_H

#include "../vector_types.h"

#define SUNSTONE_DEVICE static __inline__ __attribute__((always_inline, device))

// ---- bits of floating-point numbers -----------------------------------------------------------
SUNSTONE_DEVICE int __float_as_int(float x) {
    return __builtin_bit_cast(int, x);
}
SUNSTONE_DEVICE unsigned int __float_as_uint(float x) {
    return __builtin_bit_cast(unsigned int, x);
}
SUNSTONE_DEVICE float __int_as_float(int x) {
    return __builtin_bit_cast(float, x);
}
SUNSTONE_DEVICE float __uint_as_float(unsigned int x) {
    return __builtin_bit_cast(float, x);
}
SUNSTONE_DEVICE long long __double_as_longlong(double x) {
    return __builtin_bit_cast(long long, x);
}
SUNSTONE_DEVICE double __longlong_as_double(long long x) {
    return __builtin_bit_cast(double, x);
}
SUNSTONE_DEVICE int __double2hiint(double x) {
    return int(__double_as_longlong(x) >> 32);
}
SUNSTONE_DEVICE int __double2loint(double x) {
    return int(__double_as_longlong(x));
}
SUNSTONE_DEVICE double __hiloint2double(int hi, int lo) {
    return __longlong_as_double(
        (long long)(((unsigned long long)(unsigned)hi << 32) | (unsigned)lo));
}

// ---- arithmetic with a named rounding ---------------------------------------------------------
// Functions of one instruction: r is the asm constraint of type T, f that of type From.
#define SUNSTONE_CONVERT(name, code, T, r, From, f)                                                \
    SUNSTONE_DEVICE T name(From x) {                                                               \
        T result;                                                                                  \
        asm(code " %0, %1;" : "=" r(result) : f(x));                                               \
        return result;                                                                             \
    }
#define SUNSTONE_UNARY(name, code, T, r) SUNSTONE_CONVERT(name, code, T, r, T, r)
#define SUNSTONE_BINARY(name, code, T, r)                                                          \
    SUNSTONE_DEVICE T name(T x, T y) {                                                             \
        T result;                                                                                  \
        asm(code " %0, %1, %2;" : "=" r(result) : r(x), r(y));                                     \
        return result;                                                                             \
    }
#define SUNSTONE_TERNARY(name, code, T, r)                                                         \
    SUNSTONE_DEVICE T name(T x, T y, T z) {                                                        \
        T result;                                                                                  \
        asm(code " %0, %1, %2, %3;" : "=" r(result) : r(x), r(y), r(z));                           \
        return result;                                                                             \
    }

// Every function of one rounding; m is PTX's name of the rounding that CUDA calls mode.
#define SUNSTONE_TO_AND_FROM(integer, T, type, r, mode, m)                                         \
    SUNSTONE_CONVERT(__float2##integer##_##mode, "cvt.r" m "i." type ".f32", T, r, float, "f")     \
    SUNSTONE_CONVERT(__double2##integer##_##mode, "cvt.r" m "i." type ".f64", T, r, double, "d")   \
    SUNSTONE_CONVERT(__##integer##2float_##mode, "cvt.r" m ".f32." type, float, "f", T, r)
#define SUNSTONE_ROUNDED(mode, m)                                                                  \
    SUNSTONE_BINARY(__fadd_##mode, "add.r" m ".f32", float, "f")                                   \
    SUNSTONE_BINARY(__dadd_##mode, "add.r" m ".f64", double, "d")                                  \
    SUNSTONE_BINARY(__fsub_##mode, "sub.r" m ".f32", float, "f")                                   \
    SUNSTONE_BINARY(__dsub_##mode, "sub.r" m ".f64", double, "d")                                  \
    SUNSTONE_BINARY(__fmul_##mode, "mul.r" m ".f32", float, "f")                                   \
    SUNSTONE_BINARY(__dmul_##mode, "mul.r" m ".f64", double, "d")                                  \
    SUNSTONE_BINARY(__fdiv_##mode, "div.r" m ".f32", float, "f")                                   \
    SUNSTONE_BINARY(__ddiv_##mode, "div.r" m ".f64", double, "d")                                  \
    SUNSTONE_TERNARY(__fmaf_##mode, "fma.r" m ".f32", float, "f")                                  \
    SUNSTONE_TERNARY(__fma_##mode, "fma.r" m ".f64", double, "d")                                  \
    SUNSTONE_UNARY(__fsqrt_##mode, "sqrt.r" m ".f32", float, "f")                                  \
    SUNSTONE_UNARY(__dsqrt_##mode, "sqrt.r" m ".f64", double, "d")                                 \
    SUNSTONE_UNARY(__frcp_##mode, "rcp.r" m ".f32", float, "f")                                    \
    SUNSTONE_UNARY(__drcp_##mode, "rcp.r" m ".f64", double, "d")                                   \
    SUNSTONE_TO_AND_FROM(int, int, "s32", "r", mode, m)                                            \
    SUNSTONE_TO_AND_FROM(uint, unsigned int, "u32", "r", mode, m)                                  \
    SUNSTONE_TO_AND_FROM(ll, long long, "s64", "l", mode, m)                                       \
    SUNSTONE_TO_AND_FROM(ull, unsigned long long, "u64", "l", mode, m)                             \
    SUNSTONE_CONVERT(__ll2double_##mode, "cvt.r" m ".f64.s64", double, "d", long long, "l")        \
    SUNSTONE_CONVERT(__ull2double_##mode, "cvt.r" m ".f64.u64", double, "d", unsigned long long,   \
                     "l")                                                                          \
    SUNSTONE_CONVERT(__double2float_##mode, "cvt.r" m ".f32.f64", float, "f", double, "d")
SUNSTONE_ROUNDED(rn, "n")
SUNSTONE_ROUNDED(rz, "z")
SUNSTONE_ROUNDED(ru, "p")
SUNSTONE_ROUNDED(rd, "m")
#undef SUNSTONE_ROUNDED
#undef SUNSTONE_TO_AND_FROM

SUNSTONE_DEVICE double __int2double_rn(int x) {
    return double(x);
}
SUNSTONE_DEVICE double __uint2double_rn(unsigned int x) {
    return double(x);
}
SUNSTONE_UNARY(__frsqrt_rn, "rsqrt.approx.f32", float, "f")
SUNSTONE_UNARY(__saturatef, "cvt.sat.f32.f32", float, "f")

// ---- fast approximations ----------------------------------------------------------------------
SUNSTONE_UNARY(__sinf, "sin.approx.f32", float, "f")
SUNSTONE_UNARY(__cosf, "cos.approx.f32", float, "f")
SUNSTONE_UNARY(__log2f, "lg2.approx.f32", float, "f")
SUNSTONE_UNARY(sunstoneExp2Approx, "ex2.approx.f32", float, "f")
SUNSTONE_BINARY(__fdividef, "div.approx.f32", float, "f")
SUNSTONE_DEVICE float __tanf(float x) {
    return __fdividef(__sinf(x), __cosf(x));
}
SUNSTONE_DEVICE void __sincosf(float x, float* s, float* c) {
    *s = __sinf(x);
    *c = __cosf(x);
}
SUNSTONE_DEVICE float __expf(float x) {
    return sunstoneExp2Approx(x * 1.4426950408889634f);
}
SUNSTONE_DEVICE float __exp10f(float x) {
    return sunstoneExp2Approx(x * 3.3219280948873623f);
}
SUNSTONE_DEVICE float __logf(float x) {
    return __log2f(x) * 0.69314718055994531f;
}
SUNSTONE_DEVICE float __log10f(float x) {
    return __log2f(x) * 0.30102999566398120f;
}
SUNSTONE_DEVICE float __powf(float x, float y) {
    return sunstoneExp2Approx(y * __log2f(x));
}

// ---- integers ---------------------------------------------------------------------------------
SUNSTONE_DEVICE int __clz(int x) {
    return x == 0 ? 32 : __builtin_clz((unsigned)x);
}
SUNSTONE_DEVICE int __clzll(long long x) {
    return x == 0 ? 64 : __builtin_clzll((unsigned long long)x);
}
SUNSTONE_DEVICE int __popc(unsigned int x) {
    return __builtin_popcount(x);
}
SUNSTONE_DEVICE int __popcll(unsigned long long x) {
    return __builtin_popcountll(x);
}
SUNSTONE_DEVICE int __ffs(int x) {
    return __builtin_ffs(x);
}
SUNSTONE_DEVICE int __ffsll(long long x) {
    return __builtin_ffsll(x);
}
SUNSTONE_DEVICE unsigned int __brev(unsigned int x) {
    return __builtin_bitreverse32(x);
}
SUNSTONE_DEVICE unsigned long long __brevll(unsigned long long x) {
    return __builtin_bitreverse64(x);
}
SUNSTONE_DEVICE int __mulhi(int x, int y) {
    return int(((long long)x * y) >> 32);
}
SUNSTONE_DEVICE unsigned int __umulhi(unsigned int x, unsigned int y) {
    return unsigned(((unsigned long long)x * y) >> 32);
}
SUNSTONE_DEVICE long long __mul64hi(long long x, long long y) {
    return __nvvm_mulhi_ll(x, y);
}
SUNSTONE_DEVICE unsigned long long __umul64hi(unsigned long long x, unsigned long long y) {
    return __nvvm_mulhi_ull(x, y);
}
SUNSTONE_DEVICE int __mul24(int x, int y) {
    return __nvvm_mul24_i(x, y);
}
SUNSTONE_DEVICE unsigned int __umul24(unsigned int x, unsigned int y) {
    return __nvvm_mul24_ui(x, y);
}
SUNSTONE_DEVICE unsigned int __sad(int x, int y, unsigned int z) {
    return (x > y ? unsigned(x) - unsigned(y) : unsigned(y) - unsigned(x)) + z;
}
SUNSTONE_DEVICE unsigned int __usad(unsigned int x, unsigned int y, unsigned int z) {
    return (x > y ? x - y : y - x) + z;
}
SUNSTONE_DEVICE int __hadd(int x, int y) {
    return int(((long long)x + y) >> 1);
}
SUNSTONE_DEVICE int __rhadd(int x, int y) {
    return int(((long long)x + y + 1) >> 1);
}
SUNSTONE_DEVICE unsigned int __uhadd(unsigned int x, unsigned int y) {
    return unsigned(((unsigned long long)x + y) >> 1);
}
SUNSTONE_DEVICE unsigned int __urhadd(unsigned int x, unsigned int y) {
    return unsigned(((unsigned long long)x + y + 1) >> 1);
}
SUNSTONE_DEVICE unsigned int __byte_perm(unsigned int x, unsigned int y, unsigned int s) {
    unsigned int r;
    // Three bits select a byte; the fourth, which would replicate its sign, is masked out.
    asm("prmt.b32 %0, %1, %2, %3;" : "=r"(r) : "r"(x), "r"(y), "r"(s & 0x7777));
    return r;
}
SUNSTONE_TERNARY(__funnelshift_l, "shf.l.wrap.b32", unsigned int, "r")
SUNSTONE_TERNARY(__funnelshift_lc, "shf.l.clamp.b32", unsigned int, "r")
SUNSTONE_TERNARY(__funnelshift_r, "shf.r.wrap.b32", unsigned int, "r")
SUNSTONE_TERNARY(__funnelshift_rc, "shf.r.clamp.b32", unsigned int, "r")

// ---- clocks and waiting -----------------------------------------------------------------------
SUNSTONE_DEVICE long long clock64() {
    return __nvvm_read_ptx_sreg_clock64();
}
SUNSTONE_DEVICE int clock() {
    return __nvvm_read_ptx_sreg_clock();
}
SUNSTONE_DEVICE unsigned long long __globaltimer() {
    unsigned long long r;
    asm volatile("mov.u64 %0, %%globaltimer;" : "=l"(r));
    return r;
}
SUNSTONE_DEVICE void __trap() {
    asm volatile("trap;");
}
SUNSTONE_DEVICE void __brkpt() {
    asm volatile("brkpt;");
}
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 700
SUNSTONE_DEVICE void __nanosleep(unsigned int ns) {
    asm volatile("nanosleep.u32 %0;" ::"r"(ns));
}
#endif

// ---- address spaces ---------------------------------------------------------------------------
SUNSTONE_CONVERT(__cvta_generic_to_global, "cvta.to.global.u64", size_t, "l", const void*, "l")
SUNSTONE_CONVERT(__cvta_global_to_generic, "cvta.global.u64", void*, "l", size_t, "l")
SUNSTONE_CONVERT(__cvta_generic_to_shared, "cvta.to.shared.u64", size_t, "l", const void*, "l")
SUNSTONE_CONVERT(__cvta_shared_to_generic, "cvta.shared.u64", void*, "l", size_t, "l")
SUNSTONE_CONVERT(__cvta_generic_to_local, "cvta.to.local.u64", size_t, "l", const void*, "l")
SUNSTONE_CONVERT(__cvta_local_to_generic, "cvta.local.u64", void*, "l", size_t, "l")
SUNSTONE_CONVERT(__cvta_generic_to_constant, "cvta.to.const.u64", size_t, "l", const void*, "l")
SUNSTONE_CONVERT(__cvta_constant_to_generic, "cvta.const.u64", void*, "l", size_t, "l")

#define SUNSTONE_IS_SPACE(name, space)                                                             \
    SUNSTONE_DEVICE unsigned int name(const void* p) {                                             \
        unsigned int r;                                                                            \
        asm("{ .reg .pred p; isspacep." space " p, %1; selp.u32 %0, 1, 0, p; }"                    \
            : "=r"(r)                                                                              \
            : "l"(p));                                                                             \
        return r;                                                                                  \
    }
SUNSTONE_IS_SPACE(__isGlobal, "global")
SUNSTONE_IS_SPACE(__isShared, "shared")
SUNSTONE_IS_SPACE(__isLocal, "local")
SUNSTONE_IS_SPACE(__isConstant, "const")

#undef SUNSTONE_IS_SPACE
#undef SUNSTONE_TERNARY
#undef SUNSTONE_BINARY
#undef SUNSTONE_UNARY
#undef SUNSTONE_CONVERT

#endif
