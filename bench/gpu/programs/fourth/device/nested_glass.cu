// SPDX-License-Identifier: Apache-2.0
// Drinks with ice and bubbles in glasses: transparent bodies overlap, and the medium with the
// highest priority counts. Closest-hit programs move the whole state of a path, which the payload
// carries; shadow rays collect the absorption between all entries and exits.
#include "nested_glass.h"
#include "tools.h"

extern "C" {
__constant__ NestedParams params;
}

constexpr OptixPayloadTypeID kPath = OPTIX_PAYLOAD_TYPE_ID_0, kShade = OPTIX_PAYLOAD_TYPE_ID_1;

// The payload of paths.
struct Path {
    float3 origin, direction, weight, light;
    unsigned inside; // four bits for each medium: how many of its bodies the origin is in
    unsigned random;
    unsigned isOver;
};

DEVICE const NestedRecord& record() {
    return *reinterpret_cast<const NestedRecord*>(optixGetSbtDataPointer());
}
DEVICE float3 worldNormal() {
    const float3 local = record().mesh.normal(optixGetPrimitiveIndex());
    return normalize(optixTransformNormalFromObjectToWorldSpace(local));
}
DEVICE float3 vectorOf(unsigned x, unsigned y, unsigned z) {
    return vec(__uint_as_float(x), __uint_as_float(y), __uint_as_float(z));
}
DEVICE Path getPath() {
    Path p;
    p.weight = vectorOf(optixGetPayload_6(), optixGetPayload_7(), optixGetPayload_8());
    p.light = vectorOf(optixGetPayload_9(), optixGetPayload_10(), optixGetPayload_11());
    p.inside = optixGetPayload_12();
    p.random = optixGetPayload_13();
    p.isOver = 0;
    return p;
}
DEVICE void setPath(const Path& p) {
    optixSetPayload_0(__float_as_uint(p.origin.x));
    optixSetPayload_1(__float_as_uint(p.origin.y));
    optixSetPayload_2(__float_as_uint(p.origin.z));
    optixSetPayload_3(__float_as_uint(p.direction.x));
    optixSetPayload_4(__float_as_uint(p.direction.y));
    optixSetPayload_5(__float_as_uint(p.direction.z));
    optixSetPayload_6(__float_as_uint(p.weight.x));
    optixSetPayload_7(__float_as_uint(p.weight.y));
    optixSetPayload_8(__float_as_uint(p.weight.z));
    optixSetPayload_9(__float_as_uint(p.light.x));
    optixSetPayload_10(__float_as_uint(p.light.y));
    optixSetPayload_11(__float_as_uint(p.light.z));
    optixSetPayload_12(p.inside);
    optixSetPayload_13(p.random);
    optixSetPayload_14(p.isOver);
}

// The medium that counts.
DEVICE unsigned mediumOf(unsigned inside) {
    return inside ? (__ffs(inside) - 1) / 4 : kMedia;
}
DEVICE float3 passing(float3 absorption, float length) {
    return vec(expf(-absorption.x * length), expf(-absorption.y * length),
               expf(-absorption.z * length));
}
DEVICE float mirroredShare(float cosine, float ratio, float squared) {
    if (squared >= 1.0f)
        return 1.0f;
    const float other = sqrtf(1.0f - squared);
    const float s = (ratio * cosine - other) / (ratio * cosine + other);
    const float p = (ratio * other - cosine) / (ratio * other + cosine);
    return 0.5f * (s * s + p * p);
}

extern "C" __global__ void __closesthit__body() {
    optixSetPayloadTypes(kPath);
    Path path = getPath();
    const bool isEntry = optixIsTriangleFrontFaceHit();
    const unsigned one = 1u << 4 * record().medium;
    const unsigned before = mediumOf(path.inside);
    const unsigned beyond = isEntry                     ? path.inside + one
                            : path.inside & (15u * one) ? path.inside - one
                                                        : path.inside;
    const unsigned after = mediumOf(beyond);
    const float3 normal = isEntry ? worldNormal() : -worldNormal();
    path.weight *= passing(params.media[before].absorption, optixGetRayTmax());
    path.direction = optixGetWorldRayDirection();
    path.origin = rayPoint();
    const float ratio = params.media[before].index / params.media[after].index;
    const float cosine = -dot(path.direction, normal);
    const float squared = ratio * ratio * (1.0f - cosine * cosine);
    if (before != after && nextFloat(path.random) < mirroredShare(cosine, ratio, squared)) {
        path.direction = reflect(path.direction, normal);
        path.origin += normal * 1e-4f;
    } else {
        if (before != after)
            path.direction = normalize(path.direction * ratio +
                                       normal * (ratio * cosine - sqrtf(1.0f - squared)));
        path.origin = path.origin - normal * 1e-4f;
        path.inside = beyond;
    }
    setPath(path);
}

