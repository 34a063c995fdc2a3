// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of landscape.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

enum LandCover : unsigned { kWaterCover, kSandCover, kGrassCover, kRockCover, kSnowCover, kCovers };

struct LandscapeParams {
    float4* image;
    OptixTraversableHandle land;
    Camera camera;
    float3 sun;
    unsigned samples, bounces;
};

struct LandscapeRecord {
    MeshView mesh;
    const float3* normals; // of vertices
};
