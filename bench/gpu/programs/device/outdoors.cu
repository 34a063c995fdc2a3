// SPDX-License-Identifier: Apache-2.0
// Closest-hit programs that trace the sun's shadow ray and the path's next ray, through instances;
// with random times where MOVES is set. Payload: the colour, the depth, the random state.
#include "common.h"

#if MOVES
#define NEW_TIME(random) nextFloat(random)
#define RAY_TIME optixGetRayTime()
#else
#define NEW_TIME(random) 0.0f
#define RAY_TIME 0.0f
#endif

DEVICE float3 trace(float3 origin, float3 direction, float time, unsigned depth, unsigned random) {
    unsigned r = 0, g = 0, b = 0;
    optixTrace(params.scene, origin, direction, 0.0f, 1e16f, time, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, r, g, b, depth, random);
    return asFloats(r, g, b);
}
DEVICE bool seesSun(float3 origin) {
    unsigned hidden = 1;
    optixTrace(params.scene, origin, params.light[0], 0.0f, 1e16f, RAY_TIME,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hidden);
    return hidden == 0;
}
DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}

extern "C" __global__ void __raygen__camera() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i) {
        const float3 direction = cameraRay(random);
        sum += trace(params.camera.eye, direction, NEW_TIME(random), 1, random);
    }
    store(sum / float(params.samples));
}
extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()) * 0.6f);
}
extern "C" __global__ void __miss__free() {
    optixSetPayload_0(0);
}

// The instances of all levels tint the surface.
DEVICE float3 tint() {
    float3 color = material().color;
    const unsigned count = optixGetTransformListSize();
    for (unsigned i = 0; i < count; ++i) {
        const OptixTraversableHandle handle = optixGetTransformListHandle(i);
        if (optixGetTransformTypeFromHandle(handle) != OPTIX_TRANSFORM_TYPE_INSTANCE)
            continue;
        const unsigned bits = hashPcg(optixGetInstanceIdFromHandle(handle));
        color = lerp(
            color, vec(float(bits & 255), float(bits >> 8 & 255), float(bits >> 16 & 255)) / 255.0f,
            0.3f / float(i + 1));
    }
    return color;
}

extern "C" __global__ void __closesthit__outdoors() {
    bool back;
    const float3 normal =
        facing(normalize(optixTransformNormalFromObjectToWorldSpace(triangleNormal())), back);
    const float3 above = hitPoint() + normal * params.epsilon;
    const unsigned depth = optixGetPayload_3();
    unsigned random = optixGetPayload_4();
    float3 light = vec(0.0f);
    const float cosine = dot(normal, params.light[0]);
    if (cosine > 0.0f && seesSun(above))
        light = params.emission * cosine;
    if (depth < params.depth) {
        const float u = nextFloat(random), v = nextFloat(random);
        light += trace(above, cosineDirection(normal, u, v), RAY_TIME, depth + 1, random);
    }
    setColor(tint() * light);
}
