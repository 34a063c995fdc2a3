// SPDX-License-Identifier: Apache-2.0
// Distributions over the generators of curand_kernel.h.
//
//   uniform     (0, 1]: the bits of one number, of two for the doubles of XORWOW, plus a half or 1
//   normal      pairs by Box and Muller (1958), the second kept for the next call; Sobol numbers
//               keep their order, so they take the inverse of the distribution function
//   log-normal  the exponential of a normal number
//   Poisson     the inverse of the distribution function: summed up to a mean of 200, from there on
//               the expansion of Giles (2016), "Algorithm 955"
#ifndef SUNSTONE_RANDOM_DISTRIBUTIONS_H
#define SUNSTONE_RANDOM_DISTRIBUTIONS_H

#include "random_mrg32k3a.h"
#include "random_philox.h"
#include "random_sobol.h"
#include "random_xorwow.h"

// ---- Uniform ------------------------------------------------------------------------------------
SUNSTONE_RANDOM float sunstoneUniform(unsigned int x) {
    return x * 2.3283064e-10f + 2.3283064e-10f / 2.0f;
}
SUNSTONE_RANDOM double sunstoneUniformDouble(unsigned int x) {
    return x * 0x1p-32 + 0x1p-32;
}
SUNSTONE_RANDOM double sunstoneUniformDouble(unsigned long long x) {
    return (x >> 11) * 0x1p-53 + 0x1p-54;
}
SUNSTONE_RANDOM double sunstoneUniformDouble(unsigned int x, unsigned int y) {
    return (((unsigned long long)y << 21) ^ x) * 0x1p-53 + 0x1p-54;
}

SUNSTONE_RANDOM float curand_uniform(curandStateXORWOW_t* state) {
    return sunstoneUniform(curand(state));
}
SUNSTONE_RANDOM double curand_uniform_double(curandStateXORWOW_t* state) {
    const unsigned int x = curand(state), y = curand(state);
    return sunstoneUniformDouble(x, y);
}
SUNSTONE_RANDOM float curand_uniform(curandStatePhilox4_32_10_t* state) {
    return sunstoneUniform(curand(state));
}
SUNSTONE_RANDOM double curand_uniform_double(curandStatePhilox4_32_10_t* state) {
    return sunstoneUniformDouble(curand(state)); // 53 bits: curand_uniform2_double
}

#define SUNSTONE_MRG_SCALE 2.3283065498378288e-10
SUNSTONE_RANDOM float curand_uniform(curandStateMRG32k3a_t* state) {
    return (float)(curand_MRG32k3a(state) * SUNSTONE_MRG_SCALE);
}
SUNSTONE_RANDOM double curand_uniform_double(curandStateMRG32k3a_t* state) {
    return curand_MRG32k3a(state) * SUNSTONE_MRG_SCALE;
}

#define SUNSTONE_UNIFORM_SOBOL(state_t, high)                                                      \
    SUNSTONE_RANDOM float curand_uniform(state_t* state) {                                         \
        return sunstoneUniform((unsigned int)(curand(state) >> high));                             \
    }                                                                                              \
    SUNSTONE_RANDOM double curand_uniform_double(state_t* state) {                                 \
        return sunstoneUniformDouble(curand(state));                                               \
    }
SUNSTONE_UNIFORM_SOBOL(curandStateSobol32_t, 0)
SUNSTONE_UNIFORM_SOBOL(curandStateScrambledSobol32_t, 0)
SUNSTONE_UNIFORM_SOBOL(curandStateSobol64_t, 32)
SUNSTONE_UNIFORM_SOBOL(curandStateScrambledSobol64_t, 32)
#undef SUNSTONE_UNIFORM_SOBOL

SUNSTONE_RANDOM float4 curand_uniform4(curandStatePhilox4_32_10_t* state) {
    const uint4 x = curand4(state);
    return make_float4(sunstoneUniform(x.x), sunstoneUniform(x.y), sunstoneUniform(x.z),
                       sunstoneUniform(x.w));
}
SUNSTONE_RANDOM double2 curand_uniform2_double(curandStatePhilox4_32_10_t* state) {
    const uint4 x = curand4(state);
    return make_double2(sunstoneUniformDouble(x.x, x.y), sunstoneUniformDouble(x.z, x.w));
}

