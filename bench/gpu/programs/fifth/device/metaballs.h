// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of metaballs.cu.
#pragma once

#include "camera.h"

#include <optix.h>

constexpr unsigned kBlobsOfDrop = 8;

// A sum of fields of balls; the surface is where it is 0.25.
struct MetaballDrop {
    float3 centers[kBlobsOfDrop];
    float radii[kBlobsOfDrop]; // where fields end
    float3 colors[2];
    float mirror;
};

struct MetaballParams {
    float4* image;
    OptixTraversableHandle hall;
    Camera camera;
    float3 sun;
    unsigned samples, maxDepth, steps;
};

struct MetaballRecord {
    const MetaballDrop* drops;
};
