// SPDX-License-Identifier: Apache-2.0
// Device programs of bench_gpu that trace from closest-hit programs, like Whitted's ray tracer:
// mirrors reflect, glass reflects and refracts, and matt surfaces send one ray each to the sun and
// the sky. Payload values: 0 to 2 the colour, 3 the ray's depth, 4 the random state.
#include "recursion.h"

#include "sampling.h"

#include <optix.h>

extern "C" {
__constant__ RecursionParams params;
}

#define DEVICE static __forceinline__ __device__

DEVICE float nextFloat(unsigned& state) {
    const unsigned bits = hashPcg(state);
    state = state * 747796405u + 2891336453u;
    return float(bits >> 8) * (1.0f / 16777216.0f);
}

DEVICE float3 trace(float3 origin, float3 direction, unsigned depth, unsigned random) {
    unsigned red = 0, green = 0, blue = 0;
    optixTrace(params.handle, origin, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, red, green, blue, depth, random);
    return vec(__uint_as_float(red), __uint_as_float(green), __uint_as_float(blue));
}

DEVICE bool seesSun(float3 origin) {
    unsigned hit = 1, unused = 0;
    optixTrace(params.handle, origin, params.sun, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hit, unused, unused, unused, unused);
    return hit == 0;
}

extern "C" __global__ void __raygen__camera() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        unsigned random = hashPcg(pixel) + i * 9781u;
        const float x = 2.0f * (index.x + nextFloat(random)) / size.x - 1.0f;
        const float y = 1.0f - 2.0f * (index.y + nextFloat(random)) / size.y;
        sum += trace(params.eye, normalize(params.forward + params.right * x + params.up * y), 1,
                     random);
    }
    params.image[pixel] = make_float4(sum.x / params.samples, sum.y / params.samples,
                                      sum.z / params.samples, 1.0f);
}

DEVICE float3 skyColor(float3 direction) {
    return lerp(vec(0.95f, 0.9f, 0.85f), vec(0.25f, 0.48f, 0.9f), 0.5f + 0.5f * direction.y);
}
DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}
extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__sun() {
    optixSetPayload_0(0);
}

// The surface's normal on the ray's side, and whether the ray meets the back.
DEVICE float3 hitNormal(bool& back) {
    const uint3 corners = params.triangles[optixGetPrimitiveIndex()];
    const float3 a = params.vertices[corners.x];
    float3 normal = normalize(
        cross(params.vertices[corners.y] - a, params.vertices[corners.z] - a));
    if (normal.y < 0.0f)
        normal = -normal;
    back = dot(normal, optixGetWorldRayDirection()) > 0.0f;
    return back ? -normal : normal;
}
DEVICE float3 hitPoint() {
    return optixGetWorldRayOrigin() + optixGetWorldRayDirection() * optixGetRayTmax();
}
DEVICE float3 reflected(float3 normal) {
    const float3 d = optixGetWorldRayDirection();
    return d - normal * (2.0f * dot(normal, d));
}

extern "C" __global__ void __closesthit__matt() {
    bool back;
    const float3 normal = hitNormal(back), point = hitPoint() + normal * params.epsilon;
    const unsigned depth = optixGetPayload_3();
    unsigned random = optixGetPayload_4();
    float3 light = vec(0.0f);
    const float cosine = dot(normal, params.sun);
    if (cosine > 0.0f && seesSun(point))
        light = vec(1.6f, 1.45f, 1.2f) * cosine;
    if (depth < params.depth) {
        const float u = nextFloat(random), v = nextFloat(random);
        light += trace(point, cosineDirection(normal, u, v), depth + 1, random);
    } else {
        light += skyColor(normal) * 0.4f; // replaces all further bounces
    }
    setColor(light * vec(0.45f, 0.42f, 0.36f));
}

extern "C" __global__ void __closesthit__mirror() {
    bool back;
    const float3 normal = hitNormal(back), point = hitPoint() + normal * params.epsilon;
    const unsigned depth = optixGetPayload_3();
    const float3 color = depth < params.depth
                             ? trace(point, reflected(normal), depth + 1, optixGetPayload_4())
                             : skyColor(normal);
    setColor(color * vec(0.9f, 0.8f, 0.6f));
}

extern "C" __global__ void __closesthit__glass() {
    bool back;
    const float3 normal = hitNormal(back), point = hitPoint(), d = optixGetWorldRayDirection();
    const unsigned depth = optixGetPayload_3(), random = optixGetPayload_4();
    if (depth >= params.depth)
        return setColor(skyColor(normal) * 0.4f);
    const float cosine = -dot(normal, d), ratio = back ? 1.3f : 1.0f / 1.3f;
    const float squared = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
    float share = 1.0f; // of reflected light: Schlick's approximation
    float3 color = vec(0.0f);
    if (squared > 0.0f) {
        const float c = 1.0f - cosine;
        share = 0.02f + 0.98f * c * c * c * c * c;
        const float3 through = d * ratio + normal * (ratio * cosine - sqrtf(squared));
        color = trace(point - normal * params.epsilon, through, depth + 1, random + 1) *
                (1.0f - share);
    }
    color += trace(point + normal * params.epsilon, reflected(normal), depth + 1, random) * share;
    setColor(color);
}
