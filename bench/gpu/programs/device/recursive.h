// SPDX-License-Identifier: Apache-2.0
// Rays of programs whose closest-hit programs trace. Payload: the colour, the depth, the random
// state; for shadow rays one word, which their miss program clears.
#pragma once

#include "common.h"

DEVICE float3 trace(float3 origin, float3 direction, float time, unsigned depth, unsigned random) {
    unsigned r = 0, g = 0, b = 0;
    optixTrace(params.scene, origin, direction, 0.0f, 1e16f, time, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, r, g, b, depth, random);
    return asFloats(r, g, b);
}
DEVICE bool sees(float3 origin, float3 direction, float distance, float time) {
    unsigned hidden = 1;
    optixTrace(params.scene, origin, direction, 0.0f, distance, time, OptixVisibilityMask(255),
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
