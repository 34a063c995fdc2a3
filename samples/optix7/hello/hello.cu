// SPDX-License-Identifier: Apache-2.0
// The smallest device program: every launch index computes the colour of one pixel.
#include <cuda_runtime.h>
#include <optix.h>

#include "params.h"

extern "C" {
__constant__ Params params;
}

extern "C" __global__ void __raygen__gradient() {
    uint3 index = optixGetLaunchIndex();
    uint3 size = optixGetLaunchDimensions();
    float4 color;
    color.x = (index.x + 0.5f) / size.x;
    color.y = (index.y + 0.5f) / size.y;
    color.z = 0.25f;
    color.w = 1.0f;
    params.image[index.y * size.x + index.x] = color;
}
