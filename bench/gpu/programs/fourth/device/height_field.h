// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of height_field.cu.
#pragma once

#include "camera.h"

#include <optix.h>

// A tile has 32 x 32 cells; its pyramid has 1, 2, 4, 8, 16 and 32 nodes along a side.
constexpr int kTileLevels = 5, kTileCells = 1 << kTileLevels;
constexpr int kTileNodes = ((1 << 2 * (kTileLevels + 1)) - 1) / 3;

struct HeightRange {
    float low, high;
};

// Heights over the square of side `across` - 1, which instances repeat in mirrored copies.
struct HeightRecord {
    const float* heights;
    const HeightRange* ranges; // kTileNodes of each tile, the coarsest first
    int across, tiles;         // vertices and tiles along a side
};

struct HeightParams {
    float4* image;
    OptixTraversableHandle land;
    Camera camera;
    float3 sun;
    unsigned samples, skyRays;
    float snowLine, haze;
};
