// SPDX-License-Identifier: Apache-2.0
// A city in haze. Closest-hit programs shade walls and windows with the material of the instance,
// and trace shadow rays and reflections; the miss program computes the sky. Ray generation gathers
// sunlight in the haze. Payload: colour, distance, depth, random state.
#include "city.h"
#include "tools.h"

extern "C" {
__constant__ HazeParams params;
}

struct Seen {
    float3 color;
    float distance;
};

DEVICE float3 skyTowards(float3 direction) {
    const float height = fmaxf(direction.y, 0.0f);
    const float towards = fmaxf(dot(direction, params.sun), 0.0f);
    const float3 blue = lerp(vec(0.85f, 0.75f, 0.62f), vec(0.2f, 0.38f, 0.75f), sqrtf(height));
    return blue +
           vec(1.0f, 0.65f, 0.3f) * (0.5f * powf(towards, 12.0f) + 8.0f * powf(towards, 2000.0f));
}

DEVICE float sunReaches(float3 from) {
    unsigned lit = 0, unused = 0;
    optixTrace(params.city, from, params.sun, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 0, 1, unused, unused, unused, lit, unused, unused);
    return lit ? 1.0f : 0.0f;
}
DEVICE Seen look(float3 from, float3 direction, unsigned depth, unsigned& random) {
    unsigned r, g, b, distance;
    optixTrace(params.city, from, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, 0, r, g, b, distance, depth, random);
    return {vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b)),
            __uint_as_float(distance)};
}
DEVICE void answer(float3 color, float distance) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
    optixSetPayload_3(__float_as_uint(distance));
}

extern "C" __global__ void __miss__sky() {
    answer(skyTowards(optixGetWorldRayDirection()), 1e16f);
}
extern "C" __global__ void __miss__lit() {
    optixSetPayload_3(1);
}

// The number of the window at a point of a wall, or 0.
DEVICE unsigned windowAt(float3 point, float3 normal, float storey) {
    const float3 side = normalize(cross(normal, vec(0.0f, 1.0f, 0.0f)));
    const float x = dot(point, side) / storey, y = point.y / storey;
    const float column = x - floorf(x), row = y - floorf(y);
    if (column < 0.2f || column > 0.85f || row < 0.25f || row > 0.85f)
        return 0;
    return hashPcg(static_cast<unsigned>(static_cast<int>(floorf(x)) * 7919 +
                                         static_cast<int>(floorf(y)) * 104729)) |
           1;
}

extern "C" __global__ void __closesthit__facade() {
    const auto* r = reinterpret_cast<const HazeRecord*>(optixGetSbtDataPointer());
    const HazeMaterial& m = params.materials[optixGetInstanceId()];
    const unsigned depth = optixGetPayload_4();
    unsigned random = optixGetPayload_5();
    const float3 direction = optixGetWorldRayDirection(), point = rayPoint();
    const float3 local = r->mesh.normal(optixGetPrimitiveIndex());
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    const unsigned window =
        m.storey > 0.0f && fabsf(normal.y) < 0.5f ? windowAt(point, normal, m.storey) : 0;
    const float3 from = point + normal * 2e-3f;
    float3 light = skyTowards(normal) * (0.35f + 0.15f * normal.y);
    const float cosine = dot(normal, params.sun);
    if (cosine > 0.0f)
        light += vec(3.0f, 2.4f, 1.7f) * (cosine * sunReaches(from));
    float3 color = (window ? m.glass : m.wall) * light;
    if (window) {
        const float edge = 1.0f + dot(direction, normal), squared = edge * edge;
        const float mirrored = 0.08f + 0.92f * squared * squared * edge;
        const float lamp = (window >> 8) * (1.0f / 16777216.0f) < m.lampShare ? 0.9f : 0.0f;
        color += vec(1.0f, 0.75f, 0.4f) * lamp;
        if (depth < params.maxDepth)
            color = lerp(color, look(from, reflect(direction, normal), depth + 1, random).color,
                         mirrored);
    }
    answer(color, optixGetRayTmax());
    optixSetPayload_5(random);
}

// Adds haze between the eye and a distance: sunlight at points that the sun reaches.
DEVICE float3 addHaze(float3 color, float3 from, float3 direction, float distance,
                      unsigned& random) {
    const float end = fminf(distance, 900.0f), step = end / params.hazeSteps;
    const float towards = dot(direction, params.sun);
    const float phase = 0.25f + 0.9f * powf(fmaxf(0.5f + 0.5f * towards, 0.0f), 8.0f);
    float passes = 1.0f;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.hazeSteps; ++i) {
        const float3 point = from + direction * (step * (i + nextFloat(random)));
        const float density = params.haze * expf(-fmaxf(point.y, 0.0f) / params.hazeHeight);
        const float stays = expf(-density * step);
        const float3 light =
            vec(0.35f, 0.4f, 0.5f) + vec(1.5f, 1.15f, 0.8f) * (phase * sunReaches(point));
        sum += light * (passes * (1.0f - stays));
        passes *= stays;
    }
    return color * passes + sum;
}

extern "C" __global__ void __raygen__city() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float3 direction = cameraDirection(params.camera, x, y);
        const Seen seen = look(params.camera.eye, direction, 0, random);
        sum += addHaze(seen.color, params.camera.eye, direction, seen.distance, random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
