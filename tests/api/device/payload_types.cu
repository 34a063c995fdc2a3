// SPDX-License-Identifier: Apache-2.0
// Two payload types in one pipeline. Even launch indices trace with type 0 (two words), odd ones
// with type 1 (four words). Indices 2 and 3 of four look away from the triangle.
#include <optix.h>

#include "payload_types.h"

extern "C" {
__constant__ TypedParams params;
}

extern "C" __global__ void __raygen__typed() {
    const unsigned i = optixGetLaunchIndex().x;
    TypedResult& result = params.results[i];
    result.code = 1000;
    const float3 origin = make_float3(0, 0, -1);
    const float3 direction = make_float3(0, 0, i & 2 ? -1 : 1);
    unsigned p0 = 10 + i, p1 = 20 + i, p2 = 30 + i, p3 = 40 + i;
    if (i & 1)
        optixTrace(OPTIX_PAYLOAD_TYPE_ID_1, params.handle, origin, direction, 0.0f, 1e16f, 0.0f,
                   255, OPTIX_RAY_FLAG_NONE, params.hitOffset[1], 1, 1, p0, p1, p2, p3);
    else
        optixTrace(OPTIX_PAYLOAD_TYPE_ID_0, params.handle, origin, direction, 0.0f, 1e16f, 0.0f,
                   255, OPTIX_RAY_FLAG_NONE, params.hitOffset[0], 1, 0, p0, p1);
    result.words[0] = p0;
    result.words[1] = p1;
    result.words[2] = p2;
    result.words[3] = p3;
}

extern "C" __global__ void __closesthit__first() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_0);
    optixSetPayload_1(optixGetPayload_0() + 1000);
}

extern "C" __global__ void __closesthit__second() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_1);
    optixSetPayload_3(optixGetPayload_0() + optixGetPayload_2() + 2000);
}

// Supports both types; group creation must name one.
extern "C" __global__ void __anyhit__both() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_0 | OPTIX_PAYLOAD_TYPE_ID_1);
    optixSetPayload_0(optixGetPayload_0() + 5);
}

extern "C" __global__ void __miss__all() {
    optixSetPayload_0(7);
}

extern "C" __global__ void __exception__typed() {
    params.results[optixGetLaunchIndex().x].code = optixGetExceptionCode();
}
