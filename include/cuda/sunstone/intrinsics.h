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
SUNSTONE_DEVICE float __fadd_rn(float x, float y) {
    float r;
    asm("add.rn.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dadd_rn(double x, double y) {
    double r;
    asm("add.rn.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fsub_rn(float x, float y) {
    float r;
    asm("sub.rn.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dsub_rn(double x, double y) {
    double r;
    asm("sub.rn.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmul_rn(float x, float y) {
    float r;
    asm("mul.rn.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dmul_rn(double x, double y) {
    double r;
    asm("mul.rn.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fdiv_rn(float x, float y) {
    float r;
    asm("div.rn.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __ddiv_rn(double x, double y) {
    double r;
    asm("div.rn.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmaf_rn(float x, float y, float z) {
    float r;
    asm("fma.rn.f32 %0, %1, %2, %3;" : "=f"(r) : "f"(x), "f"(y), "f"(z));
    return r;
}
SUNSTONE_DEVICE double __fma_rn(double x, double y, double z) {
    double r;
    asm("fma.rn.f64 %0, %1, %2, %3;" : "=d"(r) : "d"(x), "d"(y), "d"(z));
    return r;
}
SUNSTONE_DEVICE float __fsqrt_rn(float x) {
    float r;
    asm("sqrt.rn.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __dsqrt_rn(double x) {
    double r;
    asm("sqrt.rn.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __frcp_rn(float x) {
    float r;
    asm("rcp.rn.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __drcp_rn(double x) {
    double r;
    asm("rcp.rn.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE int __float2int_rn(float x) {
    int r;
    asm("cvt.rni.s32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE int __double2int_rn(double x) {
    int r;
    asm("cvt.rni.s32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __int2float_rn(int x) {
    float r;
    asm("cvt.rn.f32.s32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __float2uint_rn(float x) {
    unsigned int r;
    asm("cvt.rni.u32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __double2uint_rn(double x) {
    unsigned int r;
    asm("cvt.rni.u32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __uint2float_rn(unsigned int x) {
    float r;
    asm("cvt.rn.f32.u32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE long long __float2ll_rn(float x) {
    long long r;
    asm("cvt.rni.s64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE long long __double2ll_rn(double x) {
    long long r;
    asm("cvt.rni.s64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ll2float_rn(long long x) {
    float r;
    asm("cvt.rn.f32.s64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ll2double_rn(long long x) {
    double r;
    asm("cvt.rn.f64.s64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __float2ull_rn(float x) {
    unsigned long long r;
    asm("cvt.rni.u64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __double2ull_rn(double x) {
    unsigned long long r;
    asm("cvt.rni.u64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ull2float_rn(unsigned long long x) {
    float r;
    asm("cvt.rn.f32.u64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ull2double_rn(unsigned long long x) {
    double r;
    asm("cvt.rn.f64.u64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE float __double2float_rn(double x) {
    float r;
    asm("cvt.rn.f32.f64 %0, %1;" : "=f"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __fadd_rz(float x, float y) {
    float r;
    asm("add.rz.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dadd_rz(double x, double y) {
    double r;
    asm("add.rz.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fsub_rz(float x, float y) {
    float r;
    asm("sub.rz.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dsub_rz(double x, double y) {
    double r;
    asm("sub.rz.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmul_rz(float x, float y) {
    float r;
    asm("mul.rz.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dmul_rz(double x, double y) {
    double r;
    asm("mul.rz.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fdiv_rz(float x, float y) {
    float r;
    asm("div.rz.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __ddiv_rz(double x, double y) {
    double r;
    asm("div.rz.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmaf_rz(float x, float y, float z) {
    float r;
    asm("fma.rz.f32 %0, %1, %2, %3;" : "=f"(r) : "f"(x), "f"(y), "f"(z));
    return r;
}
SUNSTONE_DEVICE double __fma_rz(double x, double y, double z) {
    double r;
    asm("fma.rz.f64 %0, %1, %2, %3;" : "=d"(r) : "d"(x), "d"(y), "d"(z));
    return r;
}
SUNSTONE_DEVICE float __fsqrt_rz(float x) {
    float r;
    asm("sqrt.rz.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __dsqrt_rz(double x) {
    double r;
    asm("sqrt.rz.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __frcp_rz(float x) {
    float r;
    asm("rcp.rz.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __drcp_rz(double x) {
    double r;
    asm("rcp.rz.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE int __float2int_rz(float x) {
    int r;
    asm("cvt.rzi.s32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE int __double2int_rz(double x) {
    int r;
    asm("cvt.rzi.s32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __int2float_rz(int x) {
    float r;
    asm("cvt.rz.f32.s32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __float2uint_rz(float x) {
    unsigned int r;
    asm("cvt.rzi.u32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __double2uint_rz(double x) {
    unsigned int r;
    asm("cvt.rzi.u32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __uint2float_rz(unsigned int x) {
    float r;
    asm("cvt.rz.f32.u32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE long long __float2ll_rz(float x) {
    long long r;
    asm("cvt.rzi.s64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE long long __double2ll_rz(double x) {
    long long r;
    asm("cvt.rzi.s64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ll2float_rz(long long x) {
    float r;
    asm("cvt.rz.f32.s64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ll2double_rz(long long x) {
    double r;
    asm("cvt.rz.f64.s64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __float2ull_rz(float x) {
    unsigned long long r;
    asm("cvt.rzi.u64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __double2ull_rz(double x) {
    unsigned long long r;
    asm("cvt.rzi.u64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ull2float_rz(unsigned long long x) {
    float r;
    asm("cvt.rz.f32.u64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ull2double_rz(unsigned long long x) {
    double r;
    asm("cvt.rz.f64.u64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE float __double2float_rz(double x) {
    float r;
    asm("cvt.rz.f32.f64 %0, %1;" : "=f"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __fadd_ru(float x, float y) {
    float r;
    asm("add.rp.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dadd_ru(double x, double y) {
    double r;
    asm("add.rp.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fsub_ru(float x, float y) {
    float r;
    asm("sub.rp.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dsub_ru(double x, double y) {
    double r;
    asm("sub.rp.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmul_ru(float x, float y) {
    float r;
    asm("mul.rp.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dmul_ru(double x, double y) {
    double r;
    asm("mul.rp.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fdiv_ru(float x, float y) {
    float r;
    asm("div.rp.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __ddiv_ru(double x, double y) {
    double r;
    asm("div.rp.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmaf_ru(float x, float y, float z) {
    float r;
    asm("fma.rp.f32 %0, %1, %2, %3;" : "=f"(r) : "f"(x), "f"(y), "f"(z));
    return r;
}
SUNSTONE_DEVICE double __fma_ru(double x, double y, double z) {
    double r;
    asm("fma.rp.f64 %0, %1, %2, %3;" : "=d"(r) : "d"(x), "d"(y), "d"(z));
    return r;
}
SUNSTONE_DEVICE float __fsqrt_ru(float x) {
    float r;
    asm("sqrt.rp.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __dsqrt_ru(double x) {
    double r;
    asm("sqrt.rp.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __frcp_ru(float x) {
    float r;
    asm("rcp.rp.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __drcp_ru(double x) {
    double r;
    asm("rcp.rp.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE int __float2int_ru(float x) {
    int r;
    asm("cvt.rpi.s32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE int __double2int_ru(double x) {
    int r;
    asm("cvt.rpi.s32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __int2float_ru(int x) {
    float r;
    asm("cvt.rp.f32.s32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __float2uint_ru(float x) {
    unsigned int r;
    asm("cvt.rpi.u32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __double2uint_ru(double x) {
    unsigned int r;
    asm("cvt.rpi.u32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __uint2float_ru(unsigned int x) {
    float r;
    asm("cvt.rp.f32.u32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE long long __float2ll_ru(float x) {
    long long r;
    asm("cvt.rpi.s64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE long long __double2ll_ru(double x) {
    long long r;
    asm("cvt.rpi.s64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ll2float_ru(long long x) {
    float r;
    asm("cvt.rp.f32.s64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ll2double_ru(long long x) {
    double r;
    asm("cvt.rp.f64.s64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __float2ull_ru(float x) {
    unsigned long long r;
    asm("cvt.rpi.u64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __double2ull_ru(double x) {
    unsigned long long r;
    asm("cvt.rpi.u64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ull2float_ru(unsigned long long x) {
    float r;
    asm("cvt.rp.f32.u64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ull2double_ru(unsigned long long x) {
    double r;
    asm("cvt.rp.f64.u64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE float __double2float_ru(double x) {
    float r;
    asm("cvt.rp.f32.f64 %0, %1;" : "=f"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __fadd_rd(float x, float y) {
    float r;
    asm("add.rm.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dadd_rd(double x, double y) {
    double r;
    asm("add.rm.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fsub_rd(float x, float y) {
    float r;
    asm("sub.rm.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dsub_rd(double x, double y) {
    double r;
    asm("sub.rm.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmul_rd(float x, float y) {
    float r;
    asm("mul.rm.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __dmul_rd(double x, double y) {
    double r;
    asm("mul.rm.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fdiv_rd(float x, float y) {
    float r;
    asm("div.rm.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
SUNSTONE_DEVICE double __ddiv_rd(double x, double y) {
    double r;
    asm("div.rm.f64 %0, %1, %2;" : "=d"(r) : "d"(x), "d"(y));
    return r;
}
SUNSTONE_DEVICE float __fmaf_rd(float x, float y, float z) {
    float r;
    asm("fma.rm.f32 %0, %1, %2, %3;" : "=f"(r) : "f"(x), "f"(y), "f"(z));
    return r;
}
SUNSTONE_DEVICE double __fma_rd(double x, double y, double z) {
    double r;
    asm("fma.rm.f64 %0, %1, %2, %3;" : "=d"(r) : "d"(x), "d"(y), "d"(z));
    return r;
}
SUNSTONE_DEVICE float __fsqrt_rd(float x) {
    float r;
    asm("sqrt.rm.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __dsqrt_rd(double x) {
    double r;
    asm("sqrt.rm.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __frcp_rd(float x) {
    float r;
    asm("rcp.rm.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE double __drcp_rd(double x) {
    double r;
    asm("rcp.rm.f64 %0, %1;" : "=d"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE int __float2int_rd(float x) {
    int r;
    asm("cvt.rmi.s32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE int __double2int_rd(double x) {
    int r;
    asm("cvt.rmi.s32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __int2float_rd(int x) {
    float r;
    asm("cvt.rm.f32.s32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __float2uint_rd(float x) {
    unsigned int r;
    asm("cvt.rmi.u32.f32 %0, %1;" : "=r"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned int __double2uint_rd(double x) {
    unsigned int r;
    asm("cvt.rmi.u32.f64 %0, %1;" : "=r"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __uint2float_rd(unsigned int x) {
    float r;
    asm("cvt.rm.f32.u32 %0, %1;" : "=f"(r) : "r"(x));
    return r;
}
SUNSTONE_DEVICE long long __float2ll_rd(float x) {
    long long r;
    asm("cvt.rmi.s64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE long long __double2ll_rd(double x) {
    long long r;
    asm("cvt.rmi.s64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ll2float_rd(long long x) {
    float r;
    asm("cvt.rm.f32.s64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ll2double_rd(long long x) {
    double r;
    asm("cvt.rm.f64.s64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __float2ull_rd(float x) {
    unsigned long long r;
    asm("cvt.rmi.u64.f32 %0, %1;" : "=l"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE unsigned long long __double2ull_rd(double x) {
    unsigned long long r;
    asm("cvt.rmi.u64.f64 %0, %1;" : "=l"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE float __ull2float_rd(unsigned long long x) {
    float r;
    asm("cvt.rm.f32.u64 %0, %1;" : "=f"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE double __ull2double_rd(unsigned long long x) {
    double r;
    asm("cvt.rm.f64.u64 %0, %1;" : "=d"(r) : "l"(x));
    return r;
}
SUNSTONE_DEVICE float __double2float_rd(double x) {
    float r;
    asm("cvt.rm.f32.f64 %0, %1;" : "=f"(r) : "d"(x));
    return r;
}
SUNSTONE_DEVICE double __int2double_rn(int x) {
    return double(x);
}
SUNSTONE_DEVICE double __uint2double_rn(unsigned int x) {
    return double(x);
}
SUNSTONE_DEVICE float __frsqrt_rn(float x) {
    float r;
    asm("rsqrt.approx.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE float __saturatef(float x) {
    float r;
    asm("cvt.sat.f32.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}

// ---- fast approximations ----------------------------------------------------------------------
SUNSTONE_DEVICE float __sinf(float x) {
    float r;
    asm("sin.approx.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE float __cosf(float x) {
    float r;
    asm("cos.approx.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE float __log2f(float x) {
    float r;
    asm("lg2.approx.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE float sunstoneExp2Approx(float x) {
    float r;
    asm("ex2.approx.f32 %0, %1;" : "=f"(r) : "f"(x));
    return r;
}
SUNSTONE_DEVICE float __fdividef(float x, float y) {
    float r;
    asm("div.approx.f32 %0, %1, %2;" : "=f"(r) : "f"(x), "f"(y));
    return r;
}
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
SUNSTONE_DEVICE unsigned int __funnelshift_l(unsigned int lo, unsigned int hi, unsigned int shift) {
    unsigned int r;
    asm("shf.l.wrap.b32 %0, %1, %2, %3;" : "=r"(r) : "r"(lo), "r"(hi), "r"(shift));
    return r;
}
SUNSTONE_DEVICE unsigned int __funnelshift_lc(unsigned int lo, unsigned int hi,
                                              unsigned int shift) {
    unsigned int r;
    asm("shf.l.clamp.b32 %0, %1, %2, %3;" : "=r"(r) : "r"(lo), "r"(hi), "r"(shift));
    return r;
}
SUNSTONE_DEVICE unsigned int __funnelshift_r(unsigned int lo, unsigned int hi, unsigned int shift) {
    unsigned int r;
    asm("shf.r.wrap.b32 %0, %1, %2, %3;" : "=r"(r) : "r"(lo), "r"(hi), "r"(shift));
    return r;
}
SUNSTONE_DEVICE unsigned int __funnelshift_rc(unsigned int lo, unsigned int hi,
                                              unsigned int shift) {
    unsigned int r;
    asm("shf.r.clamp.b32 %0, %1, %2, %3;" : "=r"(r) : "r"(lo), "r"(hi), "r"(shift));
    return r;
}

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
SUNSTONE_DEVICE size_t __cvta_generic_to_global(const void* p) {
    size_t r;
    asm("cvta.to.global.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE void* __cvta_global_to_generic(size_t p) {
    void* r;
    asm("cvta.global.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE size_t __cvta_generic_to_shared(const void* p) {
    size_t r;
    asm("cvta.to.shared.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE void* __cvta_shared_to_generic(size_t p) {
    void* r;
    asm("cvta.shared.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE size_t __cvta_generic_to_local(const void* p) {
    size_t r;
    asm("cvta.to.local.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE void* __cvta_local_to_generic(size_t p) {
    void* r;
    asm("cvta.local.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE size_t __cvta_generic_to_constant(const void* p) {
    size_t r;
    asm("cvta.to.const.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE void* __cvta_constant_to_generic(size_t p) {
    void* r;
    asm("cvta.const.u64 %0, %1;" : "=l"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE unsigned int __isGlobal(const void* p) {
    unsigned int r;
    asm("{ .reg .pred p; isspacep.global p, %1; selp.u32 %0, 1, 0, p; }" : "=r"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE unsigned int __isShared(const void* p) {
    unsigned int r;
    asm("{ .reg .pred p; isspacep.shared p, %1; selp.u32 %0, 1, 0, p; }" : "=r"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE unsigned int __isLocal(const void* p) {
    unsigned int r;
    asm("{ .reg .pred p; isspacep.local p, %1; selp.u32 %0, 1, 0, p; }" : "=r"(r) : "l"(p));
    return r;
}
SUNSTONE_DEVICE unsigned int __isConstant(const void* p) {
    unsigned int r;
    asm("{ .reg .pred p; isspacep.const p, %1; selp.u32 %0, 1, 0, p; }" : "=r"(r) : "l"(p));
    return r;
}

#endif
