// SPDX-License-Identifier: Apache-2.0
// Resampled direct light (Bitterli et al. 2020). The first launch finds the surface of each pixel
// and a reservoir: candidates, a shadow ray, the reservoir of the sample before. The second launch
// adds reservoirs of neighbours, and shades with another shadow ray. Payload: triangle,
// barycentrics, distance; for shadow rays the first word.
#include "resampling.h"
#include "tools.h"

extern "C" {
__constant__ ResamplingParams params;
}

constexpr float kMostCount = 20.0f; // of the sample before, in units of `candidates`

extern "C" __global__ void __closesthit__triangle() {
    const float2 uv = optixGetTriangleBarycentrics();
    optixSetPayload_0(optixGetPrimitiveIndex());
    optixSetPayload_1(__float_as_uint(uv.x));
    optixSetPayload_2(__float_as_uint(uv.y));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
}
extern "C" __global__ void __miss__none() {
    optixSetPayload_3(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__visible() {
    optixSetPayload_0(1);
}

DEVICE bool isVisible(float3 from, float3 to) {
    unsigned visible = 0, unused = 0;
    optixTrace(params.hall, from, to - from, 1e-4f, 0.9999f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, visible, unused, unused, unused);
    return visible != 0;
}

DEVICE PixelSurface findSurface(float3 origin, float3 direction) {
    unsigned triangle = 0, u = 0, v = 0, t = 0;
    optixTrace(params.hall, origin, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, triangle, u, v, t);
    PixelSurface s;
    s.distance = __uint_as_float(t);
    if (s.distance < 0.0f)
        return s;
    const uint3 i = params.mesh.indices[triangle];
    const float b = __uint_as_float(u), c = __uint_as_float(v);
    const float3* const p = params.mesh.vertices;
    s.point = p[i.x] * (1.0f - b - c) + p[i.y] * b + p[i.z] * c;
    s.normal = normalize(params.mesh.normal(triangle));
    if (dot(s.normal, direction) > 0.0f)
        s.normal = -s.normal;
    s.point += s.normal * 1e-3f;
    const bool isTile = fabsf(s.normal.y) > 0.99f && s.point.y < 0.1f;
    const int tile = static_cast<int>(floorf(s.point.x)) + static_cast<int>(floorf(s.point.z));
    s.albedo = isTile && tile % 2 ? vec(0.3f, 0.25f, 0.2f) : vec(0.75f, 0.7f, 0.65f);
    return s;
}

DEVICE float3 placeOf(const Reservoir& r) {
    const Lamp& lamp = params.lamps[r.lamp];
    return lamp.corner + lamp.u * r.u + lamp.v * r.v;
}
// Light that a lamp sends to the eye from a surface, without its visibility.
DEVICE float3 lightFrom(const PixelSurface& s, const Reservoir& r) {
    const Lamp& lamp = params.lamps[r.lamp];
    const float3 line = placeOf(r) - s.point;
    const float squared = dot(line, line);
    const float here = dot(s.normal, line), there = line.y;
    if (here <= 0.0f || there <= 0.0f)
        return vec(0.0f);
    const float area = length(cross(lamp.u, lamp.v));
    return s.albedo * lamp.radiance * (here * there * area / (kPi * squared * squared));
}
DEVICE float targetOf(const PixelSurface& s, const Reservoir& r) {
    const float3 light = lightFrom(s, r);
    return 0.3f * light.x + 0.6f * light.y + 0.1f * light.z;
}

// Adds one reservoir to another; `target` is that of `more` for the pixel of `r`.
DEVICE void merge(Reservoir& r, const Reservoir& more, float target, float count,
                  unsigned& random) {
    const float weight = target * more.weight * count;
    r.sum += weight;
    r.count += count;
    if (nextFloat(random) * r.sum < weight) {
        r.lamp = more.lamp;
        r.u = more.u;
        r.v = more.v;
    }
}
DEVICE void finish(Reservoir& r, const PixelSurface& s) {
    const float target = targetOf(s, r);
    r.weight = target > 0.0f && r.count > 0.0f ? r.sum / (r.count * target) : 0.0f;
}

extern "C" __global__ void __raygen__find() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned pixel = index.y * params.width + index.x;
    unsigned random = hashPcg(hashPcg(pixel) ^ params.sample * 0x9e3779b9u);
    const float3 direction = cameraDirection(params.camera, (index.x + 0.5f) / params.width,
                                             (index.y + 0.5f) / params.height);
    const PixelSurface s = findSurface(params.camera.eye, direction);
    params.surfaces[pixel] = s;
    Reservoir r = {};
    if (s.distance >= 0.0f) {
        for (unsigned i = 0; i < params.candidates; ++i) {
            Reservoir candidate = {};
            candidate.lamp = min(static_cast<unsigned>(nextFloat(random) * params.lampCount),
                                 params.lampCount - 1);
            candidate.u = nextFloat(random);
            candidate.v = nextFloat(random);
            candidate.weight = static_cast<float>(params.lampCount);
            merge(r, candidate, targetOf(s, candidate), 1.0f, random);
        }
        finish(r, s);
        if (r.weight > 0.0f && !isVisible(s.point, placeOf(r)))
            r.weight = r.sum = 0.0f;
        if (params.sample > 0) {
            const Reservoir before = params.kept[pixel];
            Reservoir both = {};
            merge(both, r, targetOf(s, r), r.count, random);
            merge(both, before, targetOf(s, before),
                  fminf(before.count, kMostCount * params.candidates), random);
            finish(both, s);
            r = both;
        }
    }
    params.found[pixel] = r;
}

extern "C" __global__ void __raygen__share() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned pixel = index.y * params.width + index.x;
    const PixelSurface s = params.surfaces[pixel];
    unsigned random = hashPcg(hashPcg(pixel + 77u) ^ params.sample * 0x85ebca6bu);
    float3 light = vec(0.0f);
    if (s.distance >= 0.0f) {
        Reservoir r = {};
        const Reservoir own = params.found[pixel];
        merge(r, own, targetOf(s, own), own.count, random);
        for (unsigned i = 0; i < params.neighbours; ++i) {
            const float2 c = circlePoint(nextFloat(random));
            const float distance = params.radius * sqrtf(nextFloat(random));
            const int x = static_cast<int>(index.x + distance * c.x),
                      y = static_cast<int>(index.y + distance * c.y);
            if (x < 0 || y < 0 || x >= int(params.width) || y >= int(params.height))
                continue;
            const unsigned other = y * params.width + x;
            const PixelSurface& there = params.surfaces[other];
            if (dot(there.normal, s.normal) < 0.9f ||
                fabsf(there.distance - s.distance) > 0.1f * s.distance)
                continue;
            const Reservoir more = params.found[other];
            merge(r, more, targetOf(s, more), more.count, random);
        }
        finish(r, s);
        params.kept[pixel] = r;
        if (r.weight > 0.0f && isVisible(s.point, placeOf(r)))
            light = lightFrom(s, r) * r.weight;
        light += s.albedo * vec(0.01f);
    }
    const float4 old = params.image[pixel];
    const float share = 1.0f / (params.sample + 1.0f);
    params.image[pixel] = withWeight(lerp(vec(old.x, old.y, old.z), light, share), 1.0f);
}
