// SPDX-License-Identifier: Apache-2.0
// A scene graph of instances of instances under transforms, some of which move during the exposure.
// Payload: normal, distance, colour.
#include "robots.h"
#include "tools.h"

extern "C" __constant__ RobotParams launch;

extern "C" __global__ void __closesthit__part() {
    const PartRecord* part = reinterpret_cast<const PartRecord*>(optixGetSbtDataPointer());
    const uint3 t = part->indices[optixGetPrimitiveIndex()];
    const float3 a = part->vertices[t.x];
    const float3 local = cross(part->vertices[t.y] - a, part->vertices[t.z] - a);
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    float3 color = part->color;
    if (part->isPainted) {
        const unsigned paint = hashPcg(optixGetInstanceId());
        color = color * vec(0.5f + (paint & 255u) / 512.0f, 0.5f + (paint >> 8 & 255u) / 512.0f,
                            0.5f + (paint >> 16 & 255u) / 512.0f);
    }
    optixSetPayload_0(__float_as_uint(normal.x));
    optixSetPayload_1(__float_as_uint(normal.y));
    optixSetPayload_2(__float_as_uint(normal.z));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_4(__float_as_uint(color.x));
    optixSetPayload_5(__float_as_uint(color.y));
    optixSetPayload_6(__float_as_uint(color.z));
}
extern "C" __global__ void __miss__none() {
    optixSetPayload_3(__float_as_uint(-1.0f));
}

DEVICE bool isLit(float3 from, float time) {
    unsigned p[7] = {0, 0, 0, __float_as_uint(1.0f)};
    optixTrace(launch.world, from, launch.sun, 1e-3f, 1e16f, time, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 0, 0, p[0], p[1], p[2], p[3], p[4], p[5], p[6]);
    return __uint_as_float(p[3]) < 0.0f;
}

extern "C" __global__ void __raygen__camera() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < launch.samples; ++i) {
        const float time = nextFloat(random);
        const float3 direction =
            cameraDirection(launch.camera, (index.x + nextFloat(random)) / size.x,
                            (index.y + nextFloat(random)) / size.y);
        unsigned p[7] = {};
        optixTrace(launch.world, launch.camera.eye, direction, 0.0f, 1e16f, time,
                   OptixVisibilityMask(1), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, 0, p[0], p[1], p[2],
                   p[3], p[4], p[5], p[6]);
        const float distance = __uint_as_float(p[3]);
        if (distance < 0.0f) {
            sum += blueSky(direction);
            continue;
        }
        const float3 normal =
            vec(__uint_as_float(p[0]), __uint_as_float(p[1]), __uint_as_float(p[2]));
        const float3 color =
            vec(__uint_as_float(p[4]), __uint_as_float(p[5]), __uint_as_float(p[6]));
        const float3 point = launch.camera.eye + direction * distance + normal * 2e-3f;
        float3 light = blueSky(normal) * 0.35f;
        const float cosine = dot(normal, launch.sun);
        if (cosine > 0.0f && isLit(point, time))
            light += vec(1.3f, 1.2f, 1.0f) * cosine;
        sum += color * light;
    }
    launch.image[pixel] = withWeight(sum / float(launch.samples), 1.0f);
}