// ---- Normal -------------------------------------------------------------------------------------
SUNSTONE_RANDOM float2 sunstoneBoxMuller(float u, float v) {
    const float radius = sqrtf(-2.0f * logf(u));
    float sine, cosine;
    sincosf(v, &sine, &cosine);
    return make_float2(radius * sine, radius * cosine);
}
SUNSTONE_RANDOM float2 sunstoneBoxMuller(unsigned int x, unsigned int y) {
    const float turn = 2.3283064e-10f * 6.2831855f;
    return sunstoneBoxMuller(sunstoneUniform(x), y * turn + turn / 2.0f);
}
SUNSTONE_RANDOM double2 sunstoneBoxMullerDouble(double u, double halfTurns) {
    const double radius = sqrt(-2.0 * log(u));
    double sine, cosine;
    sincospi(halfTurns, &sine, &cosine);
    return make_double2(radius * sine, radius * cosine);
}

#define SUNSTONE_NORMAL_OF_BITS(state_t)                                                           \
    SUNSTONE_RANDOM float2 curand_normal2(state_t* state) {                                        \
        const unsigned int x = curand(state), y = curand(state);                                   \
        return sunstoneBoxMuller(x, y);                                                            \
    }                                                                                              \
    SUNSTONE_RANDOM double2 curand_normal2_double(state_t* state) {                                \
        const unsigned int a = curand(state), b = curand(state);                                   \
        const unsigned int c = curand(state), d = curand(state);                                   \
        return sunstoneBoxMullerDouble(sunstoneUniformDouble(a, b),                                \
                                       2.0 * sunstoneUniformDouble(c, d));                         \
    }
SUNSTONE_NORMAL_OF_BITS(curandStateXORWOW_t)
SUNSTONE_NORMAL_OF_BITS(curandStatePhilox4_32_10_t)
#undef SUNSTONE_NORMAL_OF_BITS
SUNSTONE_RANDOM float2 curand_normal2(curandStateMRG32k3a_t* state) {
    const float u = curand_uniform(state);
    return sunstoneBoxMuller(u, curand_uniform(state) * 6.2831855f);
}
SUNSTONE_RANDOM double2 curand_normal2_double(curandStateMRG32k3a_t* state) {
    const double u = curand_uniform_double(state);
    return sunstoneBoxMullerDouble(u, 2.0 * curand_uniform_double(state));
}

#define SUNSTONE_NORMAL_OF_PAIRS(state_t)                                                          \
    SUNSTONE_RANDOM float curand_normal(state_t* state) {                                          \
        if (state->boxmuller_flag) {                                                               \
            state->boxmuller_flag = 0;                                                             \
            return state->boxmuller_extra;                                                         \
        }                                                                                          \
        const float2 pair = curand_normal2(state);                                                 \
        state->boxmuller_flag = 1;                                                                 \
        state->boxmuller_extra = pair.y;                                                           \
        return pair.x;                                                                             \
    }                                                                                              \
    SUNSTONE_RANDOM double curand_normal_double(state_t* state) {                                  \
        if (state->boxmuller_flag_double) {                                                        \
            state->boxmuller_flag_double = 0;                                                      \
            return state->boxmuller_extra_double;                                                  \
        }                                                                                          \
        const double2 pair = curand_normal2_double(state);                                         \
        state->boxmuller_flag_double = 1;                                                          \
        state->boxmuller_extra_double = pair.y;                                                    \
        return pair.x;                                                                             \
    }                                                                                              \
    SUNSTONE_RANDOM float2 curand_log_normal2(state_t* state, float mean, float deviation) {       \
        const float2 pair = curand_normal2(state);                                                 \
        return make_float2(expf(mean + deviation * pair.x), expf(mean + deviation * pair.y));      \
    }                                                                                              \
    SUNSTONE_RANDOM double2 curand_log_normal2_double(state_t* state, double mean,                 \
                                                      double deviation) {                          \
        const double2 pair = curand_normal2_double(state);                                         \
        return make_double2(exp(mean + deviation * pair.x), exp(mean + deviation * pair.y));       \
    }
SUNSTONE_NORMAL_OF_PAIRS(curandStateXORWOW_t)
SUNSTONE_NORMAL_OF_PAIRS(curandStatePhilox4_32_10_t)
SUNSTONE_NORMAL_OF_PAIRS(curandStateMRG32k3a_t)
#undef SUNSTONE_NORMAL_OF_PAIRS

