// SPDX-License-Identifier: Apache-2.0
// Light paths from lamps: each vertex but the first is joined with the camera, and its light added
// to the pixel.
#include "light_tracer_rays.h"

// Adds light that leaves `point` towards the camera.
static __forceinline__ __device__ void splat(const HallHit& at, float3 flux) {
    const Camera& c = params.camera;
    const float3 to = at.point - c.eye;
    const float depth = dot(to, c.forward);
    if (depth <= 0.1f)
        return;
    const float x = dot(to, c.right) / (depth * dot(c.right, c.right));
    const float y = dot(to, c.up) / (depth * dot(c.up, c.up));
    if (fabsf(x) >= 1.0f || fabsf(y) >= 1.0f)
        return;
    const float squared = dot(to, to), cosineEye = depth * rsqrtf(squared);
    const float cosine = -dot(at.normal, to) * rsqrtf(squared);
    if (cosine <= 0.0f || !areVisible(at.point, c.eye))
        return;
    const unsigned column = min(unsigned((0.5f + 0.5f * x) * params.width), params.width - 1);
    const unsigned row = min(unsigned((0.5f - 0.5f * y) * params.height), params.height - 1);
    // The picture's plane at distance 1 has the area 4 |right| |up|.
    const float area = 4.0f * length(c.right) * length(c.up) / (params.width * params.height);
    const float scale = cosine / (kPi * squared * area * cosineEye * cosineEye * cosineEye);
    float* const pixel = params.film + 3 * (row * params.width + column);
    const float3 light = at.albedo * flux * scale;
    atomicAdd(pixel, light.x);
    atomicAdd(pixel + 1, light.y);
    atomicAdd(pixel + 2, light.z);
}

extern "C" __global__ void __raygen__lamps() {
    const unsigned path = optixGetLaunchIndex().x;
    unsigned random = hashPcg(path);
    const TracerLamp& lamp = params.lamps[path % params.numLamps];
    const float a = nextFloat(random), b = nextFloat(random);
    const float3 across = cross(lamp.u, lamp.v);
    const float area = length(across);
    const float3 normal = across / area;
    float3 origin = lamp.corner + lamp.u * a + lamp.v * b;
    const float c = nextFloat(random), d = nextFloat(random);
    float3 direction = cosineDirection(normal, c, d);
    float3 flux = lamp.emission * (kPi * area * params.numLamps / params.numPaths);
    for (unsigned vertex = 0; vertex < params.maxVertices; ++vertex) {
        const HallHit hit = findHit(origin, direction);
        if (!hit.isHit)
            break;
        if (vertex > 0) // the camera's pipeline has the light of the first
            splat(hit, flux);
        const float stays = maxComponent(hit.albedo);
        if (nextFloat(random) >= stays)
            break;
        flux = flux * hit.albedo / stays;
        origin = hit.point;
        const float e = nextFloat(random), f = nextFloat(random);
        direction = cosineDirection(hit.normal, e, f);
    }
}