DEVICE float3 lampLight(float3 point, float3 normal, unsigned& random) {
    const float u = nextFloat(random), v = nextFloat(random);
    const float3 to = params.lamp[0] + params.lamp[1] * u + params.lamp[2] * v - point;
    const float distance = length(to), squared = distance * distance;
    const float3 direction = to / distance, area = cross(params.lamp[1], params.lamp[2]);
    const float cosine = dot(normal, direction);
    if (cosine <= 0.0f)
        return vec(0.0f);
    unsigned r = 0, g = 0, b = 0, isBlocked = 0;
    optixTrace(kShade, params.table, point, direction, 0.0f, distance * 0.999f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 1, 2, 1, r, g, b,
               isBlocked);
    if (isBlocked)
        return vec(0.0f);
    const float3 depth = vectorOf(r, g, b);
    return params.emission *
           passing(vec(fmaxf(depth.x, 0.0f), fmaxf(depth.y, 0.0f), fmaxf(depth.z, 0.0f)), 1.0f) *
           (cosine * fabsf(dot(area, direction)) / (kPi * squared));
}

extern "C" __global__ void __closesthit__solid() {
    optixSetPayloadTypes(kPath);
    Path path = getPath();
    const float3 normal = towardsRay(worldNormal());
    path.weight *= passing(params.media[mediumOf(path.inside)].absorption, optixGetRayTmax());
    path.origin = rayPoint() + normal * 1e-4f;
    float3 color = record().color;
    if (record().isTiled) {
        const int tile = static_cast<int>(floorf(path.origin.x * 2.0f)) +
                         static_cast<int>(floorf(path.origin.z * 2.0f));
        color = color * (tile & 1 ? 1.0f : 0.55f);
    }
    path.weight *= color;
    path.light += path.weight * lampLight(path.origin, normal, path.random);
    const float u = nextFloat(path.random), v = nextFloat(path.random);
    path.direction = cosineDirection(normal, u, v);
    setPath(path);
}
extern "C" __global__ void __miss__room() {
    optixSetPayloadTypes(kPath);
    Path path = getPath();
    const float3 d = optixGetWorldRayDirection();
    const bool isBright = d.y > 0.1f && d.y < 0.75f && fabsf(d.x) < 0.35f && d.z > 0.0f;
    const float3 wall = lerp(vec(0.16f, 0.15f, 0.14f), vec(0.4f, 0.42f, 0.45f), clamp01(d.y));
    path.light += path.weight * (isBright ? vec(1.2f, 1.3f, 1.5f) : wall);
    path.origin = path.direction = vec(0.0f);
    path.isOver = 1;
    setPath(path);
}

extern "C" __global__ void __anyhit__body() {
    optixSetPayloadTypes(kShade);
    const float t = optixIsTriangleFrontFaceHit() ? -optixGetRayTmax() : optixGetRayTmax();
    // Reflections at both faces take a little of the light.
    const float3 depth = params.media[record().medium].absorption * t + vec(0.03f);
    optixSetPayload_0(__float_as_uint(__uint_as_float(optixGetPayload_0()) + depth.x));
    optixSetPayload_1(__float_as_uint(__uint_as_float(optixGetPayload_1()) + depth.y));
    optixSetPayload_2(__float_as_uint(__uint_as_float(optixGetPayload_2()) + depth.z));
    optixIgnoreIntersection();
}
extern "C" __global__ void __anyhit__solid() {
    optixSetPayloadTypes(kShade);
    optixSetPayload_3(1);
    optixTerminateRay();
}

DEVICE float3 follow(float3 origin, float3 direction, unsigned& random) {
    unsigned p[15] = {__float_as_uint(origin.x),    __float_as_uint(origin.y),
                      __float_as_uint(origin.z),    __float_as_uint(direction.x),
                      __float_as_uint(direction.y), __float_as_uint(direction.z)};
    for (unsigned i = 6; i < 9; ++i)
        p[i] = __float_as_uint(1.0f);
    p[13] = random;
    for (unsigned depth = 0; depth < params.maxDepth && p[14] == 0; ++depth) {
        if (fmaxf(__uint_as_float(p[6]), fmaxf(__uint_as_float(p[7]), __uint_as_float(p[8]))) <
            5e-3f)
            break;
        optixTrace(kPath, params.table, vectorOf(p[0], p[1], p[2]), vectorOf(p[3], p[4], p[5]),
                   0.0f, 1e16f, 0.0f, OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 2,
                   0, p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11],
                   p[12], p[13], p[14]);
    }
    random = p[13];
    return vectorOf(p[9], p[10], p[11]);
}

extern "C" __global__ void __raygen__drinks() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        sum += follow(params.camera.eye, cameraDirection(params.camera, x, y), random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
