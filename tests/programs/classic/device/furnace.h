// SPDX-License-Identifier: Apache-2.0
// What both sides of furnace.cpp share.
#pragma once

#include <optixu/optixu_math_namespace.h>

#ifdef __CUDACC__
#define FURNACE_FUNCTION static __host__ __device__ __inline__
#else
#define FURNACE_FUNCTION static inline
#endif

// Ids alone: of a callable program, a texture sampler and a buffer.
struct MaterialRecord {
    int scatter, texture, light, unused;
};

FURNACE_FUNCTION float furnaceRandom(unsigned& seed) {
    seed = seed * 1664525u + 1013904223u;
    unsigned mixed = (seed ^ (seed >> 15)) * 2246822519u;
    mixed ^= mixed >> 13;
    return float(mixed >> 8) * (1.0f / 16777216.0f);
}

// A direction about the normal of a wall by two random numbers.
FURNACE_FUNCTION optix::float3 furnaceScatter(const optix::float3& normal, float u, float v) {
    using namespace optix;
    const float z = 1.0f - 1.8f * v, turn = 6.2831853f * u;
    const float r = sqrtf(fmaxf(0.0f, 1.0f - z * z));
    const float3 sphere = make_float3(r * cosf(turn), r * sinf(turn), z);
    return normalize(normal * 1.001f + sphere);
}
