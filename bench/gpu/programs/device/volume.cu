// SPDX-License-Identifier: Apache-2.0
// Smoke in bricks: custom primitives whose closest-hit program marches through eight cubed
// densities. The ray generation program goes on behind each brick. Payload: light, transmittance,
// where the ray left the brick.
#include "common.h"

constexpr unsigned kSide = 8; // densities across a brick

extern "C" __global__ void __intersection__brick() {
    const Item& brick = params.items[optixGetPrimitiveIndex()];
    const float3 o = optixGetObjectRayOrigin() - brick.at, d = optixGetObjectRayDirection();
    const float3 inverse = vec(1 / d.x, 1 / d.y, 1 / d.z);
    const float r = brick.radius;
    const float3 a = vec((-r - o.x) * inverse.x, (-r - o.y) * inverse.y, (-r - o.z) * inverse.z);
    const float3 b = vec((r - o.x) * inverse.x, (r - o.y) * inverse.y, (r - o.z) * inverse.z);
    const float enter =
        maxOf(maxOf(minOf(a.x, b.x), minOf(a.y, b.y)), maxOf(minOf(a.z, b.z), optixGetRayTmin()));
    const float leave = minOf(minOf(maxOf(a.x, b.x), maxOf(a.y, b.y)), maxOf(a.z, b.z));
    if (leave > enter + params.epsilon)
        optixReportIntersection(enter, 0, __float_as_uint(leave));
}

DEVICE float densityAt(unsigned brick, float3 local) {
    const float* const d = params.grid + size_t(brick) * kSide * kSide * kSide;
    const float scale = 0.5f * (kSide - 1);
    const float x = clamp01(0.5f + 0.5f * local.x) * 2 * scale;
    const float y = clamp01(0.5f + 0.5f * local.y) * 2 * scale;
    const float z = clamp01(0.5f + 0.5f * local.z) * 2 * scale;
    const unsigned i = min(unsigned(x), kSide - 2), j = min(unsigned(y), kSide - 2),
                   k = min(unsigned(z), kSide - 2);
    const float fx = x - i, fy = y - j, fz = z - k;
    const float* const c = d + (k * kSide + j) * kSide + i;
    const auto row = [&](const float* p) { return p[0] + (p[1] - p[0]) * fx; };
    const auto plane = [&](const float* p) { return row(p) + (row(p + kSide) - row(p)) * fy; };
    return plane(c) + (plane(c + kSide * kSide) - plane(c)) * fz;
}

extern "C" __global__ void __closesthit__march() {
    const unsigned brick = optixGetPrimitiveIndex();
    const Item& item = params.items[brick];
    const float enter = optixGetRayTmax(), leave = __uint_as_float(optixGetAttribute_0());
    const float3 o = optixGetWorldRayOrigin() - item.at, d = optixGetWorldRayDirection();
    float light = __uint_as_float(optixGetPayload_0());
    float clear = __uint_as_float(optixGetPayload_1());
    constexpr unsigned kSteps = 16;
    const float step = (leave - enter) / kSteps;
    for (unsigned i = 0; i < kSteps; ++i) {
        const float3 at = o + d * (enter + (i + 0.5f) * step);
        const float density = densityAt(brick, at / item.radius);
        const float ahead = densityAt(brick, at / item.radius + params.light[0] * 0.3f);
        const float stays = expf(-density * step * params.reach);
        light += clear * (1 - stays) * (0.2f + 0.8f * expf(-2 * ahead));
        clear *= stays;
    }
    optixSetPayload_0(__float_as_uint(light));
    optixSetPayload_1(__float_as_uint(clear));
    optixSetPayload_2(__float_as_uint(leave));
}
extern "C" __global__ void __miss__end() {
    optixSetPayload_2(__float_as_uint(-1.0f));
}

extern "C" __global__ void __raygen__smoke() {
    unsigned random = hashPcg(pixelIndex());
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float3 direction = cameraRay(random);
        unsigned light = __float_as_uint(0.0f), clear = __float_as_uint(1.0f);
        float from = 0.0f;
        for (unsigned brick = 0; brick < params.depth; ++brick) {
            unsigned to = 0;
            optixTrace(params.scene, params.camera.eye, direction, from, 1e16f, 0.0f,
                       OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, light,
                       clear, to);
            from = __uint_as_float(to);
            if (from < 0.0f || __uint_as_float(clear) < 0.01f)
                break;
        }
        sum += vec(1.0f, 0.9f, 0.8f) * __uint_as_float(light) +
               skyColor(direction) * __uint_as_float(clear);
    }
    store(sum / float(params.samples));
}
