// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "denoise_loop.h"

extern "C" __constant__ Params params;

static __forceinline__ __device__ unsigned hashed(unsigned x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// No rays: the ray generation program draws a picture that moves, and noise.
extern "C" __global__ void __raygen__draw() {
    const uint3 at = optixGetLaunchIndex();
    const unsigned i = at.y * params.width + at.x;
    const float x = at.x + params.shift, y = at.y;
    const bool dark = (int(floorf(x / 16)) + int(floorf(y / 16))) & 1;
    const float4 albedo = dark ? make_float4(.2f, .3f, .6f, 1) : make_float4(.8f, .7f, .4f, 1);
    const float light = 0.5f + 0.5f * sinf(0.05f * x) * cosf(0.04f * y);
    const float noise = (hashed(i * 977u + params.frame * 7919u) >> 8) * (2.0f / 16777216.0f);
    params.beauty[i] =
        make_float3(albedo.x * light * noise, albedo.y * light * noise, albedo.z * light * noise);
    params.albedo[i] = albedo;
    float* normal = params.normal + at.y * params.normalRow + 3 * at.x;
    normal[0] = 0;
    normal[1] = 0;
    normal[2] = 1;
    params.flow[i] = make_float2(params.frame ? 2.0f : 0.0f, 0);
}
extern "C" __global__ void __miss__none() {}
