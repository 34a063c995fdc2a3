// SPDX-License-Identifier: Apache-2.0
// Launch parameters of voxels.cu.
#pragma once

#include "camera.h"

#include <optix.h>

constexpr int kBrickSide = 8, kBrickVoxels = kBrickSide * kBrickSide * kBrickSide;

// Bricks have sides of 8 voxels of side 1.
struct Brick {
    int x, y, z;                        // of the lowest corner
    unsigned char voxels[kBrickVoxels]; // entries of the palette, 0: empty
};

struct VoxelPaint {
    float3 color, emission;
};

struct VoxelParams {
    float4* image;
    OptixTraversableHandle world;
    const Brick* bricks;
    const VoxelPaint* palette;
    Camera camera;
    float3 sun;
    unsigned samples, bounces;
};
