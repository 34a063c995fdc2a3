// SPDX-License-Identifier: Apache-2.0
#include "params.h"

#include <optix.h>

extern "C" __constant__ Params params;

extern "C" __global__ void __raygen__squares() {
    const unsigned int x = optixGetLaunchIndex().x;
    params.image[x] = FACTOR * x * x;
}
