// SPDX-License-Identifier: Apache-2.0
// Launch parameters of radiosity.cu and the argument of radiosity_kernels.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct Patch {
    float3 corner, u, v;
    float3 normal;
    float area;
    float3 albedo, emission;
};

struct RadiosityParams {
    float4* image;
    OptixTraversableHandle room;
    const Patch* patches;
    unsigned count, samples;
    float* factors; // row i: the shares of the view of patch i
    const float4* light;
    Camera camera;
};

struct RadiosityStep {
    const Patch* patches;
    const float* factors;
    float4* before;
    float4* after;
    unsigned count;
};
