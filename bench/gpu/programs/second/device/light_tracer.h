// SPDX-License-Identifier: Apache-2.0
// Data of light_tracer.cu, light_tracer_lamps.cu and light_tracer_eye.cu, which are modules of two
// pipelines.
#pragma once

#include "camera.h"

#include <optix.h>

struct TracerLamp {
    float3 corner, u, v;
    float3 emission;
};

struct TracerParams {
    float4* image;
    float* film; // three floats a pixel, splats of light paths
    unsigned width, height;
    OptixTraversableHandle hall;
    Camera camera;
    const TracerLamp* lamps;
    unsigned numLamps;
    unsigned numPaths, maxVertices;
};

struct HallRecord {
    const float3* vertices;
    const uint3* indices;
};

// What a ray finds; its address is the payload.
struct HallHit {
    float3 point, normal, albedo;
    unsigned isHit;
};
