// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of preview.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct PreviewLamp {
    float3 corner, u, v;
    float3 normal;
    float area;
    float3 emission;
};

struct PreviewParams {
    float4* mean;  // of all samples so far
    uchar4* shown; // for a window
    unsigned width, height;
    unsigned samplesSoFar;
    unsigned maxBounces;
    Camera camera;
    PreviewLamp lamp;
    OptixTraversableHandle room;
};

struct PreviewRecord {
    float3 emission;
    float3 albedo;
    const float3* vertices;
    const uint3* indices;
    float gloss; // share of mirrored paths
};
