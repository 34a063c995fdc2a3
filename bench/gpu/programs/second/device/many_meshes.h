// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of many_meshes.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct CityParams {
    float4* image;
    OptixTraversableHandle world;
    Camera camera;
    float3 sun;
    unsigned samples, maxDepth;
};

struct CityRecord {
    const float3* vertices;
    const uint3* indices;
    cudaTextureObject_t albedo;
    float3 color;
    float roughness;
    float scale; // of texture coordinates
};
