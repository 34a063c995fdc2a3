// SPDX-License-Identifier: Apache-2.0
// Random access to acceleration structures, one primitive and instance per launch index, and a ray
// along z into a traversable of the caller's choice.
#include "random_access.h"

#include "optix.h"

extern "C" __constant__ AccessParams params;

extern "C" __global__ void __raygen__access() {
    const unsigned i = optixGetLaunchIndex().x;
    AccessResult& result = params.results[i];
    float3 corners[3];
    optixGetTriangleVertexData(params.gas, params.primitiveOffset + i, params.sbtIndex, 0.0f,
                               corners);
    for (unsigned k = 0; k < 3; ++k) {
        result.vertices[3 * k] = corners[k].x;
        result.vertices[3 * k + 1] = corners[k].y;
        result.vertices[3 * k + 2] = corners[k].z;
    }
    result.instance = optixGetInstanceTraversableFromIAS(params.ias, i);
    result.child = optixGetInstanceChildFromHandle(result.instance);
    result.id = optixGetInstanceIdFromHandle(result.instance);
    unsigned missed = 0;
    optixTrace(params.traced, make_float3(0.1f, 0.1f, -5), make_float3(0, 0, 1), 0.0f, 100.0f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_NONE, 0, 1, 0, missed);
    result.missed = missed;
}

extern "C" __global__ void __miss__access() {
    optixSetPayload_0(1);
}

extern "C" __global__ void __closesthit__access() {
    optixSetPayload_0(2);
}
