// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "carousel.h"

extern "C" __constant__ Params params;

extern "C" __global__ void __raygen__scan() {
    const unsigned i = optixGetLaunchIndex().x;
    const Ray ray = params.rays[i * params.layout[0].stride];
    // The answer's address travels as two payload words.
    Answer* answer = params.answers + i * params.layout[1].stride;
    const unsigned long long address = reinterpret_cast<unsigned long long>(answer);
    unsigned low = unsigned(address), high = unsigned(address >> 32);
    optixTrace(params.scene, ray.origin, ray.direction, 0.0f, 1e9f, ray.time, 255,
               OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES, 0, 1, 0, low, high);
}

static __forceinline__ __device__ Answer* answerOf() {
    return reinterpret_cast<Answer*>((unsigned long long)optixGetPayload_1() << 32 |
                                     optixGetPayload_0());
}
extern "C" __global__ void __miss__scan() {
    answerOf()->t = -1.0f;
}
extern "C" __global__ void __closesthit__scan() {
    Answer* answer = answerOf();
    const float3 o = optixGetWorldRayOrigin(), d = optixGetWorldRayDirection();
    const float t = optixGetRayTmax();
    answer->t = t;
    answer->id = optixGetInstanceId();
    answer->depth = optixGetTransformListSize();
    for (unsigned i = 0; i < optixGetTransformListSize(); ++i) {
        const OptixTraversableHandle handle = optixGetTransformListHandle(i);
        if (optixGetTransformTypeFromHandle(handle) == OPTIX_TRANSFORM_TYPE_INSTANCE) {
            answer->outer = optixGetInstanceIdFromHandle(handle);
            break;
        }
    }
    const float3 hit = make_float3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
    answer->local = optixTransformPointFromWorldToObjectSpace(hit);
    answer->world = optixTransformPointFromObjectToWorldSpace(answer->local);
}
