// SPDX-License-Identifier: Apache-2.0
// Shooting and bouncing rays. At each bounce the point that sees the antenna adds its echo to the
// cell of the path's length and of its change. Payload: normal, distance, velocity, and the
// polarisation in and the reflectivity out.
#include "radar.h"
#include "tools.h"

extern "C" {
__constant__ RadarParams launchParams;
}

constexpr float kUnit = 1048576.0f * 1048576.0f; // of cells, in one unit of power

extern "C" __global__ void __closesthit__reflect() {
    const RadarRecord* r = reinterpret_cast<const RadarRecord*>(optixGetSbtDataPointer());
    const float3 local = r->mesh.normal(optixGetPrimitiveIndex());
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    const float cosine = -dot(normal, optixGetWorldRayDirection());
    const unsigned angle = min(static_cast<unsigned>(cosine * kAngles), kAngles - 1);
    const float turned = __uint_as_float(optixGetPayload_7());
    const float reflectivity = lerp(vec(r->horizontal[angle]), vec(r->vertical[angle]), turned).x;
    optixSetPayload_0(__float_as_uint(normal.x));
    optixSetPayload_1(__float_as_uint(normal.y));
    optixSetPayload_2(__float_as_uint(normal.z));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_4(__float_as_uint(r->velocity.x));
    optixSetPayload_5(__float_as_uint(r->velocity.z));
    optixSetPayload_6(__float_as_uint(r->roughness));
    optixSetPayload_7(__float_as_uint(reflectivity));
}
extern "C" __global__ void __miss__nothing() {
    optixSetPayload_3(__float_as_uint(-1.0f));
}

struct Echo {
    float3 normal, velocity;
    float distance, roughness, reflectivity;
};

DEVICE Echo findEcho(float3 origin, float3 direction, float turned) {
    unsigned p[8] = {0, 0, 0, 0, 0, 0, 0, __float_as_uint(turned)};
    optixTrace(launchParams.world, origin, direction, 2e-3f, 1e6f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p[0], p[1], p[2], p[3], p[4], p[5], p[6],
               p[7]);
    return {vec(__uint_as_float(p[0]), __uint_as_float(p[1]), __uint_as_float(p[2])),
            vec(__uint_as_float(p[4]), 0.0f, __uint_as_float(p[5])), __uint_as_float(p[3]),
            __uint_as_float(p[6]), __uint_as_float(p[7])};
}
DEVICE bool seesAntenna(float3 point, float3 direction, float distance) {
    unsigned p[8] = {};
    optixTrace(launchParams.world, point, direction, 2e-3f, distance, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 0, p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]);
    return __uint_as_float(p[3]) < 0.0f;
}

DEVICE void addToCell(float range, float shift, float power) {
    const RadarParams& p = launchParams;
    const int x = static_cast<int>(range / p.maxRange * p.ranges);
    const int y = static_cast<int>((0.5f + 0.5f * shift / p.maxShift) * p.shifts);
    if (x >= 0 && x < static_cast<int>(p.ranges) && y >= 0 && y < static_cast<int>(p.shifts))
        atomicAdd(&p.cells[y * p.ranges + x], static_cast<unsigned long long>(power * kUnit));
}

// A ray of a chirp, in the cone of the beam.
DEVICE float3 beamDirection(unsigned& random) {
    float3 x, y;
    makeBasis(launchParams.axis, x, y);
    const float r = launchParams.beam * sqrtf(nextFloat(random));
    const float2 c = circlePoint(nextFloat(random));
    return normalize(launchParams.axis + x * (r * c.x) + y * (r * c.y));
}

extern "C" __global__ void __raygen__transmit() {
    const RadarParams& p = launchParams;
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    unsigned random = hashPcg(hashPcg(index.y * size.x + index.x) ^ p.chirp);
    float3 origin = p.antenna, direction = beamDirection(random);
    float power = 1.0f, path = 0.0f, change = -dot(p.velocity, direction),
          turned = nextFloat(random);
    for (unsigned bounce = 0; bounce < p.maxBounces; ++bounce) {
        const Echo echo = findEcho(origin, direction, turned);
        if (echo.distance < 0.0f)
            break;
        path += echo.distance;
        change += dot(echo.velocity, direction);
        power *= echo.reflectivity;
        origin = origin + direction * echo.distance + echo.normal * 2e-3f;
        const float3 line = p.antenna - origin;
        const float distance = length(line);
        const float3 back = line / distance, mirror = reflect(direction, echo.normal);
        const float lobe = 1.0f + 200.0f * (1.0f - echo.roughness);
        const float share = echo.roughness * fmaxf(dot(back, echo.normal), 0.0f) +
                            (1.0f - echo.roughness) * powf(fmaxf(dot(mirror, back), 0.0f), lobe);
        if (share > 1e-4f && seesAntenna(origin, back, distance))
            addToCell(0.5f * (path + distance),
                      0.5f * (change - dot(echo.velocity - p.velocity, back)),
                      power * share / (distance * distance));
        const float u = nextFloat(random), v = nextFloat(random);
        const float3 around = cosineDirection(echo.normal, u, v);
        direction = normalize(lerp(mirror, around, echo.roughness));
        change -= dot(echo.velocity, direction);
        turned = 0.7f * turned + 0.3f * nextFloat(random);
    }
}

// The picture in decibels.
extern "C" __global__ void __raygen__develop() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned cell = index.y * launchParams.ranges + index.x;
    const float power = static_cast<float>(launchParams.cells[cell]) / kUnit;
    const float level = clamp01(2.0f + log10f(power / launchParams.rays + 1e-12f) / 6.0f);
    launchParams.image[cell] =
        withWeight(vec(level, level * level, 0.3f * (1.0f - level) * level), 1.0f);
}
