// SPDX-License-Identifier: Apache-2.0
// Functions on words that hold two or four integers, dot products, sums with limits, matches and
// atomics of other types: for each, a sum over the bits of many results.
#include "check.h"

#include <cstring>

namespace {

#define ONE_WORD(X)                                                                                \
    X(__vabs2) X(__vabs4) X(__vabsss2) X(__vabsss4) X(__vneg2) X(__vneg4) X(__vnegss2) X(__vnegss4)
#define COMPARE(X, stem)                                                                           \
    X(stem##eq2) X(stem##eq4) X(stem##ne2) X(stem##ne4) X(stem##ges2) X(stem##ges4) X(stem##geu2)  \
    X(stem##geu4) X(stem##gts2) X(stem##gts4) X(stem##gtu2) X(stem##gtu4) X(stem##les2)            \
    X(stem##les4) X(stem##leu2) X(stem##leu4) X(stem##lts2) X(stem##lts4) X(stem##ltu2) X(stem##ltu4)
#define TWO_WORDS(X)                                                                               \
    X(__vabsdiffs2) X(__vabsdiffs4) X(__vabsdiffu2) X(__vabsdiffu4) X(__vadd2) X(__vadd4)          \
    X(__vaddss2) X(__vaddss4) X(__vaddus2) X(__vaddus4) X(__vavgs2) X(__vavgs4) X(__vavgu2)        \
    X(__vavgu4) X(__vhaddu2) X(__vhaddu4) X(__vmaxs2) X(__vmaxs4) X(__vmaxu2) X(__vmaxu4)          \
    X(__vmins2) X(__vmins4) X(__vminu2) X(__vminu4) X(__vsads2) X(__vsads4) X(__vsadu2)            \
    X(__vsadu4) X(__vsub2) X(__vsub4) X(__vsubss2) X(__vsubss4) X(__vsubus2) X(__vsubus4)          \
    COMPARE(X, __vcmp) COMPARE(X, __vset)                                                          \
    X(__vimax_s16x2_relu) X(__vimax_s32_relu) X(__vimin_s16x2_relu) X(__vimin_s32_relu)            \
    X(__mulhi) X(__umulhi) X(__hadd) X(__rhadd) X(__uhadd) X(__urhadd) X(__mul24) X(__umul24)
#define THREE_WORDS(X)                                                                             \
    X(__viaddmax_s32) X(__viaddmax_u32) X(__viaddmax_s16x2) X(__viaddmax_u16x2)                    \
    X(__viaddmax_s32_relu) X(__viaddmax_s16x2_relu) X(__viaddmin_s32) X(__viaddmin_u32)            \
    X(__viaddmin_s16x2) X(__viaddmin_u16x2) X(__viaddmin_s32_relu) X(__viaddmin_s16x2_relu)        \
    X(__vimax3_s32) X(__vimax3_u32) X(__vimax3_s16x2) X(__vimax3_u16x2) X(__vimax3_s32_relu)       \
    X(__vimax3_s16x2_relu) X(__vimin3_s32) X(__vimin3_u32) X(__vimin3_s16x2) X(__vimin3_u16x2)     \
    X(__vimin3_s32_relu) X(__vimin3_s16x2_relu) X(signedDot4) X(unsignedDot4) X(signedDot2Low)     \
    X(signedDot2High) X(unsignedDot2Low) X(unsignedDot2High) X(__byte_perm) X(funnelLeft)          \
    X(funnelRight) X(maxAndWhich) X(minAndWhich) X(nthSetBit)

__device__ int signedDot4(int a, int b, int c) { return __dp4a(a, b, c); }
__device__ unsigned unsignedDot4(unsigned a, unsigned b, unsigned c) { return __dp4a(a, b, c); }
__device__ int signedDot2Low(int a, int b, int c) { return __dp2a_lo(a, b, c); }
__device__ int signedDot2High(int a, int b, int c) { return __dp2a_hi(a, b, c); }
__device__ unsigned unsignedDot2Low(unsigned a, unsigned b, unsigned c) {
    return __dp2a_lo(a, b, c);
}
__device__ unsigned unsignedDot2High(unsigned a, unsigned b, unsigned c) {
    return __dp2a_hi(a, b, c);
}
__device__ unsigned funnelLeft(unsigned a, unsigned b, unsigned c) {
    return __funnelshift_l(a, b, c) ^ __funnelshift_lc(b, a, c & 63);
}
__device__ unsigned funnelRight(unsigned a, unsigned b, unsigned c) {
    return __funnelshift_r(a, b, c) ^ __funnelshift_rc(b, a, c & 63);
}
__device__ unsigned maxAndWhich(unsigned a, unsigned b, unsigned c) {
    bool p, q, r, s;
    const unsigned x = __vibmax_s16x2(a, b, &p, &q) + 3 * __vibmax_u32(b, c, &r) +
                       5 * unsigned(__vibmax_s32(int(a), int(c), &s));
    return x + p + 2 * q + 4 * r + 8 * s;
}
__device__ unsigned minAndWhich(unsigned a, unsigned b, unsigned c) {
    bool p, q, r, s;
    const unsigned x = __vibmin_u16x2(a, b, &p, &q) + 3 * __vibmin_u32(b, c, &r) +
                       5 * unsigned(__vibmin_s32(int(a), int(c), &s));
    return x + p + 2 * q + 4 * r + 8 * s;
}
__device__ unsigned nthSetBit(unsigned a, unsigned b, unsigned c) {
    return __fns(a, b & 31, int(c & 15) - 7);
}

constexpr unsigned kRounds = 64, kThreads = 256;

__device__ unsigned scrambled(unsigned x) {
    x = (x ^ 61) ^ (x >> 16);
    x *= 9;
    x ^= x >> 4;
    x *= 0x27d4eb2du;
    return x ^ x >> 15;
}
// Random words, some of limits.
__device__ unsigned operand(unsigned i) {
    const unsigned x = scrambled(i), limits = scrambled(i + 99) & 7;
    return limits == 0   ? 0x80008000u ^ (x & 0x00010001u)
           : limits == 1 ? 0x7fff7fffu
           : limits == 2 ? 0x80ff7f00u
           : limits == 3 ? x & 0x01010101u
                         : x;
}

__global__ void run(unsigned long long* sums) {
    for (unsigned round = 0; round < kRounds; ++round) {
        const unsigned i = (round * kThreads + threadIdx.x) * 3;
        const unsigned a = operand(i), b = operand(i + 1), c = operand(i + 2);
        int k = 0;
#define ADD1(f) atomicAdd(sums + k++, (unsigned long long)scrambled((unsigned)f(a) + i));
#define ADD2(f) atomicAdd(sums + k++, (unsigned long long)scrambled((unsigned)f(a, b) + i));
#define ADD3(f) atomicAdd(sums + k++, (unsigned long long)scrambled((unsigned)f(a, b, c) + i));
        ONE_WORD(ADD1)
        TWO_WORDS(ADD2)
        THREE_WORDS(ADD3)
    }
}

__global__ void matches(unsigned* out) {
    const unsigned lane = threadIdx.x;
    int same = 0;
    unsigned r = __match_any_sync(0xffffffffu, (double)(lane / 4));
    r += __match_any_sync(0xffffffffu, (long long)(lane & 7) << 40);
    r += __match_all_sync(0xffffffffu, 1.5f, &same) + same;
    r += __match_all_sync(0xffffffffu, (unsigned long long)lane << 33, &same) + same;
    r += __match_all_sync(0xffffffffu, 2.5, &same) + same;
    out[lane] = r;
    __shared__ unsigned short word[2];
    if (lane < 2)
        word[lane] = 0;
    __syncthreads();
    unsigned short seen = word[lane & 1], expected;
    do {
        expected = seen;
        seen = atomicCAS(word + (lane & 1), expected, (unsigned short)(expected + lane));
    } while (seen != expected);
    __syncthreads();
    if (lane < 2)
        out[32 + lane] = word[lane];
}

} // namespace

int main() {
#define NAME(f) #f,
    const char* const names[] = {ONE_WORD(NAME) TWO_WORDS(NAME) THREE_WORDS(NAME)};
    constexpr int kCount = sizeof names / sizeof *names;
    unsigned long long* sums;
    CHECK(cudaMallocManaged(&sums, kCount * sizeof *sums));
    std::memset(sums, 0, kCount * sizeof *sums);
    run<<<1, kThreads>>>(sums);
    CHECK(cudaDeviceSynchronize());
    for (int k = 0; k < kCount; ++k)
        std::printf("%s %016llx\n", names[k], sums[k]);
    unsigned* out;
    CHECK(cudaMallocManaged(&out, 34 * sizeof *out));
    matches<<<1, 32>>>(out);
    CHECK(cudaDeviceSynchronize());
    for (int k = 0; k < 34; ++k)
        std::printf("%x%c", out[k], k % 17 == 16 ? '\n' : ' ');
    return 0;
}
