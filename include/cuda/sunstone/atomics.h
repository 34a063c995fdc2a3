// SPDX-License-Identifier: Apache-2.0
// Atomic functions of device code: relaxed order; device scope, _block and _system variants.
#ifndef SUNSTONE_ATOMICS_H
#define SUNSTONE_ATOMICS_H

#include "intrinsics.h"

// A generic atom instruction names no address space, so p may point to any space.
SUNSTONE_DEVICE int atomicAdd(int* p, int v) {
    int old;
    asm volatile("atom.add.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicAdd_block(int* p, int v) {
    int old;
    asm volatile("atom.cta.add.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicAdd_system(int* p, int v) {
    int old;
    asm volatile("atom.sys.add.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicAdd(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.add.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicAdd_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.add.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicAdd_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.add.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicAdd(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.add.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicAdd_block(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.add.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicAdd_system(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.add.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE float atomicAdd(float* p, float v) {
    float old;
    asm volatile("atom.add.f32 %0, [%1], %2;" : "=f"(old) : "l"(p), "f"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE float atomicAdd_block(float* p, float v) {
    float old;
    asm volatile("atom.cta.add.f32 %0, [%1], %2;" : "=f"(old) : "l"(p), "f"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE float atomicAdd_system(float* p, float v) {
    float old;
    asm volatile("atom.sys.add.f32 %0, [%1], %2;" : "=f"(old) : "l"(p), "f"(v) : "memory");
    return old;
}
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 600 || !defined(__CUDA_ARCH__)
SUNSTONE_DEVICE double atomicAdd(double* p, double v) {
    double old;
    asm volatile("atom.add.f64 %0, [%1], %2;" : "=d"(old) : "l"(p), "d"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE double atomicAdd_block(double* p, double v) {
    double old;
    asm volatile("atom.cta.add.f64 %0, [%1], %2;" : "=d"(old) : "l"(p), "d"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE double atomicAdd_system(double* p, double v) {
    double old;
    asm volatile("atom.sys.add.f64 %0, [%1], %2;" : "=d"(old) : "l"(p), "d"(v) : "memory");
    return old;
}
#endif
SUNSTONE_DEVICE int atomicMin(int* p, int v) {
    int old;
    asm volatile("atom.min.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicMin_block(int* p, int v) {
    int old;
    asm volatile("atom.cta.min.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicMin_system(int* p, int v) {
    int old;
    asm volatile("atom.sys.min.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicMin(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.min.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicMin_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.min.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicMin_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.min.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE long long atomicMin(long long* p, long long v) {
    long long old;
    asm volatile("atom.min.s64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE long long atomicMin_block(long long* p, long long v) {
    long long old;
    asm volatile("atom.cta.min.s64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE long long atomicMin_system(long long* p, long long v) {
    long long old;
    asm volatile("atom.sys.min.s64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicMin(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.min.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicMin_block(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.min.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicMin_system(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.min.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicMax(int* p, int v) {
    int old;
    asm volatile("atom.max.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicMax_block(int* p, int v) {
    int old;
    asm volatile("atom.cta.max.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicMax_system(int* p, int v) {
    int old;
    asm volatile("atom.sys.max.s32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicMax(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.max.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicMax_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.max.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicMax_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.max.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE long long atomicMax(long long* p, long long v) {
    long long old;
    asm volatile("atom.max.s64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE long long atomicMax_block(long long* p, long long v) {
    long long old;
    asm volatile("atom.cta.max.s64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE long long atomicMax_system(long long* p, long long v) {
    long long old;
    asm volatile("atom.sys.max.s64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicMax(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.max.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicMax_block(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.max.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicMax_system(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.max.u64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicAnd(int* p, int v) {
    int old;
    asm volatile("atom.and.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicAnd_block(int* p, int v) {
    int old;
    asm volatile("atom.cta.and.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicAnd_system(int* p, int v) {
    int old;
    asm volatile("atom.sys.and.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicAnd(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.and.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicAnd_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.and.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicAnd_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.and.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicAnd(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.and.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicAnd_block(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.and.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicAnd_system(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.and.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicOr(int* p, int v) {
    int old;
    asm volatile("atom.or.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicOr_block(int* p, int v) {
    int old;
    asm volatile("atom.cta.or.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicOr_system(int* p, int v) {
    int old;
    asm volatile("atom.sys.or.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicOr(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.or.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicOr_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.or.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicOr_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.or.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicOr(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.or.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicOr_block(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.or.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicOr_system(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.or.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicXor(int* p, int v) {
    int old;
    asm volatile("atom.xor.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicXor_block(int* p, int v) {
    int old;
    asm volatile("atom.cta.xor.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicXor_system(int* p, int v) {
    int old;
    asm volatile("atom.sys.xor.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicXor(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.xor.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicXor_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.xor.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicXor_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.xor.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicXor(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.xor.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicXor_block(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.xor.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicXor_system(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.xor.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicExch(int* p, int v) {
    int old;
    asm volatile("atom.exch.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicExch_block(int* p, int v) {
    int old;
    asm volatile("atom.cta.exch.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicExch_system(int* p, int v) {
    int old;
    asm volatile("atom.sys.exch.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicExch(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.exch.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicExch_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.exch.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicExch_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.exch.b32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicExch(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.exch.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicExch_block(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.exch.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicExch_system(unsigned long long* p, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.exch.b64 %0, [%1], %2;" : "=l"(old) : "l"(p), "l"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE float atomicExch(float* p, float v) {
    return __uint_as_float(atomicExch((unsigned int*)p, __float_as_uint(v)));
}
SUNSTONE_DEVICE float atomicExch_block(float* p, float v) {
    return __uint_as_float(atomicExch_block((unsigned int*)p, __float_as_uint(v)));
}
SUNSTONE_DEVICE float atomicExch_system(float* p, float v) {
    return __uint_as_float(atomicExch_system((unsigned int*)p, __float_as_uint(v)));
}
SUNSTONE_DEVICE unsigned int atomicInc(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.inc.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicInc_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.inc.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicInc_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.inc.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicDec(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.dec.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicDec_block(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.dec.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicDec_system(unsigned int* p, unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.dec.u32 %0, [%1], %2;" : "=r"(old) : "l"(p), "r"(v) : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicSub(int* p, int v) {
    return atomicAdd(p, int(0u - unsigned(v)));
}
SUNSTONE_DEVICE unsigned int atomicSub(unsigned int* p, unsigned int v) {
    return atomicAdd(p, 0u - v);
}
SUNSTONE_DEVICE int atomicSub_block(int* p, int v) {
    return atomicAdd_block(p, int(0u - unsigned(v)));
}
SUNSTONE_DEVICE unsigned int atomicSub_block(unsigned int* p, unsigned int v) {
    return atomicAdd_block(p, 0u - v);
}
SUNSTONE_DEVICE int atomicSub_system(int* p, int v) {
    return atomicAdd_system(p, int(0u - unsigned(v)));
}
SUNSTONE_DEVICE unsigned int atomicSub_system(unsigned int* p, unsigned int v) {
    return atomicAdd_system(p, 0u - v);
}
SUNSTONE_DEVICE int atomicCAS(int* p, int compare, int v) {
    int old;
    asm volatile("atom.cas.b32 %0, [%1], %2, %3;"
                 : "=r"(old)
                 : "l"(p), "r"(compare), "r"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicCAS_block(int* p, int compare, int v) {
    int old;
    asm volatile("atom.cta.cas.b32 %0, [%1], %2, %3;"
                 : "=r"(old)
                 : "l"(p), "r"(compare), "r"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE int atomicCAS_system(int* p, int compare, int v) {
    int old;
    asm volatile("atom.sys.cas.b32 %0, [%1], %2, %3;"
                 : "=r"(old)
                 : "l"(p), "r"(compare), "r"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicCAS(unsigned int* p, unsigned int compare, unsigned int v) {
    unsigned int old;
    asm volatile("atom.cas.b32 %0, [%1], %2, %3;"
                 : "=r"(old)
                 : "l"(p), "r"(compare), "r"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicCAS_block(unsigned int* p, unsigned int compare,
                                             unsigned int v) {
    unsigned int old;
    asm volatile("atom.cta.cas.b32 %0, [%1], %2, %3;"
                 : "=r"(old)
                 : "l"(p), "r"(compare), "r"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned int atomicCAS_system(unsigned int* p, unsigned int compare,
                                              unsigned int v) {
    unsigned int old;
    asm volatile("atom.sys.cas.b32 %0, [%1], %2, %3;"
                 : "=r"(old)
                 : "l"(p), "r"(compare), "r"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long atomicCAS(unsigned long long* p, unsigned long long compare,
                                             unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cas.b64 %0, [%1], %2, %3;"
                 : "=l"(old)
                 : "l"(p), "l"(compare), "l"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long
atomicCAS_block(unsigned long long* p, unsigned long long compare, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.cta.cas.b64 %0, [%1], %2, %3;"
                 : "=l"(old)
                 : "l"(p), "l"(compare), "l"(v)
                 : "memory");
    return old;
}
SUNSTONE_DEVICE unsigned long long
atomicCAS_system(unsigned long long* p, unsigned long long compare, unsigned long long v) {
    unsigned long long old;
    asm volatile("atom.sys.cas.b64 %0, [%1], %2, %3;"
                 : "=l"(old)
                 : "l"(p), "l"(compare), "l"(v)
                 : "memory");
    return old;
}

#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 700
#define SUNSTONE_CAS_SHORT(name, scope)                                                            \
    SUNSTONE_DEVICE unsigned short name(unsigned short* p, unsigned short compare,                 \
                                        unsigned short v) {                                        \
        unsigned short old;                                                                        \
        asm volatile("atom" scope ".cas.b16 %0, [%1], %2, %3;"                                     \
                     : "=h"(old)                                                                   \
                     : "l"(p), "h"(compare), "h"(v)                                                \
                     : "memory");                                                                  \
        return old;                                                                                \
    }
SUNSTONE_CAS_SHORT(atomicCAS, "")
SUNSTONE_CAS_SHORT(atomicCAS_block, ".cta")
SUNSTONE_CAS_SHORT(atomicCAS_system, ".sys")
#undef SUNSTONE_CAS_SHORT
#endif

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
