// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of subsurface.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

struct SubsurfaceParams {
    float4* image;
    OptixTraversableHandle world;
    Camera camera;
    float3 sun, sunlight;
    unsigned maxSteps; // of a walk
    unsigned samples;
};

struct SubsurfaceRecord {
    MeshView mesh;
    const float3* normals;
    float3 albedo;
    float reach; // mean length of a step below the surface, 0: opaque
};
