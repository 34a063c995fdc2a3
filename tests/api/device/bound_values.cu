// SPDX-License-Identifier: Apache-2.0
// Reads launch parameters in ways that can be specialised, and in ways that cannot.
#include <optix.h>

#include "bound_values.h"

extern "C" {
__constant__ BoundParams params;
}

static __noinline__ __device__ unsigned through(const unsigned* pointer) {
    return *pointer;
}

extern "C" __global__ void __raygen__bound() {
    const unsigned i = optixGetLaunchIndex().x;
    unsigned* out = params.results + 4 * i;
    out[0] = params.mode == 3 ? 300 + params.other : 400;
    out[1] = unsigned(params.scale * 8.0f);
    out[2] = params.table[i & 3];
    out[3] = through(&params.table[1]);
}
