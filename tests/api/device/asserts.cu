// SPDX-License-Identifier: Apache-2.0
// An assertion in a function that is not inlined.
#include <optix.h>

#include <assert.h>

#include "asserts.h"

extern "C" __constant__ AssertParams params;

static __device__ __noinline__ unsigned checked(unsigned value) {
    assert(value < params.limit); // line 12
    return value * 3;
}

extern "C" __global__ void __raygen__rg() {
    const uint3 index = optixGetLaunchIndex();
    params.out[index.x] = checked(index.x);
}
