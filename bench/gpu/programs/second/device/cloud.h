// SPDX-License-Identifier: Apache-2.0
// Launch parameters of cloud.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct CloudParams {
    float4* image;
    OptixTraversableHandle ground;
    cudaTextureObject_t density; // 1 at most
    float3 low, high;            // the box of the cloud
    float extinction;            // at density 1
    float forward;               // mean cosine of the phase function
    float3 sun, sunlight;
    Camera camera;
    unsigned maxEvents;
};

struct GroundRecord {
    const float3* vertices;
    const uint3* indices;
    float3 albedo;
};
