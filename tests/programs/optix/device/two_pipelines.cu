// SPDX-License-Identifier: Apache-2.0
// A viewer's programs: pictures, and which object is under the cursor.
#include <optix.h>

#include "two_pipelines.h"

extern "C" {
__constant__ Params params;
}

static __device__ __forceinline__ float3 originOf(float x, float y) {
    return make_float3(2.0f * (x + 0.5f) / params.width - 1.0f,
                       2.0f * (y + 0.5f) / params.height - 1.0f, 4.0f);
}

extern "C" __global__ void __raygen__draw() {
    const uint3 at = optixGetLaunchIndex();
    unsigned bits = __float_as_uint(-1.0f);
    optixTrace(params.scene, originOf(at.x, at.y), make_float3(0, 0, -1), 0, 1e16f, 0,
               OptixVisibilityMask(1), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, bits);
    params.depth[at.y * params.width + at.x] = __uint_as_float(bits);
}
extern "C" __global__ void __closesthit__draw() {
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
}
extern "C" __global__ void __miss__draw() {
    optixSetPayload_0(__float_as_uint(1000.0f));
}

// The ids of all objects under the cursor, nearest first; any-hit programs sort them.
extern "C" __global__ void __raygen__pick() {
    unsigned first = ~0u, second = ~0u, depth1 = __float_as_uint(1e30f),
             depth2 = __float_as_uint(1e30f);
    optixTrace(params.scene, originOf(params.cursorX, params.cursorY), make_float3(0, 0, -1), 0,
               1e16f, 0, OptixVisibilityMask(3), OPTIX_RAY_FLAG_ENFORCE_ANYHIT, 0, 1, 0, first,
               second, depth1, depth2);
    params.picked[0] = first;
    params.picked[1] = second;
}
extern "C" __global__ void __anyhit__pick() {
    const float depth = optixGetRayTmax();
    const unsigned id = optixGetInstanceId();
    if (depth < __uint_as_float(optixGetPayload_2())) {
        if (optixGetPayload_0() != id) {
            optixSetPayload_1(optixGetPayload_0());
            optixSetPayload_3(optixGetPayload_2());
        }
        optixSetPayload_0(id);
        optixSetPayload_2(__float_as_uint(depth));
    } else if (depth < __uint_as_float(optixGetPayload_3()) && optixGetPayload_0() != id) {
        optixSetPayload_1(id);
        optixSetPayload_3(__float_as_uint(depth));
    }
    optixIgnoreIntersection();
}
extern "C" __global__ void __miss__pick() {}
