// SPDX-License-Identifier: Apache-2.0
// Rays of a probe find light that surfaces send, which the probes of the last update light; a
// launch without rays turns them into spherical harmonics of the first order. Payload: normal,
// distance (negative: none), albedo in bytes, back face.
#include "probes.h"
#include "tools.h"

extern "C" {
__constant__ ProbeParams g_params;
}

struct ProbeHit {
    float3 normal, albedo;
    float distance;
    bool isBack;
};

extern "C" __global__ void __closesthit__hall() {
    const ProbeRecord* data = reinterpret_cast<const ProbeRecord*>(optixGetSbtDataPointer());
    const uint3 t = data->mesh.indices[optixGetPrimitiveIndex()];
    const float2 b = optixGetTriangleBarycentrics();
    float3 normal = data->normals[t.x] * (1.0f - b.x - b.y) + data->normals[t.y] * b.x +
                    data->normals[t.z] * b.y;
    normal = towardsRay(normalize(normal));
    const float stripe = sinf(3.0f * rayPoint().x) * sinf(3.0f * rayPoint().z);
    const float3 albedo = normal.y > 0.9f && stripe > 0.0f ? data->albedo * 0.4f : data->albedo;
    optixSetPayload_0(__float_as_uint(normal.x));
    optixSetPayload_1(__float_as_uint(normal.y));
    optixSetPayload_2(__float_as_uint(normal.z));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_4(unsigned(255.0f * albedo.x) | unsigned(255.0f * albedo.y) << 8 |
                      unsigned(255.0f * albedo.z) << 16);
    optixSetPayload_5(optixIsTriangleBackFaceHit() ? 1u : 0u);
}
extern "C" __global__ void __miss__all() {
    optixSetPayload_3(__float_as_uint(-1.0f));
}

DEVICE ProbeHit find(float3 origin, float3 direction, float reach, unsigned flags) {
    unsigned p0 = 0, p1 = 0, p2 = 0, p3 = 0, p4 = 0, p5 = 0;
    optixTrace(g_params.hall, origin, direction, 0.0f, reach, 0.0f, OptixVisibilityMask(255),
               flags | OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p0, p1, p2, p3, p4, p5);
    return {vec(__uint_as_float(p0), __uint_as_float(p1), __uint_as_float(p2)),
            vec(p4 & 255u, p4 >> 8 & 255u, p4 >> 16) / 255.0f, __uint_as_float(p3), p5 != 0};
}
DEVICE bool isLit(float3 point, float3 direction, float distance) {
    return find(point, direction, distance - 1e-2f,
                OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT)
               .distance < 0.0f;
}

DEVICE float3 lampLight(const PointLamp& lamp, float3 point, float3 normal) {
    const float3 line = lamp.position - point;
    const float distance = length(line), cosine = dot(normal, line) / distance;
    if (cosine <= 0.0f || !isLit(point, line / distance, distance))
        return vec(0.0f);
    return lamp.power * (cosine / (distance * distance + 0.1f));
}

DEVICE unsigned probeAt(uint3 at) {
    return (at.z * g_params.counts.y + at.y) * g_params.counts.x + at.x;
}
DEVICE float3 positionOf(uint3 at) {
    const float3 share =
        vec(float(at.x) / (g_params.counts.x - 1), float(at.y) / (g_params.counts.y - 1),
            float(at.z) / (g_params.counts.z - 1));
    return g_params.low + (g_params.high - g_params.low) * share;
}

