// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "many_streams.h"

extern "C" __constant__ Tile params;

extern "C" __global__ void __raygen__tile() {
    const uint3 at = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    unsigned found = 0;
    optixTrace(params.scene, make_float3(at.x + 2 * params.offset, at.y + params.offset, 1),
               make_float3(0, 0, -1), 0, 10, 0, 255, OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, 0, found);
    params.out[at.y * size.x + at.x] = found + params.request;
}
extern "C" __global__ void __closesthit__tile() {
    optixSetPayload_0(1000 * (optixGetPrimitiveIndex() + 1));
}
extern "C" __global__ void __miss__tile() {
    optixSetPayload_0(7000000);
}
