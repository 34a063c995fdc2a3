// SPDX-License-Identifier: Apache-2.0
// MRG32k3a (L'Ecuyer 1999, "Good parameters and implementations for combined multiple recursive
// random number generators"). A sequence is 2^127 steps, a subsequence 2^76. Part of
// curand_kernel.h.
#ifndef SUNSTONE_RANDOM_MRG32K3A_H
#define SUNSTONE_RANDOM_MRG32K3A_H

#include "random_device.h"

typedef struct curandStateMRG32k3a {
    unsigned int s1[3];
    unsigned int s2[3];
    int boxmuller_flag;
    int boxmuller_flag_double;
    float boxmuller_extra;
    double boxmuller_extra_double;
} curandStateMRG32k3a_t;

#define SUNSTONE_MRG_M1 4294967087u
#define SUNSTONE_MRG_M2 4294944443u

// The matrices of both components, row by row, for one step, a subsequence and a sequence.
static __device__ const unsigned int sunstoneMrgStep[18] = {
    0u, 1u, 0u, 0u, 0u, 1u, 4294156359u, 1403580u, 0u,
    0u, 1u, 0u, 0u, 0u, 1u, 4293573854u, 0u,       527612u};
static __device__ const unsigned int sunstoneMrgSubsequence[18] = {
    82758667u,   1871391091u, 4127413238u, 3672831523u, 69195019u,   1871391091u,
    3672091415u, 3528743235u, 69195019u,   1511326704u, 3759209742u, 1610795712u,
    4292754251u, 1511326704u, 3889917532u, 3859662829u, 4292754251u, 3708466080u};
static __device__ const unsigned int sunstoneMrgSequence[18] = {
    2427906178u, 3580155704u, 949770784u,  226153695u,  1230515664u, 3580155704u,
    1988835001u, 986791581u,  1230515664u, 1464411153u, 277697599u,  1610723613u,
    32183930u,   1464411153u, 1022607788u, 2824425944u, 32183930u,   2093834863u};

SUNSTONE_RANDOM void sunstoneMrgApply(const unsigned int* matrix, unsigned int modulus,
                                      unsigned int* state) {
    unsigned int result[3];
    for (int i = 0; i < 3; ++i) {
        unsigned long long sum = 0;
        for (int k = 0; k < 3; ++k)
            sum = (sum + (unsigned long long)matrix[3 * i + k] * state[k] % modulus) % modulus;
        result[i] = (unsigned int)sum;
    }
    for (int i = 0; i < 3; ++i)
        state[i] = result[i];
}

// The `count`-fold application of both matrices.
static __device__ __noinline__ void sunstoneMrgJump(const unsigned int* matrices,
                                                    unsigned long long count,
                                                    curandStateMRG32k3a_t* state) {
    unsigned int power[18];
    for (int i = 0; i < 18; ++i)
        power[i] = matrices[i];
    for (; count != 0; count >>= 1) {
        if (count & 1u) {
            sunstoneMrgApply(power, SUNSTONE_MRG_M1, state->s1);
            sunstoneMrgApply(power + 9, SUNSTONE_MRG_M2, state->s2);
        }
        for (int half = 0; half < 2; ++half) {
            const unsigned int* from = power + 9 * half;
            const unsigned int modulus = half ? SUNSTONE_MRG_M2 : SUNSTONE_MRG_M1;
            unsigned int square[9];
            for (int column = 0; column < 3; ++column) {
                unsigned int vector[3] = {from[column], from[3 + column], from[6 + column]};
                sunstoneMrgApply(from, modulus, vector);
                for (int row = 0; row < 3; ++row)
                    square[3 * row + column] = vector[row];
            }
            for (int i = 0; i < 9; ++i)
                power[9 * half + i] = square[i];
        }
    }
}

SUNSTONE_RANDOM void skipahead(unsigned long long n, curandStateMRG32k3a_t* state) {
    sunstoneMrgJump(sunstoneMrgStep, n, state);
}
SUNSTONE_RANDOM void skipahead_subsequence(unsigned long long n, curandStateMRG32k3a_t* state) {
    sunstoneMrgJump(sunstoneMrgSubsequence, n, state);
}
SUNSTONE_RANDOM void skipahead_sequence(unsigned long long n, curandStateMRG32k3a_t* state) {
    sunstoneMrgJump(sunstoneMrgSequence, n, state);
}

SUNSTONE_RANDOM void curand_init(unsigned long long seed, unsigned long long subsequence,
                                 unsigned long long offset, curandStateMRG32k3a_t* state) {
    const unsigned int low = (unsigned int)seed ^ 0x55555555u;
    const unsigned int high = (unsigned int)(seed >> 32) ^ 0xaaaaaaaau;
    for (int i = 0; i < 3; ++i) {
        const unsigned int first = seed == 0 ? 1u : i == 1 ? high : low;
        const unsigned int second = seed == 0 ? 1u : i == 1 ? low : high;
        state->s1[i] = (unsigned int)(first * 12345ull % SUNSTONE_MRG_M1);
        state->s2[i] = (unsigned int)(second * 12345ull % SUNSTONE_MRG_M2);
    }
    skipahead_subsequence(subsequence, state);
    skipahead(offset, state);
    sunstoneForgetNormal(state);
}

// 1 to the first modulus.
SUNSTONE_RANDOM double curand_MRG32k3a(curandStateMRG32k3a_t* state) {
    const unsigned int one =
        (unsigned int)((1403580ull * state->s1[1] +
                        (unsigned long long)(SUNSTONE_MRG_M1 - 810728u) * state->s1[0]) %
                       SUNSTONE_MRG_M1);
    const unsigned int two =
        (unsigned int)((527612ull * state->s2[2] +
                        (unsigned long long)(SUNSTONE_MRG_M2 - 1370589u) * state->s2[0]) %
                       SUNSTONE_MRG_M2);
    state->s1[0] = state->s1[1];
    state->s1[1] = state->s1[2];
    state->s1[2] = one;
    state->s2[0] = state->s2[1];
    state->s2[1] = state->s2[2];
    state->s2[2] = two;
    const double difference = (double)one - (double)two;
    return one <= two ? difference + (double)SUNSTONE_MRG_M1 : difference;
}

// 32 bits: the range of the first modulus, stretched.
SUNSTONE_RANDOM unsigned int curand(curandStateMRG32k3a_t* state) {
    return (unsigned int)(curand_MRG32k3a(state) * 1.000000048662);
}

#endif
