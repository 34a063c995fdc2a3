// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of forest.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

struct ForestParams {
    float4* image;
    OptixTraversableHandle world;
    Camera camera;
    float3 sun;
    unsigned samples;
};

struct ForestRecord {
    MeshView mesh;
    cudaTextureObject_t texture; // 0: solid
    float3 color;
    float cutoff; // of opacity
};
