// SPDX-License-Identifier: Apache-2.0
// Philox 4x32-10 (Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3"):
// ten rounds of a cipher over a counter of 128 bits. The upper 64 bits count subsequences. Part of
// curand_kernel.h.
#ifndef SUNSTONE_RANDOM_PHILOX_H
#define SUNSTONE_RANDOM_PHILOX_H

#include "random_device.h"

typedef struct curandStatePhilox4_32_10 {
    uint4 ctr;
    uint4 output; // of ctr
    uint2 key;
    unsigned int STATE; // numbers of output already taken
    int boxmuller_flag;
    int boxmuller_flag_double;
    float boxmuller_extra;
    double boxmuller_extra_double;
} curandStatePhilox4_32_10_t;

SUNSTONE_RANDOM uint4 curand_Philox4x32_10(uint4 c, uint2 k) {
    for (int round = 0; round < 10; ++round) {
        const unsigned int high0 = __umulhi(0xD2511F53u, c.x), low0 = 0xD2511F53u * c.x;
        const unsigned int high1 = __umulhi(0xCD9E8D57u, c.z), low1 = 0xCD9E8D57u * c.z;
        c = make_uint4(high1 ^ c.y ^ k.x, low1, high0 ^ c.w ^ k.y, low0);
        k.x += 0x9E3779B9u;
        k.y += 0xBB67AE85u;
    }
    return c;
}

// Adds to the upper 64 bits.
SUNSTONE_RANDOM void sunstonePhiloxAddHigh(uint4& counter, unsigned long long n) {
    const unsigned long long high = (((unsigned long long)counter.w << 32) | counter.z) + n;
    counter.z = (unsigned int)high;
    counter.w = (unsigned int)(high >> 32);
}
SUNSTONE_RANDOM void sunstonePhiloxAdd(uint4& counter, unsigned long long n) {
    const unsigned long long low = (((unsigned long long)counter.y << 32) | counter.x) + n;
    counter.x = (unsigned int)low;
    counter.y = (unsigned int)(low >> 32);
    if (low < n)
        sunstonePhiloxAddHigh(counter, 1);
}

SUNSTONE_RANDOM void skipahead(unsigned long long n, curandStatePhilox4_32_10_t* state) {
    const unsigned int taken = state->STATE + (unsigned int)(n & 3u);
    state->STATE = taken & 3u;
    sunstonePhiloxAdd(state->ctr, n / 4);
    sunstonePhiloxAdd(state->ctr, taken / 4);
    state->output = curand_Philox4x32_10(state->ctr, state->key);
}
SUNSTONE_RANDOM void skipahead_sequence(unsigned long long n, curandStatePhilox4_32_10_t* state) {
    sunstonePhiloxAddHigh(state->ctr, n);
    state->output = curand_Philox4x32_10(state->ctr, state->key);
}

SUNSTONE_RANDOM void curand_init(unsigned long long seed, unsigned long long subsequence,
                                 unsigned long long offset, curandStatePhilox4_32_10_t* state) {
    state->ctr = make_uint4(0, 0, 0, 0);
    state->key = make_uint2((unsigned int)seed, (unsigned int)(seed >> 32));
    state->STATE = 0;
    sunstoneForgetNormal(state);
    sunstonePhiloxAddHigh(state->ctr, subsequence);
    skipahead(offset, state);
}

// The next four numbers.
SUNSTONE_RANDOM uint4 curand4(curandStatePhilox4_32_10_t* state) {
    const uint4 a = state->output;
    sunstonePhiloxAdd(state->ctr, 1);
    const uint4 b = state->output = curand_Philox4x32_10(state->ctr, state->key);
    switch (state->STATE) {
    case 1:
        return make_uint4(a.y, a.z, a.w, b.x);
    case 2:
        return make_uint4(a.z, a.w, b.x, b.y);
    case 3:
        return make_uint4(a.w, b.x, b.y, b.z);
    default:
        return a;
    }
}

SUNSTONE_RANDOM unsigned int curand(curandStatePhilox4_32_10_t* state) {
    const uint4 o = state->output;
    const unsigned int i = state->STATE++;
    if (i == 3) {
        state->STATE = 0;
        sunstonePhiloxAdd(state->ctr, 1);
        state->output = curand_Philox4x32_10(state->ctr, state->key);
    }
    return i == 0 ? o.x : i == 1 ? o.y : i == 2 ? o.z : o.w;
}

#endif
