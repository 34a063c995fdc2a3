// SPDX-License-Identifier: Apache-2.0
// Every path of a pixel has its own time within the exposure. Hit programs query the structure for
// the triangle's corners at the ray's time, and the transform list for the transforms above it.
// Payload values: 0 to 2 the colour, 3 the number of the bounce and 4 the random state.
#include <optix.h>

#include "params.h"
#include "sampling.h"

extern "C" {
__constant__ Params params;
}

#define DEVICE static __forceinline__ __device__

DEVICE float nextFloat(unsigned& state) {
    unsigned bits = hashPcg(state);
    state = state * 747796405u + 2891336453u;
    return float(bits >> 8) * (1.0f / 16777216.0f);
}

DEVICE float3 skyColor(float3 direction) {
    float height = 0.5f + 0.5f * direction.y;
    return lerp(vec(0.95f, 0.9f, 0.85f), vec(0.25f, 0.48f, 0.9f), height) * 0.7f;
}

DEVICE float3 trace(float3 origin, float3 direction, float time, unsigned bounce, unsigned random) {
    unsigned red = 0, green = 0, blue = 0;
    optixTrace(params.scene, origin, direction, 0.0f, 1e16f, time, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, red, green, blue, bounce, random);
    return vec(__uint_as_float(red), __uint_as_float(green), __uint_as_float(blue));
}

DEVICE bool seesSun(float3 origin, float time) {
    unsigned hit = 1, unused = 0;
    optixTrace(params.scene, origin, params.sunDirection, 0.0f, 1e16f, time,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hit, unused, unused, unused, unused);
    return hit == 0;
}

extern "C" __global__ void __raygen__camera() {
    uint3 index = optixGetLaunchIndex();
    uint3 size = optixGetLaunchDimensions();
    unsigned pixel = index.y * size.x + index.x;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        unsigned random = hashPcg(pixel) + i * 9781u;
        float x = (index.x + nextFloat(random)) / size.x;
        float y = (index.y + nextFloat(random)) / size.y;
        // One time from each part of the exposure, which gives less noise than independent random
        // times.
        float time = (i + nextFloat(random)) / params.samples;
        sum += trace(params.camera.eye, cameraDirection(params.camera, x, y), time, 0, random);
    }
    float4 color;
    color.x = sum.x / params.samples;
    color.y = sum.y / params.samples;
    color.z = sum.z / params.samples;
    color.w = 1.0f;
    params.image[pixel] = color;
}

DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}

extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}

extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(0);
}

DEVICE float3 hitPoint() {
    return optixGetWorldRayOrigin() + optixGetWorldRayDirection() * optixGetRayTmax();
}

// Sun, and two diffuse bounces that replace all others.
DEVICE void shade(float3 color, float3 normal) {
    if (dot(normal, optixGetWorldRayDirection()) > 0.0f)
        normal = -normal;
    float time = optixGetRayTime();
    float3 point = hitPoint() + normal * params.epsilon;
    float3 light = vec(0.0f);
    float cosine = dot(normal, params.sunDirection);
    if (cosine > 0.0f && seesSun(point, time))
        light = vec(1.6f, 1.45f, 1.2f) * cosine;
    unsigned bounce = optixGetPayload_3(), random = optixGetPayload_4();
    if (bounce < 2) {
        float u = nextFloat(random), v = nextFloat(random);
        light += trace(point, cosineDirection(normal, u, v), time, bounce + 1, random);
    } else {
        light += skyColor(normal) * 0.4f; // in place of all further bounces
    }
    setColor(color * light);
}

DEVICE const HitData& hitData() {
    return *reinterpret_cast<const HitData*>(optixGetSbtDataPointer());
}

extern "C" __global__ void __closesthit__mesh() {
    float3 corners[3];
    optixGetTriangleVertexData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                               optixGetSbtGASIndex(), optixGetRayTime(), corners);
    float3 normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    shade(hitData().color, normalize(optixTransformNormalFromObjectToWorldSpace(normal)));
}

extern "C" __global__ void __closesthit__ground() {
    float3 point = hitPoint();
    int cells = int(floorf(point.x * 0.5f)) + int(floorf(point.z * 0.5f));
    shade(cells & 1 ? hitData().color : hitData().color * 0.45f, vec(0.0f, 1.0f, 0.0f));
}

// Between two keys the ball moves along a straight line, as its box does.
DEVICE float3 ballCenter() {
    float place = clamp01(optixGetRayTime()) * (kBallKeys - 1);
    unsigned key = unsigned(minOf(place, kBallKeys - 2.0f));
    return lerp(hitData().ball[key], hitData().ball[key + 1], place - key);
}

extern "C" __global__ void __intersection__ball() {
    float3 direction = optixGetObjectRayDirection();
    float scale = 1.0f / length(direction);
    direction = direction * scale;
    float3 toOrigin = optixGetObjectRayOrigin() - ballCenter();
    float middle = -dot(toOrigin, direction);
    float3 nearest = toOrigin + direction * middle;
    float halfChordSquared = hitData().radius * hitData().radius - dot(nearest, nearest);
    if (halfChordSquared < 0.0f)
        return;
    float halfChord = sqrtf(halfChordSquared);
    if (!optixReportIntersection((middle - halfChord) * scale, 0))
        optixReportIntersection((middle + halfChord) * scale, 0);
}

extern "C" __global__ void __closesthit__ball() {
    float3 point = optixTransformPointFromWorldToObjectSpace(hitPoint());
    float3 normal = optixTransformNormalFromObjectToWorldSpace(point - ballCenter());
    shade(hitData().color, normalize(normal));
}
