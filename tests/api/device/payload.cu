// SPDX-License-Identifier: Apache-2.0
// For every number of payload words from 0 to 32: a raygen program that traces with them, and a
// closest-hit and a miss program that change each of them.
#include <optix.h>

struct PayloadParams {
    unsigned long long handle;
    unsigned* words; // 32 for each launch index
    float directionZ; // +1 hits, -1 misses
};

extern "C" {
__constant__ PayloadParams params;
}

// Word i becomes 3 * word + i in closest-hit and 5 * word + i in miss programs.
#define WORD(i, factor) optixSetPayload_##i(optixGetPayload_##i() * factor + i)

#define UPTO_0(M, ...)
#define UPTO_1(M, ...) M(0, __VA_ARGS__)
#define UPTO_2(M, ...) UPTO_1(M, __VA_ARGS__) M(1, __VA_ARGS__)
#define UPTO_3(M, ...) UPTO_2(M, __VA_ARGS__) M(2, __VA_ARGS__)
#define UPTO_4(M, ...) UPTO_3(M, __VA_ARGS__) M(3, __VA_ARGS__)
#define UPTO_5(M, ...) UPTO_4(M, __VA_ARGS__) M(4, __VA_ARGS__)
#define UPTO_6(M, ...) UPTO_5(M, __VA_ARGS__) M(5, __VA_ARGS__)
#define UPTO_7(M, ...) UPTO_6(M, __VA_ARGS__) M(6, __VA_ARGS__)
#define UPTO_8(M, ...) UPTO_7(M, __VA_ARGS__) M(7, __VA_ARGS__)
#define UPTO_9(M, ...) UPTO_8(M, __VA_ARGS__) M(8, __VA_ARGS__)
#define UPTO_10(M, ...) UPTO_9(M, __VA_ARGS__) M(9, __VA_ARGS__)
#define UPTO_11(M, ...) UPTO_10(M, __VA_ARGS__) M(10, __VA_ARGS__)
#define UPTO_12(M, ...) UPTO_11(M, __VA_ARGS__) M(11, __VA_ARGS__)
#define UPTO_13(M, ...) UPTO_12(M, __VA_ARGS__) M(12, __VA_ARGS__)
#define UPTO_14(M, ...) UPTO_13(M, __VA_ARGS__) M(13, __VA_ARGS__)
#define UPTO_15(M, ...) UPTO_14(M, __VA_ARGS__) M(14, __VA_ARGS__)
#define UPTO_16(M, ...) UPTO_15(M, __VA_ARGS__) M(15, __VA_ARGS__)
#define UPTO_17(M, ...) UPTO_16(M, __VA_ARGS__) M(16, __VA_ARGS__)
#define UPTO_18(M, ...) UPTO_17(M, __VA_ARGS__) M(17, __VA_ARGS__)
#define UPTO_19(M, ...) UPTO_18(M, __VA_ARGS__) M(18, __VA_ARGS__)
#define UPTO_20(M, ...) UPTO_19(M, __VA_ARGS__) M(19, __VA_ARGS__)
#define UPTO_21(M, ...) UPTO_20(M, __VA_ARGS__) M(20, __VA_ARGS__)
#define UPTO_22(M, ...) UPTO_21(M, __VA_ARGS__) M(21, __VA_ARGS__)
#define UPTO_23(M, ...) UPTO_22(M, __VA_ARGS__) M(22, __VA_ARGS__)
#define UPTO_24(M, ...) UPTO_23(M, __VA_ARGS__) M(23, __VA_ARGS__)
#define UPTO_25(M, ...) UPTO_24(M, __VA_ARGS__) M(24, __VA_ARGS__)
#define UPTO_26(M, ...) UPTO_25(M, __VA_ARGS__) M(25, __VA_ARGS__)
#define UPTO_27(M, ...) UPTO_26(M, __VA_ARGS__) M(26, __VA_ARGS__)
#define UPTO_28(M, ...) UPTO_27(M, __VA_ARGS__) M(27, __VA_ARGS__)
#define UPTO_29(M, ...) UPTO_28(M, __VA_ARGS__) M(28, __VA_ARGS__)
#define UPTO_30(M, ...) UPTO_29(M, __VA_ARGS__) M(29, __VA_ARGS__)
#define UPTO_31(M, ...) UPTO_30(M, __VA_ARGS__) M(30, __VA_ARGS__)
#define UPTO_32(M, ...) UPTO_31(M, __VA_ARGS__) M(31, __VA_ARGS__)

#define CHANGE(i, factor) WORD(i, factor);
#define LOAD(i, unused) unsigned p##i = words[i];
#define STORE(i, unused) words[i] = p##i;
#define ARGUMENT(i, unused) , p##i

#define PROGRAMS(n)                                                                                \
    extern "C" __global__ void __raygen__payload_##n() {                                           \
        unsigned* words = params.words + 32 * optixGetLaunchIndex().x;                             \
        UPTO_##n(LOAD, 0)                                                                          \
        optixTrace(params.handle, make_float3(0.0f, 0.0f, 0.0f),                                   \
                   make_float3(0.0f, 0.0f, params.directionZ), 0.0f, 10.0f, 0.0f, 255, 0, 0, 0,    \
                   0 UPTO_##n(ARGUMENT, 0));                                                       \
        UPTO_##n(STORE, 0)                                                                         \
    }                                                                                              \
    extern "C" __global__ void __closesthit__payload_##n() { UPTO_##n(CHANGE, 3) }                 \
    extern "C" __global__ void __miss__payload_##n() { UPTO_##n(CHANGE, 5) }

PROGRAMS(0)
PROGRAMS(1)
PROGRAMS(2)
PROGRAMS(3)
PROGRAMS(4)
PROGRAMS(5)
PROGRAMS(6)
PROGRAMS(7)
PROGRAMS(8)
PROGRAMS(9)
PROGRAMS(10)
PROGRAMS(11)
PROGRAMS(12)
PROGRAMS(13)
PROGRAMS(14)
PROGRAMS(15)
PROGRAMS(16)
PROGRAMS(17)
PROGRAMS(18)
PROGRAMS(19)
PROGRAMS(20)
PROGRAMS(21)
PROGRAMS(22)
PROGRAMS(23)
PROGRAMS(24)
PROGRAMS(25)
PROGRAMS(26)
PROGRAMS(27)
PROGRAMS(28)
PROGRAMS(29)
PROGRAMS(30)
PROGRAMS(31)
PROGRAMS(32)
