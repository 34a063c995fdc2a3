// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of robots.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct RobotParams {
    float4* image;
    OptixTraversableHandle world;
    Camera camera;
    float3 sun;
    unsigned samples;
};

struct PartRecord {
    const float3* vertices;
    const uint3* indices;
    float3 color;
    bool isPainted; // in a colour of the instance
};
