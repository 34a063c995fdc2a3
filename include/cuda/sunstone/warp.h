// SPDX-License-Identifier: Apache-2.0
// Functions of the threads of a block or warp: barriers, fences, votes, shuffles, matches.
#ifndef SUNSTONE_WARP_H
#define SUNSTONE_WARP_H

#include "intrinsics.h"

// The parameter of a value that other lanes read: a lane may pass a variable that only the lanes
// which are read have set. Without the attribute clang assumes that every lane has set it.
#if __has_attribute(maybe_undef)
#define SUNSTONE_LANE __attribute__((maybe_undef))
#else
#define SUNSTONE_LANE
#endif

// ---- barriers and fences ----------------------------------------------------------------------
// __syncthreads is a compiler built-in.
SUNSTONE_DEVICE int __syncthreads_count(int p) {
    return __nvvm_bar0_popc(p);
}
SUNSTONE_DEVICE int __syncthreads_and(int p) {
    return __nvvm_bar0_and(p);
}
SUNSTONE_DEVICE int __syncthreads_or(int p) {
    return __nvvm_bar0_or(p);
}
SUNSTONE_DEVICE void __syncwarp(unsigned int mask = 0xffffffffu) {
    asm volatile("bar.warp.sync %0;" ::"r"(mask) : "memory");
}
SUNSTONE_DEVICE void __threadfence() {
    __nvvm_membar_gl();
}
SUNSTONE_DEVICE void __threadfence_block() {
    __nvvm_membar_cta();
}
SUNSTONE_DEVICE void __threadfence_system() {
    __nvvm_membar_sys();
}

