// SPDX-License-Identifier: Apache-2.0
// Which of 32 watchers see a target: a ray to each, one bit each. There are no hit programs; the
// miss program sets the only payload word.
#include "line_of_sight.h"
#include "tools.h"

extern "C" {
__constant__ SightParams sight;
}

extern "C" __global__ void __miss__visible() {
    optixSetPayload_0(1u);
}

extern "C" __global__ void __raygen__sight() {
    const unsigned target = optixGetLaunchIndex().x;
    const float4 t = sight.targets[target];
    const float3 from = make_float3(t.x, t.y, t.z);
    unsigned word = 0;
    for (unsigned i = 0; i < kWatchers; ++i) {
        const float4 w = __ldg(sight.watchers + i);
        const float3 to = make_float3(w.x - t.x, w.y - t.y, w.z - t.z);
        unsigned visible = 0;
        // The direction has the length of the line, so that the interval is that of its points.
        optixTrace(sight.world, from, to, 0.0f, 0.999f, 0.0f, OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                       OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
                   0, 0, 0, visible);
        word |= visible << i;
    }
    sight.seenBy[target] = word;
}
