// SPDX-License-Identifier: Apache-2.0
// A rotating scanner. Each launch index is a pulse that goes on behind thin objects and gives up to
// four echoes; the echoes go to one list through an atomic counter. The second ray generation
// program draws the list as a map. Payload: distance, cosine, reflectivity, share that passes,
// object.
#include "lidar.h"
#include "tools.h"

#include <cstdio>

extern "C" __constant__ LidarParams params;

constexpr unsigned kMostEchoes = 4;

extern "C" __global__ void __closesthit__echo() {
    const LidarMaterial* m = reinterpret_cast<const LidarMaterial*>(optixGetSbtDataPointer());
    float3 corners[3];
    optixGetTriangleVertexData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                               optixGetSbtGASIndex(), 0.0f, corners);
    const float3 normal = optixTransformNormalFromObjectToWorldSpace(
        cross(corners[1] - corners[0], corners[2] - corners[0]));
    const float cosine = fabsf(dot(normalize(normal), optixGetWorldRayDirection()));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(__float_as_uint(cosine));
    optixSetPayload_2(__float_as_uint(m->reflectivity));
    optixSetPayload_3(__float_as_uint(m->passes));
    optixSetPayload_4(m->object + optixGetInstanceId());
}
extern "C" __global__ void __miss__end() {
    const LidarMiss* m = reinterpret_cast<const LidarMiss*>(optixGetSbtDataPointer());
    optixSetPayload_0(__float_as_uint(-m->limit));
}

DEVICE float3 pulseDirection(unsigned column, unsigned channel, unsigned pulse) {
    unsigned random = hashPcg(pulse);
    const float turn = (column + nextFloat(random)) / params.numColumns + params.angle;
    const float steps = (channel + 0.2f * nextFloat(random)) / params.numChannels;
    const float pitch = -0.42f + 0.5f * steps;
    return make_float3(cosf(pitch) * cosf(6.2831853f * turn), sinf(pitch),
                       cosf(pitch) * sinf(6.2831853f * turn));
}

static __device__ __noinline__ void addEcho(const Echo& echo) {
    const unsigned at = atomicAdd(params.numEchoes, 1u);
    if (at < params.maxEchoes)
        params.echoes[at] = echo;
    else if (params.isVerbose)
        printf("lidar: echo %u of beam %u is lost\n", at, echo.beam);
}

extern "C" __global__ void __raygen__scan() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned beam = index.y * params.numColumns + index.x;
    const float3 direction = pulseDirection(index.x, index.y, beam);
    float energy = 1.0f, from = 0.5f, first = 0.0f, sum = 0.0f;
    unsigned found = 0;
    for (unsigned n = 0; n < kMostEchoes && energy > 0.02f; ++n) {
        unsigned distance = 0, cosine = 0, reflectivity = 0, passes = 0, object = 0;
        optixTrace(params.world, params.scanner, direction, from, 120.0f, 0.0f,
                   OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, distance,
                   cosine, reflectivity, passes, object);
        const float range = __uint_as_float(distance);
        if (range < 0.0f)
            break;
        Echo echo;
        echo.point = params.scanner + direction * range;
        echo.intensity = energy * __uint_as_float(cosine) * __uint_as_float(reflectivity) * 400.0f /
                         (range * range + 40.0f);
        echo.beam = beam;
        echo.object = object;
        echo.number = n;
        echo.reserved = 0;
        if (echo.intensity > 0.01f) {
            addEcho(echo);
            first = found++ == 0 ? range : first;
            sum += echo.intensity;
        }
        energy *= __uint_as_float(passes);
        from = range + 0.05f;
    }
    params.beams[beam] = make_float4(first, sum, float(found), 1.0f);
}

extern "C" __global__ void __raygen__map() {
    const unsigned i = optixGetLaunchIndex().x;
    if (i >= *params.numEchoes || i >= params.maxEchoes)
        return;
    const Echo echo = params.echoes[i];
    const float3 p = echo.point - params.scanner;
    const float scale = 0.5f * params.mapSide / params.mapReach;
    const int x = int(floorf(p.x * scale)) + int(params.mapSide / 2);
    const int y = int(floorf(p.z * scale)) + int(params.mapSide / 2);
    if (x < 0 || y < 0 || x >= int(params.mapSide) || y >= int(params.mapSide))
        return;
    float4* const cell = params.map + y * params.mapSide + x;
    atomicAdd(&cell->x, 1.0f);
    atomicAdd(&cell->y, echo.intensity);
    atomicAdd(&cell->z, 0.1f * (p.y + 10.0f));
    atomicAdd(&cell->w, float(echo.object & 7u));
}
