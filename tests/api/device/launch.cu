// SPDX-License-Identifier: Apache-2.0
// Launch shape, launch parameters and records, without rays.
#include <optix.h>

#include "launch.h"

extern "C" {
__constant__ LaunchParams params;
}

extern "C" __global__ void __raygen__shape() {
    const uint3 index = optixGetLaunchIndex();
    const uint3 size = optixGetLaunchDimensions();
    const unsigned linear = index.x + size.x * (index.y + size.y * index.z);
    LaunchSeen& seen = params.seen[linear];
    ++seen.runs;
    seen.index[0] = index.x;
    seen.index[1] = index.y;
    seen.index[2] = index.z;
    seen.size[0] = size.x;
    seen.size[1] = size.y;
    seen.size[2] = size.z;
    seen.record = reinterpret_cast<const unsigned*>(optixGetSbtDataPointer())[0];
    seen.tail = params.tail[3];
}

// Adds another constant, to distinguish two raygen programs.
extern "C" __global__ void __raygen__other() {
    params.seen[optixGetLaunchIndex().x].runs += 100;
}

// Traces with the miss index of the parameters and lets records answer.
extern "C" __global__ void __raygen__trace() {
    const unsigned i = optixGetLaunchIndex().x;
    unsigned answer = 5;
    optixTrace(params.handle, make_float3(0.0f, 0.0f, -1.0f), make_float3(0.0f, 0.0f, 1.0f), 0.0f,
               10.0f, 0.0f, 255, 0, params.hitIndex, 1, params.missIndex, answer);
    params.seen[i].record = answer;
    ++params.seen[i].runs;
}

extern "C" __global__ void __raygen__call() {
    const unsigned i = optixGetLaunchIndex().x;
    params.seen[i].record = 5;
    params.seen[i].record = optixDirectCall<unsigned>(params.missIndex);
    ++params.seen[i].runs;
}

extern "C" __device__ unsigned __direct_callable__value() {
    return reinterpret_cast<const unsigned*>(optixGetSbtDataPointer())[0];
}

extern "C" __global__ void __miss__value() {
    optixSetPayload_0(reinterpret_cast<const unsigned*>(optixGetSbtDataPointer())[0]);
}

extern "C" __global__ void __closesthit__value() {
    optixSetPayload_0(reinterpret_cast<const unsigned*>(optixGetSbtDataPointer())[0]);
}