// The mean of the eight probes around a point, weighted by distance and side.
DEVICE float3 irradiance(const float3* harmonics, float3 point, float3 normal) {
    const float3 size = g_params.high - g_params.low, local = point - g_params.low;
    const float x = clamp01(local.x / size.x) * (g_params.counts.x - 1),
                y = clamp01(local.y / size.y) * (g_params.counts.y - 1),
                z = clamp01(local.z / size.z) * (g_params.counts.z - 1);
    float3 sum = vec(0.0f);
    float weights = 1e-4f;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const uint3 at = make_uint3(min(unsigned(x) + (corner & 1), g_params.counts.x - 1),
                                    min(unsigned(y) + (corner >> 1 & 1), g_params.counts.y - 1),
                                    min(unsigned(z) + (corner >> 2), g_params.counts.z - 1));
        const float3 line = positionOf(at) - point;
        const float facing = 0.5f + 0.5f * dot(line, normal) * rsqrtf(dot(line, line) + 1e-6f);
        const float weight = fmaxf(0.0f, 1.0f - fabsf(x - at.x)) *
                             fmaxf(0.0f, 1.0f - fabsf(y - at.y)) *
                             fmaxf(0.0f, 1.0f - fabsf(z - at.z)) * (facing * facing + 0.05f);
        const float3* const h = harmonics + probeAt(at) * kHarmonics;
        const float3 light = h[0] + (h[1] * normal.x + h[2] * normal.y + h[3] * normal.z) * 2.0f;
        sum += vec(fmaxf(light.x, 0.0f), fmaxf(light.y, 0.0f), fmaxf(light.z, 0.0f)) * weight;
        weights += weight;
    }
    return sum / weights;
}

DEVICE float3 turnedDirection(unsigned ray) {
    unsigned random = hashPcg(g_params.update);
    const float turn = nextFloat(random), shift = nextFloat(random);
    const float z = 1.0f - 2.0f * (ray + shift) / kProbeRays, r = sqrtf(fmaxf(0.0f, 1.0f - z * z));
    const float around = 0.618034f * ray + turn;
    const float2 c = circlePoint(around - floorf(around));
    return vec(r * c.x, r * c.y, z);
}

// Launch index: ray, column and row of the slice.
extern "C" __global__ void __raygen__gather() {
    const uint3 index = optixGetLaunchIndex();
    const uint3 at = make_uint3(index.y, index.z, g_params.slice);
    const float3 origin = positionOf(at), direction = turnedDirection(index.x);
    const ProbeHit hit = find(origin, direction, 1e16f, OPTIX_RAY_FLAG_NONE);
    float3 light = vec(0.0f);
    if (hit.distance >= 0.0f) {
        const float3 point = origin + direction * hit.distance + hit.normal * 2e-3f;
        const unsigned lamp = (index.x + g_params.update) % kLamps;
        light = lampLight(g_params.lamps[lamp], point, hit.normal) * (float(kLamps) / kPi);
        light += irradiance(g_params.before, point, hit.normal);
        light = light * hit.albedo;
    }
    g_params.radiance[probeAt(at) * kProbeRays + index.x] = light;
}

extern "C" __global__ void __raygen__blend() {
    const unsigned probe = probeAt(optixGetLaunchIndex());
    float3 sums[kHarmonics] = {};
    for (unsigned i = 0; i < kProbeRays; ++i) {
        const float3 light = g_params.radiance[probe * kProbeRays + i] / float(kProbeRays);
        const float3 direction = turnedDirection(i);
        sums[0] += light;
        sums[1] += light * direction.x;
        sums[2] += light * direction.y;
        sums[3] += light * direction.z;
    }
    const float share = g_params.update == 0 ? 1.0f : 0.3f;
    for (unsigned k = 0; k < kHarmonics; ++k)
        g_params.after[probe * kHarmonics + k] =
            lerp(g_params.before[probe * kHarmonics + k], sums[k], share);
}

extern "C" __global__ void __raygen__view() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float3 direction =
        cameraDirection(g_params.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    const ProbeHit hit = find(g_params.camera.eye, direction, 1e16f, OPTIX_RAY_FLAG_NONE);
    float3 light = vec(0.0f);
    if (hit.distance >= 0.0f) {
        const float3 point = g_params.camera.eye + direction * hit.distance + hit.normal * 2e-3f;
        for (unsigned i = 0; i < kLamps; ++i)
            light += lampLight(g_params.lamps[i], point, hit.normal) / kPi;
        light = (light + irradiance(g_params.after, point, hit.normal)) * hit.albedo;
    }
    g_params.image[index.y * size.x + index.x] = withWeight(light, 1.0f);
}
