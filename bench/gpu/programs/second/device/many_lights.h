// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of many_lights.cu.
#pragma once

#include "camera.h"

#include <optix.h>

constexpr int kLanterns = 32;

struct Lantern {
    float3 position;
    float3 power;
};

struct LanternParams {
    uchar4* colors;
    float4* image;
    unsigned width, height;
    Camera camera;
    float3 ambient;
    Lantern lanterns[kLanterns];
    OptixTraversableHandle handle;
};

struct LanternRecord {
    const float3* vertices;
    const uint3* indices;
    cudaTextureObject_t mask; // 0: opaque
    float3 diffuse;
};
