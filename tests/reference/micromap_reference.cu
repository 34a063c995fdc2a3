// SPDX-License-Identifier: Apache-2.0
// Device side of micromap_reference: traces the queries and stores the outcomes.
#include <optix.h>

#include "micromap_scene.h"

extern "C" {
__constant__ Params params;
}

extern "C" __global__ void __raygen__queries() {
    const unsigned int i = optixGetLaunchIndex().x;
    const Query q = params.queries[i];
    unsigned int outcome = 0;
    optixTrace(q.handle, make_float3(q.x, q.y, 1.0f), make_float3(0.0f, 0.0f, -1.0f), 0.0f, 1e16f,
               0.0f, OptixVisibilityMask(0xFF), q.rayFlags, 0, 1, 0, outcome);
    params.outcomes[i] = outcome;
}

extern "C" __global__ void __anyhit__count() {
    optixSetPayload_0(optixGetPayload_0() + kAnyHit);
}

extern "C" __global__ void __closesthit__mark() {
    optixSetPayload_0(optixGetPayload_0() | kHit);
}

extern "C" __global__ void __miss__mark() {
    optixSetPayload_0(optixGetPayload_0() | kMiss);
}
