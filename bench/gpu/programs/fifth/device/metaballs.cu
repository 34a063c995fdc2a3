// SPDX-License-Identifier: Apache-2.0
// Drops of molten metal and wax as sums of fields. The intersection program walks through the box
// of a drop and bisects where the field passes the level. Closest-hit programs trace shadow rays,
// and reflections down to a depth. Payload: colour, depth; for shadow rays whether the ray is open.
#include "metaballs.h"
#include "tools.h"

extern "C" {
__constant__ MetaballParams params;
}

constexpr float kLevel = 0.25f;
constexpr int kHalvings = 9;

DEVICE const MetaballDrop& dropOfRay() {
    const auto* r = reinterpret_cast<const MetaballRecord*>(optixGetSbtDataPointer());
    return r->drops[optixGetPrimitiveIndex()];
}
// (1 - distance^2 / radius^2)^3 of each ball.
DEVICE float fieldAt(const MetaballDrop& drop, float3 p) {
    float sum = -kLevel;
    for (unsigned i = 0; i < kBlobsOfDrop; ++i) {
        const float3 from = p - drop.centers[i];
        const float inside = 1.0f - dot(from, from) / (drop.radii[i] * drop.radii[i]);
        if (inside > 0.0f)
            sum += inside * inside * inside;
    }
    return sum;
}
// The normal, and how much of the second colour the place has.
DEVICE float3 slopeAt(const MetaballDrop& drop, float3 p, float& second) {
    float3 sum = vec(0.0f);
    float total = 1e-6f, part = 0.0f;
    for (unsigned i = 0; i < kBlobsOfDrop; ++i) {
        const float3 from = p - drop.centers[i];
        const float scale = 1.0f / (drop.radii[i] * drop.radii[i]);
        const float inside = fmaxf(1.0f - dot(from, from) * scale, 0.0f);
        sum += from * (inside * inside * scale);
        total += inside * inside * inside;
        part += i & 1 ? inside * inside * inside : 0.0f;
    }
    second = part / total;
    return normalize(sum + vec(0.0f, 1e-12f, 0.0f));
}
// The part of the ray near a ball of the drop.
DEVICE bool clip(const MetaballDrop& drop, float3 origin, float3 d, float& from, float& to) {
    float first = 1e30f, last = -1e30f;
    for (unsigned i = 0; i < kBlobsOfDrop; ++i) {
        const float3 off = origin - drop.centers[i];
        const float b = dot(off, d);
        const float squared = b * b - dot(off, off) + drop.radii[i] * drop.radii[i];
        if (squared <= 0.0f)
            continue;
        const float half = sqrtf(squared);
        first = fminf(first, -b - half);
        last = fmaxf(last, half - b);
    }
    from = fmaxf(first, from);
    to = fminf(last, to);
    return from < to;
}

extern "C" __global__ void __intersection__drop() {
    const MetaballDrop& drop = dropOfRay();
    const float3 origin = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    float from = optixGetRayTmin(), to = optixGetRayTmax();
    if (!clip(drop, origin, d, from, to))
        return;
    const float step = (to - from) / params.steps;
    float before = fieldAt(drop, origin + d * from), t = from;
    for (unsigned i = 1; i <= params.steps; ++i, t += step) {
        const float after = fieldAt(drop, origin + d * (from + step * i));
        if ((before < 0.0f) == (after < 0.0f))
            continue;
        float low = t, high = from + step * i;
        for (int k = 0; k < kHalvings; ++k) {
            const float middle = 0.5f * (low + high);
            const bool isBefore = (fieldAt(drop, origin + d * middle) < 0.0f) == (before < 0.0f);
            (isBefore ? low : high) = middle;
        }
        optixReportIntersection(0.5f * (low + high), 0);
        return;
    }
}
extern "C" __global__ void __intersection__floor() {
    const float3 origin = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    const float t = -origin.y / d.y;
    if (t > optixGetRayTmin() && t < optixGetRayTmax())
        optixReportIntersection(t, 0);
}

DEVICE void answer(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}
DEVICE float3 look(float3 from, float3 direction, unsigned depth) {
    unsigned r, g, b;
    optixTrace(params.hall, from, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 2, 0, r, g, b, depth);
    return vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
}
DEVICE float3 sunAt(float3 point, float3 normal) {
    const float cosine = dot(normal, params.sun);
    unsigned open = 0, unused = 0;
    if (cosine > 0.0f)
        optixTrace(params.hall, point, params.sun, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                       OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
                   1, 2, 1, open, unused, unused, unused);
    return open ? vec(1.6f, 1.45f, 1.2f) * cosine : vec(0.0f);
}
// Light of the surface and, down to the last depth, what it mirrors.
DEVICE float3 shade(float3 point, float3 normal, float3 color, float mirror) {
    const float3 direction = optixGetWorldRayDirection();
    const unsigned depth = optixGetPayload_3();
    float3 sum = color * (blueSky(normal) * 0.35f + sunAt(point, normal));
    const float edge = clamp01(1.0f + dot(direction, normal)), squared = edge * edge;
    const float share = mirror + (1.0f - mirror) * squared * squared * edge;
    if (depth < params.maxDepth && share > 0.02f) {
        const float3 seen = look(point, reflect(direction, normal), depth + 1);
        sum = lerp(sum, seen * lerp(vec(1.0f), color, mirror), share);
    }
    return sum;
}

extern "C" __global__ void __closesthit__drop() {
    const MetaballDrop& drop = dropOfRay();
    const float3 point = rayPoint();
    float second;
    const float3 normal = towardsRay(slopeAt(drop, point, second));
    answer(shade(point + normal * 3e-3f, normal, lerp(drop.colors[0], drop.colors[1], second),
                 drop.mirror));
}
extern "C" __global__ void __closesthit__floor() {
    const float3 p = rayPoint();
    const float ring = sqrtf(p.x * p.x + p.z * p.z) * 0.4f;
    const float3 color =
        ring - floorf(ring) < 0.5f ? vec(0.5f, 0.45f, 0.4f) : vec(0.3f, 0.28f, 0.27f);
    answer(shade(p + vec(0.0f, 1e-3f, 0.0f), vec(0.0f, 1.0f, 0.0f), color, 0.03f));
}
extern "C" __global__ void __miss__sky() {
    answer(blueSky(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

extern "C" __global__ void __raygen__hall() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        sum += look(params.camera.eye, cameraDirection(params.camera, x, y), 0);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