#define SUNSTONE_NORMAL_SOBOL(state_t, high, half)                                                 \
    SUNSTONE_RANDOM float curand_normal(state_t* state) {                                          \
        const unsigned int x = (unsigned int)(curand(state) >> high);                              \
        return (float)normcdfinv(x * 0x1p-32 + 0x1p-33);                                           \
    }                                                                                              \
    SUNSTONE_RANDOM double curand_normal_double(state_t* state) {                                  \
        return normcdfinv(curand_uniform_double(state) - half);                                    \
    }
SUNSTONE_NORMAL_SOBOL(curandStateSobol32_t, 0, 0x1p-33)
SUNSTONE_NORMAL_SOBOL(curandStateScrambledSobol32_t, 0, 0x1p-33)
SUNSTONE_NORMAL_SOBOL(curandStateSobol64_t, 32, 0.0)
SUNSTONE_NORMAL_SOBOL(curandStateScrambledSobol64_t, 32, 0.0)
#undef SUNSTONE_NORMAL_SOBOL

SUNSTONE_RANDOM float4 curand_normal4(curandStatePhilox4_32_10_t* state) {
    const uint4 x = curand4(state);
    const float2 a = sunstoneBoxMuller(x.x, x.y), b = sunstoneBoxMuller(x.z, x.w);
    return make_float4(a.x, a.y, b.x, b.y);
}
SUNSTONE_RANDOM float4 curand_log_normal4(curandStatePhilox4_32_10_t* state, float mean,
                                          float deviation) {
    const float4 n = curand_normal4(state);
    return make_float4(expf(mean + deviation * n.x), expf(mean + deviation * n.y),
                       expf(mean + deviation * n.z), expf(mean + deviation * n.w));
}

// ---- Poisson ------------------------------------------------------------------------------------
static __device__ __noinline__ unsigned int sunstonePoisson(double u, double mean) {
    if (!(mean > 0.0))
        return 0;
    if (mean > 200.0) {
        const double z = normcdfinv(u == 1.0 ? 1.0 - 0x1p-54 * 2 : u), root = sqrt(mean);
        const double k = mean + root * z + (z * z + 2.0) / 6.0 + z * (1.0 - z * z) / (72.0 * root);
        return k < 0.0 ? 0u : k > 4294967295.0 ? 4294967295u : (unsigned int)k;
    }
    double part = exp(-mean), sum = part;
    unsigned int k = 0;
    while (u > sum && k < 1000u) { // no double expresses a probability beyond 1000
        ++k;
        part *= mean / k;
        sum += part;
    }
    return k;
}

// ---- Functions of all generators ----------------------------------------------------------------
#define SUNSTONE_DERIVED(state_t)                                                                  \
    SUNSTONE_RANDOM float curand_log_normal(state_t* state, float mean, float deviation) {         \
        return expf(mean + deviation * curand_normal(state));                                      \
    }                                                                                              \
    SUNSTONE_RANDOM double curand_log_normal_double(state_t* state, double mean,                   \
                                                    double deviation) {                            \
        return exp(mean + deviation * curand_normal_double(state));                                \
    }                                                                                              \
    SUNSTONE_RANDOM unsigned int curand_poisson(state_t* state, double mean) {                     \
        return sunstonePoisson(curand_uniform_double(state), mean);                                \
    }
SUNSTONE_DERIVED(curandStateXORWOW_t)
SUNSTONE_DERIVED(curandStatePhilox4_32_10_t)
SUNSTONE_DERIVED(curandStateMRG32k3a_t)
SUNSTONE_DERIVED(curandStateSobol32_t)
SUNSTONE_DERIVED(curandStateScrambledSobol32_t)
SUNSTONE_DERIVED(curandStateSobol64_t)
SUNSTONE_DERIVED(curandStateScrambledSobol64_t)
#undef SUNSTONE_DERIVED

SUNSTONE_RANDOM uint4 curand_poisson4(curandStatePhilox4_32_10_t* state, double mean) {
    const uint4 x = curand4(state);
    return make_uint4(sunstonePoisson(sunstoneUniformDouble(x.x), mean),
                      sunstonePoisson(sunstoneUniformDouble(x.y), mean),
                      sunstonePoisson(sunstoneUniformDouble(x.z), mean),
                      sunstonePoisson(sunstoneUniformDouble(x.w), mean));
}

#endif
