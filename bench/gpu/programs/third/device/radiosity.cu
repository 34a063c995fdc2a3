// SPDX-License-Identifier: Apache-2.0
// Form factors of pairs of patches, and the picture of their light. Payload: patch, presence.
#include "radiosity.h"
#include "tools.h"

extern "C" {
__constant__ RadiosityParams params;
}

extern "C" __global__ void __closesthit__patch() {
    optixSetPayload_0(optixGetPrimitiveIndex() / 2);
}
extern "C" __global__ void __miss__none() {
    optixSetPayload_1(0);
}

DEVICE float3 pointOn(const Patch& patch, unsigned& random) {
    const float s = nextFloat(random), t = nextFloat(random);
    return patch.corner + patch.u * s + patch.v * t;
}

// Launch index: the patch that sees, the patch that is seen.
extern "C" __global__ void __raygen__formFactors() {
    const uint3 index = optixGetLaunchIndex();
    const Patch& from = params.patches[index.y];
    const Patch& to = params.patches[index.x];
    unsigned random = hashPcg(index.y * params.count + index.x);
    float sum = 0.0f;
    for (unsigned i = 0; i < params.samples; ++i) {
        const float3 a = pointOn(from, random), line = pointOn(to, random) - a;
        const float squared = dot(line, line);
        const float here = dot(from.normal, line), there = -dot(to.normal, line);
        if (here <= 0.0f || there <= 0.0f)
            continue;
        unsigned patch = 0, hidden = 1;
        optixTrace(params.room, a, line, 1e-3f, 0.999f, 0.0f, OptixVisibilityMask(1),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                       OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
                   0, 1, 0, patch, hidden);
        if (!hidden)
            sum += here * there / (kPi * squared * squared + to.area * squared);
    }
    params.factors[static_cast<size_t>(index.y) * params.count + index.x] =
        sum * to.area / params.samples;
}

extern "C" __global__ void __raygen__view() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    constexpr unsigned kAcross = 2;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < kAcross * kAcross; ++i) {
        const float x = index.x + (i % kAcross + 0.5f) / kAcross;
        const float y = index.y + (i / kAcross + 0.5f) / kAcross;
        unsigned patch = 0, isHit = 1;
        optixTrace(params.room, params.camera.eye,
                   cameraDirection(params.camera, x / size.x, y / size.y), 0.0f, 1e16f, 0.0f,
                   OptixVisibilityMask(1), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, patch, isHit);
        if (isHit)
            sum += vec(params.light[patch].x, params.light[patch].y, params.light[patch].z);
    }
    params.image[index.y * size.x + index.x] = withWeight(sum / float(kAcross * kAcross), 1.0f);
}
