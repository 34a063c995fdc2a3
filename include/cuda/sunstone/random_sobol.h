// SPDX-License-Identifier: Apache-2.0
// Sobol sequences in the order of Gray codes (Antonov, Saleev 1979), plain and scrambled, of 32 and
// 64 bits. Programs bring the direction vectors of a dimension, the most significant first; those
// of Joe and Kuo (2008) are in common use. Part of curand_kernel.h.
#ifndef SUNSTONE_RANDOM_SOBOL_H
#define SUNSTONE_RANDOM_SOBOL_H

#include "random_device.h"

typedef unsigned int curandDirectionVectors32_t[32];
typedef unsigned long long curandDirectionVectors64_t[64];

#define SUNSTONE_SOBOL_STATE(name, word, bits)                                                     \
    typedef struct name {                                                                          \
        word i, x, c; /* index, number, scramble */                                                \
        word direction_vectors[bits];                                                              \
    } name##_t;
SUNSTONE_SOBOL_STATE(curandStateSobol32, unsigned int, 32)
SUNSTONE_SOBOL_STATE(curandStateScrambledSobol32, unsigned int, 32)
SUNSTONE_SOBOL_STATE(curandStateSobol64, unsigned long long, 64)
SUNSTONE_SOBOL_STATE(curandStateScrambledSobol64, unsigned long long, 64)
#undef SUNSTONE_SOBOL_STATE

// The number's place n follows from the Gray code of n.
template <class State, class Word>
SUNSTONE_RANDOM void sunstoneSobolMove(State* state, Word n) {
    state->i += n;
    state->x = state->c;
    const Word gray = state->i ^ (state->i >> 1);
    for (unsigned int k = 0; k < 8 * sizeof(Word); ++k)
        if ((gray >> k) & 1u)
            state->x ^= state->direction_vectors[k];
}
template <class State, class Word>
SUNSTONE_RANDOM void sunstoneSobolInit(const Word* vectors, Word scramble, Word offset,
                                       State* state) {
    for (unsigned int k = 0; k < 8 * sizeof(Word); ++k)
        state->direction_vectors[k] = vectors[k];
    state->i = 0;
    state->c = scramble;
    sunstoneSobolMove(state, offset);
}
SUNSTONE_RANDOM unsigned int sunstoneLowestZero(unsigned int i) {
    return i == 0xffffffffu ? 0u : (unsigned int)__ffs((int)~i) - 1u;
}
SUNSTONE_RANDOM unsigned int sunstoneLowestZero(unsigned long long i) {
    return ~i == 0 ? 0u : (unsigned int)__ffsll((long long)~i) - 1u;
}

#define SUNSTONE_SOBOL(state_t, word)                                                              \
    SUNSTONE_RANDOM word curand(state_t* state) {                                                  \
        const word result = state->x;                                                              \
        state->x ^= state->direction_vectors[sunstoneLowestZero(state->i)];                        \
        ++state->i;                                                                                \
        return result;                                                                             \
    }                                                                                              \
    SUNSTONE_RANDOM void skipahead(word n, state_t* state) {                                       \
        sunstoneSobolMove(state, n);                                                               \
    }
SUNSTONE_SOBOL(curandStateSobol32_t, unsigned int)
SUNSTONE_SOBOL(curandStateScrambledSobol32_t, unsigned int)
SUNSTONE_SOBOL(curandStateSobol64_t, unsigned long long)
SUNSTONE_SOBOL(curandStateScrambledSobol64_t, unsigned long long)
#undef SUNSTONE_SOBOL

SUNSTONE_RANDOM void curand_init(curandDirectionVectors32_t vectors, unsigned int offset,
                                 curandStateSobol32_t* state) {
    sunstoneSobolInit(vectors, 0u, offset, state);
}
SUNSTONE_RANDOM void curand_init(curandDirectionVectors32_t vectors, unsigned int scramble,
                                 unsigned int offset, curandStateScrambledSobol32_t* state) {
    sunstoneSobolInit(vectors, scramble, offset, state);
}
SUNSTONE_RANDOM void curand_init(curandDirectionVectors64_t vectors, unsigned long long offset,
                                 curandStateSobol64_t* state) {
    sunstoneSobolInit(vectors, 0ull, offset, state);
}
SUNSTONE_RANDOM void curand_init(curandDirectionVectors64_t vectors, unsigned long long scramble,
                                 unsigned long long offset, curandStateScrambledSobol64_t* state) {
    sunstoneSobolInit(vectors, scramble, offset, state);
}

#endif