// ---- votes ------------------------------------------------------------------------------------
SUNSTONE_DEVICE unsigned int __activemask() {
    unsigned int r;
    asm volatile("activemask.b32 %0;" : "=r"(r));
    return r;
}
SUNSTONE_DEVICE unsigned int __ballot_sync(unsigned int mask, int p) {
    unsigned int r;
    asm volatile("{ .reg .pred p; setp.ne.u32 p, %1, 0; vote.sync.ballot.b32 %0, p, %2; }"
                 : "=r"(r)
                 : "r"(p), "r"(mask));
    return r;
}
SUNSTONE_DEVICE int __all_sync(unsigned int mask, int p) {
    int r;
    asm volatile("{ .reg .pred p, q; setp.ne.u32 p, %1, 0; vote.sync.all.pred q, p, %2; "
                 "selp.u32 %0, 1, 0, q; }"
                 : "=r"(r)
                 : "r"(p), "r"(mask));
    return r;
}
SUNSTONE_DEVICE int __any_sync(unsigned int mask, int p) {
    int r;
    asm volatile("{ .reg .pred p, q; setp.ne.u32 p, %1, 0; vote.sync.any.pred q, p, %2; "
                 "selp.u32 %0, 1, 0, q; }"
                 : "=r"(r)
                 : "r"(p), "r"(mask));
    return r;
}
SUNSTONE_DEVICE int __uni_sync(unsigned int mask, int p) {
    int r;
    asm volatile("{ .reg .pred p, q; setp.ne.u32 p, %1, 0; vote.sync.uni.pred q, p, %2; "
                 "selp.u32 %0, 1, 0, q; }"
                 : "=r"(r)
                 : "r"(p), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __lane_id() {
    return __nvvm_read_ptx_sreg_laneid();
}

// ---- shuffles ---------------------------------------------------------------------------------
SUNSTONE_DEVICE int __shfl_sync(unsigned int mask, SUNSTONE_LANE int v, int lane, int width = 32) {
    int r;
    asm volatile("shfl.sync.idx.b32 %0, %1, %2, %3, %4;"
                 : "=r"(r)
                 : "r"(v), "r"(lane), "r"(((32 - width) << 8) | 0x1f), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __shfl_sync(unsigned int mask, SUNSTONE_LANE unsigned int v, int lane,
                                         int width = 32) {
    return (unsigned int)__shfl_sync(mask, (int)v, lane, width);
}
SUNSTONE_DEVICE float __shfl_sync(unsigned int mask, SUNSTONE_LANE float v, int lane,
                                  int width = 32) {
    return __int_as_float(__shfl_sync(mask, __float_as_int(v), lane, width));
}
SUNSTONE_DEVICE long long __shfl_sync(unsigned int mask, SUNSTONE_LANE long long v, int lane,
                                      int width = 32) {
    int lo = __shfl_sync(mask, (int)v, lane, width);
    int hi = __shfl_sync(mask, (int)(v >> 32), lane, width);
    return (long long)(((unsigned long long)(unsigned)hi << 32) | (unsigned)lo);
}
SUNSTONE_DEVICE unsigned long long
__shfl_sync(unsigned int mask, SUNSTONE_LANE unsigned long long v, int lane, int width = 32) {
    return (unsigned long long)__shfl_sync(mask, (long long)v, lane, width);
}
SUNSTONE_DEVICE long __shfl_sync(unsigned int mask, SUNSTONE_LANE long v, int lane,
                                 int width = 32) {
    return (long)__shfl_sync(mask, (long long)v, lane, width);
}
SUNSTONE_DEVICE unsigned long __shfl_sync(unsigned int mask, SUNSTONE_LANE unsigned long v,
                                          int lane, int width = 32) {
    return (unsigned long)__shfl_sync(mask, (long long)v, lane, width);
}
SUNSTONE_DEVICE double __shfl_sync(unsigned int mask, SUNSTONE_LANE double v, int lane,
                                   int width = 32) {
    return __longlong_as_double(__shfl_sync(mask, __double_as_longlong(v), lane, width));
}
SUNSTONE_DEVICE int __shfl_up_sync(unsigned int mask, SUNSTONE_LANE int v, unsigned int delta,
                                   int width = 32) {
    int r;
    asm volatile("shfl.sync.up.b32 %0, %1, %2, %3, %4;"
                 : "=r"(r)
                 : "r"(v), "r"(delta), "r"(((32 - width) << 8) | 0), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __shfl_up_sync(unsigned int mask, SUNSTONE_LANE unsigned int v,
                                            unsigned int delta, int width = 32) {
    return (unsigned int)__shfl_up_sync(mask, (int)v, delta, width);
}
SUNSTONE_DEVICE float __shfl_up_sync(unsigned int mask, SUNSTONE_LANE float v, unsigned int delta,
                                     int width = 32) {
    return __int_as_float(__shfl_up_sync(mask, __float_as_int(v), delta, width));
}
SUNSTONE_DEVICE long long __shfl_up_sync(unsigned int mask, SUNSTONE_LANE long long v,
                                         unsigned int delta, int width = 32) {
    int lo = __shfl_up_sync(mask, (int)v, delta, width);
    int hi = __shfl_up_sync(mask, (int)(v >> 32), delta, width);
    return (long long)(((unsigned long long)(unsigned)hi << 32) | (unsigned)lo);
}
SUNSTONE_DEVICE unsigned long long __shfl_up_sync(unsigned int mask,
                                                  SUNSTONE_LANE unsigned long long v,
                                                  unsigned int delta, int width = 32) {
    return (unsigned long long)__shfl_up_sync(mask, (long long)v, delta, width);
}
SUNSTONE_DEVICE long __shfl_up_sync(unsigned int mask, SUNSTONE_LANE long v, unsigned int delta,
                                    int width = 32) {
    return (long)__shfl_up_sync(mask, (long long)v, delta, width);
}
SUNSTONE_DEVICE unsigned long __shfl_up_sync(unsigned int mask, SUNSTONE_LANE unsigned long v,
                                             unsigned int delta, int width = 32) {
    return (unsigned long)__shfl_up_sync(mask, (long long)v, delta, width);
}
SUNSTONE_DEVICE double __shfl_up_sync(unsigned int mask, SUNSTONE_LANE double v, unsigned int delta,
                                      int width = 32) {
    return __longlong_as_double(__shfl_up_sync(mask, __double_as_longlong(v), delta, width));
}
SUNSTONE_DEVICE int __shfl_down_sync(unsigned int mask, SUNSTONE_LANE int v, unsigned int delta,
                                     int width = 32) {
    int r;
    asm volatile("shfl.sync.down.b32 %0, %1, %2, %3, %4;"
                 : "=r"(r)
                 : "r"(v), "r"(delta), "r"(((32 - width) << 8) | 0x1f), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __shfl_down_sync(unsigned int mask, SUNSTONE_LANE unsigned int v,
                                              unsigned int delta, int width = 32) {
    return (unsigned int)__shfl_down_sync(mask, (int)v, delta, width);
}
SUNSTONE_DEVICE float __shfl_down_sync(unsigned int mask, SUNSTONE_LANE float v, unsigned int delta,
                                       int width = 32) {
    return __int_as_float(__shfl_down_sync(mask, __float_as_int(v), delta, width));
}
SUNSTONE_DEVICE long long __shfl_down_sync(unsigned int mask, SUNSTONE_LANE long long v,
                                           unsigned int delta, int width = 32) {
    int lo = __shfl_down_sync(mask, (int)v, delta, width);
    int hi = __shfl_down_sync(mask, (int)(v >> 32), delta, width);
    return (long long)(((unsigned long long)(unsigned)hi << 32) | (unsigned)lo);
}
SUNSTONE_DEVICE unsigned long long __shfl_down_sync(unsigned int mask,
                                                    SUNSTONE_LANE unsigned long long v,
                                                    unsigned int delta, int width = 32) {
    return (unsigned long long)__shfl_down_sync(mask, (long long)v, delta, width);
}
SUNSTONE_DEVICE long __shfl_down_sync(unsigned int mask, SUNSTONE_LANE long v, unsigned int delta,
                                      int width = 32) {
    return (long)__shfl_down_sync(mask, (long long)v, delta, width);
}
SUNSTONE_DEVICE unsigned long __shfl_down_sync(unsigned int mask, SUNSTONE_LANE unsigned long v,
                                               unsigned int delta, int width = 32) {
    return (unsigned long)__shfl_down_sync(mask, (long long)v, delta, width);
}
SUNSTONE_DEVICE double __shfl_down_sync(unsigned int mask, SUNSTONE_LANE double v,
                                        unsigned int delta, int width = 32) {
    return __longlong_as_double(__shfl_down_sync(mask, __double_as_longlong(v), delta, width));
}
SUNSTONE_DEVICE int __shfl_xor_sync(unsigned int mask, SUNSTONE_LANE int v, int laneMask,
                                    int width = 32) {
    int r;
    asm volatile("shfl.sync.bfly.b32 %0, %1, %2, %3, %4;"
                 : "=r"(r)
                 : "r"(v), "r"(laneMask), "r"(((32 - width) << 8) | 0x1f), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __shfl_xor_sync(unsigned int mask, SUNSTONE_LANE unsigned int v,
                                             int laneMask, int width = 32) {
    return (unsigned int)__shfl_xor_sync(mask, (int)v, laneMask, width);
}
SUNSTONE_DEVICE float __shfl_xor_sync(unsigned int mask, SUNSTONE_LANE float v, int laneMask,
                                      int width = 32) {
    return __int_as_float(__shfl_xor_sync(mask, __float_as_int(v), laneMask, width));
}
SUNSTONE_DEVICE long long __shfl_xor_sync(unsigned int mask, SUNSTONE_LANE long long v,
                                          int laneMask, int width = 32) {
    int lo = __shfl_xor_sync(mask, (int)v, laneMask, width);
    int hi = __shfl_xor_sync(mask, (int)(v >> 32), laneMask, width);
    return (long long)(((unsigned long long)(unsigned)hi << 32) | (unsigned)lo);
}
SUNSTONE_DEVICE unsigned long long __shfl_xor_sync(unsigned int mask,
                                                   SUNSTONE_LANE unsigned long long v, int laneMask,
                                                   int width = 32) {
    return (unsigned long long)__shfl_xor_sync(mask, (long long)v, laneMask, width);
}
SUNSTONE_DEVICE long __shfl_xor_sync(unsigned int mask, SUNSTONE_LANE long v, int laneMask,
                                     int width = 32) {
    return (long)__shfl_xor_sync(mask, (long long)v, laneMask, width);
}
SUNSTONE_DEVICE unsigned long __shfl_xor_sync(unsigned int mask, SUNSTONE_LANE unsigned long v,
                                              int laneMask, int width = 32) {
    return (unsigned long)__shfl_xor_sync(mask, (long long)v, laneMask, width);
}
SUNSTONE_DEVICE double __shfl_xor_sync(unsigned int mask, SUNSTONE_LANE double v, int laneMask,
                                       int width = 32) {
    return __longlong_as_double(__shfl_xor_sync(mask, __double_as_longlong(v), laneMask, width));
}

#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 700
// ---- matches ----------------------------------------------------------------------------------
SUNSTONE_DEVICE unsigned int __match_any_sync(unsigned int mask, unsigned int v) {
    unsigned int r;
    asm volatile("match.any.sync.b32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __match_any_sync(unsigned int mask, unsigned long long v) {
    unsigned int r;
    asm volatile("match.any.sync.b64 %0, %1, %2;" : "=r"(r) : "l"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __match_any_sync(unsigned int mask, int v) {
    return __match_any_sync(mask, (unsigned int)v);
}
SUNSTONE_DEVICE unsigned int __match_any_sync(unsigned int mask, float v) {
    return __match_any_sync(mask, __float_as_uint(v));
}
SUNSTONE_DEVICE unsigned int __match_all_sync(unsigned int mask, unsigned int v, int* same) {
    unsigned int r;
    int p;
    asm volatile("{ .reg .pred p; match.all.sync.b32 %0|p, %2, %3; selp.s32 %1, 1, 0, p; }"
                 : "=r"(r), "=r"(p)
                 : "r"(v), "r"(mask));
    *same = p;
    return r;
}
SUNSTONE_DEVICE unsigned int __match_all_sync(unsigned int mask, int v, int* same) {
    return __match_all_sync(mask, (unsigned int)v, same);
}
SUNSTONE_DEVICE unsigned int __match_all_sync(unsigned int mask, unsigned long long v, int* same) {
    unsigned int r;
    int p;
    asm volatile("{ .reg .pred p; match.all.sync.b64 %0|p, %2, %3; selp.s32 %1, 1, 0, p; }"
                 : "=r"(r), "=r"(p)
                 : "l"(v), "r"(mask));
    *same = p;
    return r;
}
SUNSTONE_DEVICE unsigned int __match_all_sync(unsigned int mask, float v, int* same) {
    return __match_all_sync(mask, __float_as_uint(v), same);
}
#define SUNSTONE_MATCH_WORD(T)                                                                     \
    SUNSTONE_DEVICE unsigned int __match_any_sync(unsigned int mask, T v) {                        \
        return __match_any_sync(mask, __builtin_bit_cast(unsigned long long, v));                  \
    }                                                                                              \
    SUNSTONE_DEVICE unsigned int __match_all_sync(unsigned int mask, T v, int* same) {             \
        return __match_all_sync(mask, __builtin_bit_cast(unsigned long long, v), same);            \
    }
SUNSTONE_MATCH_WORD(long long)
SUNSTONE_MATCH_WORD(long)
SUNSTONE_MATCH_WORD(unsigned long)
SUNSTONE_MATCH_WORD(double)
#undef SUNSTONE_MATCH_WORD
#endif
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 800
// ---- reductions over a warp -------------------------------------------------------------------
SUNSTONE_DEVICE unsigned int __reduce_add_sync(unsigned int mask, unsigned int v) {
    unsigned int r;
    asm volatile("redux.sync.add.u32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE int __reduce_add_sync(unsigned int mask, int v) {
    int r;
    asm volatile("redux.sync.add.s32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __reduce_min_sync(unsigned int mask, unsigned int v) {
    unsigned int r;
    asm volatile("redux.sync.min.u32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE int __reduce_min_sync(unsigned int mask, int v) {
    int r;
    asm volatile("redux.sync.min.s32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __reduce_max_sync(unsigned int mask, unsigned int v) {
    unsigned int r;
    asm volatile("redux.sync.max.u32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE int __reduce_max_sync(unsigned int mask, int v) {
    int r;
    asm volatile("redux.sync.max.s32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __reduce_and_sync(unsigned int mask, unsigned int v) {
    unsigned int r;
    asm volatile("redux.sync.and.b32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __reduce_or_sync(unsigned int mask, unsigned int v) {
    unsigned int r;
    asm volatile("redux.sync.or.b32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
SUNSTONE_DEVICE unsigned int __reduce_xor_sync(unsigned int mask, unsigned int v) {
    unsigned int r;
    asm volatile("redux.sync.xor.b32 %0, %1, %2;" : "=r"(r) : "r"(v), "r"(mask));
    return r;
}
#endif

#endif
