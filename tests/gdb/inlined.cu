// SPDX-License-Identifier: Apache-2.0
// Functions that compilers inline. Line numbers are named in expected_inlined.cmake and expected_inlined_lines.cmake.
#include <optix.h>

#include "shared_params.h"

extern "C" __constant__ Params params;

static __forceinline__ __device__ unsigned square(unsigned value)
{
    unsigned result = value * value;
    return result + params.bias; // line 12
}

static __forceinline__ __device__ unsigned outer(unsigned first)
{
    unsigned kept = first + 3;
    return square(kept) + kept; // line 18
}

// Two functions of one name.
struct Less {
    unsigned taken;
    __forceinline__ __device__ unsigned operator()(unsigned from) const
    {
        return from - taken;
    }
};
struct More {
    unsigned added;
    __forceinline__ __device__ unsigned operator()(unsigned to) const
    {
        return to + added; // line 33
    }
};

extern "C" __global__ void __raygen__debug()
{
    const unsigned index = optixGetLaunchIndex().x;
    const unsigned kept = outer(index); // line 40
    params.out[index] = More{5}(Less{5}(kept));
}
