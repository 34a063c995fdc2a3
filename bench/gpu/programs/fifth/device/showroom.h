// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of showroom.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

enum Finish : unsigned { kEnamel, kBrushed, kCloth, kFrosted, kPlaster, kFinishes };

struct ShowroomLamp {
    float3 at, across, along, power;
};

struct ShowroomParams {
    float4* image;
    OptixTraversableHandle room;
    Camera camera;
    ShowroomLamp lamps[2];
    unsigned samples, maxDepth;
};

struct ShowroomRecord {
    MeshView mesh;
    const float3* normals; // of vertices; null: those of triangles
    cudaTextureObject_t color, relief;
    float3 tint;
    float repeats; // of the textures around the axis
    unsigned finish;
};
