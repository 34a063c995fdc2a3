// SPDX-License-Identifier: Apache-2.0
// Functions that the device programs of bench_programs share.
#pragma once

#include "shared.h"

#include "sampling.h"

#include <optix.h>

extern "C" {
__constant__ ProgramParams params;
}

#define DEVICE static __forceinline__ __device__

DEVICE float nextFloat(unsigned& state) {
    const unsigned bits = hashPcg(state);
    state = state * 747796405u + 2891336453u;
    return float(bits >> 8) * (1.0f / 16777216.0f);
}

DEVICE unsigned pixelIndex() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    return index.y * size.x + index.x;
}

// A random ray through the pixel of this launch index.
DEVICE float3 cameraRay(unsigned& random) {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float x = (index.x + nextFloat(random)) / size.x;
    const float y = (index.y + nextFloat(random)) / size.y;
    return cameraDirection(params.camera, x, y);
}

DEVICE void store(float3 color, float w = 1.0f) {
    params.image[pixelIndex()] = make_float4(color.x, color.y, color.z, w);
}

DEVICE const Look& material() {
    return *reinterpret_cast<const Look*>(optixGetSbtDataPointer());
}
DEVICE float3 hitPoint() {
    return optixGetWorldRayOrigin() + optixGetWorldRayDirection() * optixGetRayTmax();
}
DEVICE float3 asFloats(unsigned x, unsigned y, unsigned z) {
    return vec(__uint_as_float(x), __uint_as_float(y), __uint_as_float(z));
}

// The unit normal of the triangle that was hit, in its own space.
DEVICE float3 triangleNormal() {
    const Look& m = material();
    const uint3 corners = m.triangles[optixGetPrimitiveIndex()];
    const float3 a = m.vertices[corners.x];
    return normalize(cross(m.vertices[corners.y] - a, m.vertices[corners.z] - a));
}
// The normal on the ray's side.
DEVICE float3 facing(float3 normal, bool& back) {
    back = dot(normal, optixGetWorldRayDirection()) > 0.0f;
    return back ? -normal : normal;
}

DEVICE float3 skyColor(float3 direction) {
    return lerp(vec(0.95f, 0.9f, 0.85f), vec(0.25f, 0.48f, 0.9f), 0.5f + 0.5f * direction.y);
}

// The next direction of a path. `color`: the reflected share of the light.
struct Bounce {
    float3 direction, color;
    bool passes; // through the surface
};
DEVICE Bounce bounce(const Look& m, float3 d, float3 normal, bool back, unsigned& random) {
    const float u = nextFloat(random), v = nextFloat(random);
    Bounce b = {cosineDirection(normal, u, v), m.color, false};
    if (m.surface == kMirror)
        b.direction = reflect(d, normal);
    if (m.surface == kGlossy)
        b.direction = normalize(lerp(reflect(d, normal), b.direction, m.roughness));
    if (m.surface == kGlass) {
        const float cosine = -dot(normal, d), ratio = back ? 1.4f : 1.0f / 1.4f;
        const float squared = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
        const float c = 1.0f - cosine, share = 0.03f + 0.97f * c * c * c * c * c;
        b.passes = squared > 0.0f && u > share;
        b.direction = b.passes ? normalize(d * ratio + normal * (ratio * cosine - sqrtf(squared)))
                               : reflect(d, normal);
    }
    return b;
}

// A point of the lamp, relative to a surface point: direction, distance, and the unoccluded light.
struct LampSample {
    float3 direction, light;
    float distance;
};
DEVICE LampSample sampleLamp(float3 point, float3 normal, unsigned& random) {
    const float u = nextFloat(random), v = nextFloat(random);
    const float3 to = params.light[0] + params.light[1] * u + params.light[2] * v - point;
    const float3 area = cross(params.light[1], params.light[2]);
    LampSample s;
    s.distance = length(to);
    s.direction = to / s.distance;
    const float cosine = maxOf(dot(normal, s.direction), 0.0f);
    const float lamp = fabsf(dot(area, s.direction));
    s.light = params.emission * (cosine * lamp / (kPi * maxOf(s.distance * s.distance, 1e-4f)));
    return s;
}
