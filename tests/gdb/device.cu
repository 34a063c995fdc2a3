// SPDX-License-Identifier: Apache-2.0
// A program to stop in. Line numbers are named in check.cmake.
#include <optix.h>

#include "shared_params.h"

extern "C" { __constant__ Params params; }

static __device__ __noinline__ unsigned twice(unsigned value)
{
    unsigned result = value * 2;
    return result; // line 12
}

extern "C" __global__ void __raygen__debug()
{
    const uint3 index = optixGetLaunchIndex();
    unsigned sum = params.bias;
    Pair pair = {7, -2.5f};
    float weights[3] = {1.5f, 2.5f, 4.0f};
    for (unsigned i = 0; i < 3; ++i) {
        unsigned term = twice(index.x + i);
        sum += term + unsigned(weights[i]); // line 23
    }
    pair.first += int(sum);
    params.out[index.x] = sum + unsigned(pair.first); // line 26
}
