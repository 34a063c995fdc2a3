// SPDX-License-Identifier: Apache-2.0
// Every launch index holds a lock while it traces a ray, then waits for its predecessor.
#include <optix.h>

#include "launch.h"

extern "C" {
__constant__ LaunchParams params;
}

static __forceinline__ __device__ unsigned trace() {
    unsigned answer = 5;
    optixTrace(params.handle, make_float3(0.0f, 0.0f, -1.0f), make_float3(0.0f, 0.0f, 1.0f), 0.0f,
               10.0f, 0.0f, 255, 0, 0, 1, 0, answer);
    return answer;
}

extern "C" __global__ void __raygen__locked() {
    unsigned* const lock = &params.seen[0].runs;
    unsigned* const sum = &params.seen[0].record;
    for (bool isDone = false; !isDone;) {
        if (atomicCAS(lock, 0u, 1u) != 0)
            continue;
        __threadfence();
        *sum += trace();
        __threadfence();
        atomicExch(lock, 0u);
        isDone = true;
    }
}

extern "C" __global__ void __miss__answer() {
    optixSetPayload_0(3);
}
