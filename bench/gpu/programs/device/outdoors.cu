// SPDX-License-Identifier: Apache-2.0
// Closest-hit programs that trace the sun's shadow ray and the path's next ray, through instances;
// with random times where MOVES is set.
#include "recursive.h"

#if MOVES
#define NEW_TIME(random) nextFloat(random)
#define RAY_TIME optixGetRayTime()
#else
#define NEW_TIME(random) 0.0f
#define RAY_TIME 0.0f
#endif

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
    if (cosine > 0.0f && sees(above, params.light[0], 1e16f, RAY_TIME))
        light = params.emission * cosine;
    if (depth < params.depth) {
        const float u = nextFloat(random), v = nextFloat(random);
        light += trace(above, cosineDirection(normal, u, v), RAY_TIME, depth + 1, random);
    }
    setColor(tint() * light);
}
