// SPDX-License-Identifier: Apache-2.0
// A ray tracing program that writes at the offset of overrun.h, also through a pointer in the
// payload.
#include <optix.h>

#include "overrun.h"

extern "C" {
__constant__ OverrunParams params;
}

static __device__ __noinline__ void addTo(unsigned* total, unsigned value) {
    *total += value;
}

extern "C" __global__ void __raygen__overrun() {
    const unsigned i = optixGetLaunchIndex().x;
    unsigned total = params.weights[i % 4]; // launch parameters by address
    addTo(&total, i);                       // the thread's own stack
    params.out[i + params.shift] = total;   // line: program
}
