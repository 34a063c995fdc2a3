// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of city.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

struct HazeMaterial {
    float3 wall, glass;
    float storey;    // height of a storey; 0: no windows
    float lampShare; // of windows with light
};

struct HazeParams {
    float4* image;
    OptixTraversableHandle city;
    const HazeMaterial* materials; // of instances
    Camera camera;
    float3 sun;
    float haze, hazeHeight; // density at the ground, and the height over which it falls
    unsigned hazeSteps, samples, maxDepth;
};

struct HazeRecord {
    MeshView mesh;
};
