// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of section_view.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

constexpr int kPlanes = 2;

struct SectionParams {
    float4* image;
    unsigned width;
    OptixTraversableHandle assembly;
    Camera camera;
    float4 planes[kPlanes]; // points with a positive side of both are cut away
    float3 sun;
    int maxLayers; // of glass
};

struct SectionRecord {
    MeshView mesh;
    float3 color;
    float specular;
    float alpha;
    float3 capColor; // of the cut
    float hatchStep, hatchTurn;
    bool isClipped;
    char name[128];
    float bounds[6];
};
