// SPDX-License-Identifier: Apache-2.0
// Ellipsoids, hyperboloids, cones and tubes with patterns of holes. The intersection program
// reports both walls of a quadric, any-hit programs compute the holes; for shadow rays they count
// the walls that light shines through. Attributes: turns around the axis and height of the hit.
// Payload: distance, normal, colour; for shadow rays the number of walls.
#include "latticework.h"
#include "tools.h"

extern "C" {
__constant__ LatticeParams params;
}

struct WallHit {
    float distance; // negative: none
    float3 normal, color;
};

DEVICE const LatticeShell& shellOfRay() {
    const auto* r = reinterpret_cast<const LatticeRecord*>(optixGetSbtDataPointer());
    return r->shells[optixGetPrimitiveIndex()];
}
DEVICE float3 inUnits(float3 v, float3 axes) {
    return vec(v.x / axes.x, v.y / axes.y, v.z / axes.z);
}

extern "C" __global__ void __intersection__shell() {
    const LatticeShell& s = shellOfRay();
    const float3 from = inUnits(optixGetObjectRayOrigin() - s.at, s.axes);
    const float3 d = inUnits(optixGetObjectRayDirection(), s.axes);
    const float a = d.x * d.x + d.z * d.z + s.bend * d.y * d.y;
    const float b = from.x * d.x + from.z * d.z + s.bend * from.y * d.y;
    const float c = from.x * from.x + from.z * from.z + s.bend * from.y * from.y - s.size;
    const float squared = b * b - a * c;
    if (squared < 0.0f)
        return;
    // The form without cancellation: one root is q / a, the other c / q.
    const float q = -(b + copysignf(sqrtf(squared), b));
    const float first = fabsf(a) > 1e-9f ? q / a : 1e30f, second = q != 0.0f ? c / q : 1e30f;
    for (int i = 0; i < 2; ++i) {
        const float t = i == 0 ? fminf(first, second) : fmaxf(first, second);
        const float3 p = from + d * t;
        if (t <= optixGetRayTmin() || t >= optixGetRayTmax() || p.y < s.low || p.y > s.high)
            continue;
        const float turns = atan2f(p.z, p.x) * (0.5f / kPi) + 0.5f;
        if (optixReportIntersection(t, 0, __float_as_uint(turns), __float_as_uint(p.y)))
            return;
    }
}

DEVICE float fraction(float x) {
    return x - floorf(x);
}
// Whether the wall has a hole at the attributes of the hit.
DEVICE bool isHole() {
    const LatticeShell& s = shellOfRay();
    const float x = __uint_as_float(optixGetAttribute_0()) * s.columns,
                y = __uint_as_float(optixGetAttribute_1()) * s.rows;
    const int row = static_cast<int>(floorf(y));
    switch (s.pattern) {
    case kRoundHoles: {
        const float u = fraction(x + (row & 1 ? 0.5f : 0.0f)) - 0.5f, v = fraction(y) - 0.5f;
        return u * u + v * v < 0.14f;
    }
    case kDiamonds:
        return fabsf(fraction(x + y) - 0.5f) < 0.36f && fabsf(fraction(x - y) - 0.5f) < 0.36f;
    case kSpirals:
        return fraction(x + 0.5f * y + 0.08f * sinf(2.0f * kPi * y)) < 0.55f;
    case kCrumbs: {
        const int column = static_cast<int>(floorf(x));
        return (hashPcg(static_cast<unsigned>(column * 7919 + row * 104729)) & 255) < 115;
    }
    default:
        return false;
    }
}
extern "C" __global__ void __anyhit__cut() {
    if (isHole())
        optixIgnoreIntersection();
}
extern "C" __global__ void __anyhit__count() {
    unsigned layers = optixGetPayload_0();
    if (!isHole())
        optixSetPayload_0(++layers);
    if (layers >= params.maxLayers)
        optixTerminateRay();
    else
        optixIgnoreIntersection();
}

DEVICE void answer(float3 normal, float3 color) {
    normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(normal)));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(__float_as_uint(normal.x));
    optixSetPayload_2(__float_as_uint(normal.y));
    optixSetPayload_3(__float_as_uint(normal.z));
    optixSetPayload_4(__float_as_uint(color.x));
    optixSetPayload_5(__float_as_uint(color.y));
    optixSetPayload_6(__float_as_uint(color.z));
}
extern "C" __global__ void __closesthit__shell() {
    const LatticeShell& s = shellOfRay();
    const float3 local = optixTransformPointFromWorldToObjectSpace(rayPoint());
    const float3 p = inUnits(local - s.at, s.axes);
    answer(inUnits(vec(p.x, s.bend * p.y, p.z), s.axes), s.color);
}
extern "C" __global__ void __closesthit__floor() {
    const float3 p = rayPoint();
    const int tile = static_cast<int>(floorf(0.5f * p.x)) + static_cast<int>(floorf(0.5f * p.z));
    answer(vec(0.0f, 1.0f, 0.0f), tile & 1 ? vec(0.72f, 0.68f, 0.6f) : vec(0.5f, 0.46f, 0.4f));
}
extern "C" __global__ void __miss__sky() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}

DEVICE WallHit find(float3 from, float3 direction) {
    unsigned p[7];
    optixTrace(params.court, from, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_NONE, 0, 2, 0, p[0], p[1], p[2], p[3], p[4], p[5], p[6]);
    return {__uint_as_float(p[0]),
            vec(__uint_as_float(p[1]), __uint_as_float(p[2]), __uint_as_float(p[3])),
            vec(__uint_as_float(p[4]), __uint_as_float(p[5]), __uint_as_float(p[6]))};
}
// Each wall, of paper, passes a part of the light. The floor is in no way.
DEVICE float arriving(float3 from, float3 direction, float distance) {
    unsigned layers = 0, unused = 0;
    optixTrace(params.court, from, direction, 1e-3f, distance, 0.0f, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 1, 2, 1, layers, unused, unused, unused, unused,
               unused, unused);
    return layers >= params.maxLayers ? 0.0f : powf(0.3f, static_cast<float>(layers));
}
DEVICE float3 shade(const WallHit& hit, float3 from, float3 direction, unsigned& random) {
    const float3 point = from + direction * hit.distance + hit.normal * 2e-3f;
    float3 light = blueSky(hit.normal) * 0.32f;
    for (unsigned i = 0; i < params.sunRays; ++i) {
        const float2 c = circlePoint(nextFloat(random));
        const float r = params.softness * sqrtf(nextFloat(random));
        const float3 towards = normalize(params.sun + vec(r * c.x, 0.0f, r * c.y));
        const float cosine = dot(hit.normal, towards);
        if (cosine > 0.0f)
            light += vec(1.35f, 1.2f, 0.95f) *
                     (cosine * arriving(point, towards, 1e16f) / params.sunRays);
    }
    const float3 to = params.lamp - point;
    const float far = length(to), cosine = dot(hit.normal, to) / far;
    if (cosine > 0.0f)
        light += vec(1.0f, 0.75f, 0.45f) *
                 (12.0f * cosine / (far * far) * arriving(point, to / far, far));
    return hit.color * light;
}

extern "C" __global__ void __raygen__court() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float3 direction = cameraDirection(params.camera, x, y);
        const WallHit hit = find(params.camera.eye, direction);
        sum += hit.distance < 0.0f ? blueSky(direction)
                                   : shade(hit, params.camera.eye, direction, random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
