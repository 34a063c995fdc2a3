// SPDX-License-Identifier: Apache-2.0
// The path tracer as OptiX programs. Paths run in a loop inside ray generation, so that one level
// of tracing is enough; the closest-hit program only reports where a ray ended. The mathematics is
// in shading.h.
#include <optix.h>

#include "params.h"

extern "C" {
__constant__ Params params;
}

namespace {

// Traces rays for tracePath().
struct OptixRays {
    static constexpr float kFar = 1e30f;

    __forceinline__ __device__ Hit closest(float3 origin, float3 direction) const {
        unsigned t = __float_as_uint(-1.0f), triangle = 0, u = 0, v = 0;
        optixTrace(params.traversable, origin, direction, 0.0f, kFar, 0.0f,
                   OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, kRadianceRay, t,
                   triangle, u, v);
        Hit hit;
        hit.t = __uint_as_float(t);
        hit.triangle = triangle;
        hit.u = __uint_as_float(u);
        hit.v = __uint_as_float(v);
        return hit;
    }

    // Any hit ends the ray, and only the miss program writes the payload.
    __forceinline__ __device__ bool visible(float3 origin, float3 direction, float distance) const {
        unsigned visible = 0;
        optixTrace(params.traversable, origin, direction, 0.0f, distance, 0.0f,
                   OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                       OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
                   0, 0, kShadowRay, visible);
        return visible != 0;
    }
};

// OptixRays for meshes with cut-out or blended surfaces.
struct RaysThroughHoles {
    static constexpr float kFar = 1e30f;
    static constexpr unsigned kMostLayers = 256;

    // The first hit that blocks the ray, nearer than `far`.
    __forceinline__ __device__ Hit closest(float3 origin, float3 direction,
                                           float far = kFar) const {
        Hit hit;
        float near = 0.0f;
        for (unsigned layer = 0; layer < kMostLayers; ++layer) {
            unsigned t = __float_as_uint(-1.0f), triangle = 0, u = 0, v = 0;
            optixTrace(params.traversable, origin, direction, near, far, 0.0f,
                       OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, kRadianceRay,
                       t, triangle, u, v);
            hit.t = __uint_as_float(t);
            hit.triangle = triangle;
            hit.u = __uint_as_float(u);
            hit.v = __uint_as_float(v);
            if (hit.t < 0.0f || !passesThrough(params.scene.mesh, hit))
                return hit;
            near = hit.t * 1.000001f + params.scene.epsilon;
        }
        hit.t = -1.0f;
        return hit;
    }

    __forceinline__ __device__ bool visible(float3 origin, float3 direction, float distance) const {
        return closest(origin, direction, distance).t < 0.0f;
    }
};

__forceinline__ __device__ void addTo(float4* sum, float3 value, bool isFirst) {
    float4 old;
    old.x = old.y = old.z = 0.0f;
    if (!isFirst)
        old = *sum;
    old.x += value.x;
    old.y += value.y;
    old.z += value.z;
    old.w = 1.0f;
    *sum = old;
}

// Traces separate rays along the same directions, so that pictures without guides take no
// additional time.
template <class Rays>
__forceinline__ __device__ void addGuides(const Rays& rays, uint3 index, uint3 size,
                                          unsigned sample) {
    unsigned pixel = index.y * size.x + index.x;
    GuideSample guides = sampleGuides(params.scene, rays, params.camera, index.x, index.y, size.x,
                                      size.y, sample, params.seed);
    addTo(&params.guides.albedo[pixel], guides.albedo, sample == 0);
    addTo(&params.guides.normal[pixel], guides.normal, sample == 0);
    float2 now = pixelOf(params.camera, guides.point, size.x, size.y);
    float2 before = pixelOf(params.previousCamera, guides.point, size.x, size.y);
    float2 flow;
    flow.x = now.x - before.x;
    flow.y = now.y - before.y;
    params.guides.flow[pixel] = flow;
}

template <class Rays>
__forceinline__ __device__ void addSamples(const Rays& rays) {
    uint3 index = optixGetLaunchIndex();
    uint3 size = optixGetLaunchDimensions();
    float4* pixel = &params.sum[index.y * size.x + index.x];
    float3 sum = vec(0.0f);
    if (params.firstSample != 0)
        sum = vec(pixel->x, pixel->y, pixel->z);
    for (unsigned i = 0; i < params.sampleCount; ++i)
        sum += samplePixel(params.scene, rays, params.camera, index.x, index.y, size.x, size.y,
                           params.firstSample + i, params.seed);
    if (params.guides.albedo)
        for (unsigned i = 0; i < params.sampleCount; ++i)
            addGuides(rays, index, size, params.firstSample + i);
    pixel->x = sum.x;
    pixel->y = sum.y;
    pixel->z = sum.z;
    pixel->w = 1.0f;
}

} // namespace

extern "C" __global__ void __raygen__paths() {
    addSamples(OptixRays());
}

extern "C" __global__ void __raygen__paths_with_holes() {
    addSamples(RaysThroughHoles());
}

extern "C" __global__ void __miss__radiance() {} // the payload already says so

extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(1);
}

extern "C" __global__ void __closesthit__mesh() {
    float2 weights = optixGetTriangleBarycentrics();
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetPrimitiveIndex());
    optixSetPayload_2(__float_as_uint(weights.x));
    optixSetPayload_3(__float_as_uint(weights.y));
}
