// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of csg.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

// Steps of an expression in postfix order: the number of a solid, or an operation on two results.
enum CsgStep : unsigned char { kCsgSolids = 32, kCsgUnion = kCsgSolids, kCsgBoth, kCsgWithout };

struct CsgPart {
    unsigned first, count; // steps
    float3 color;
    float mirror;
};

struct CsgParams {
    float4* image;
    OptixTraversableHandle parts;
    const CsgPart* expressions; // of instances
    const unsigned char* steps;
    Camera camera;
    float3 sun;
    float floor;
    unsigned samples, openRays;
};

struct CsgRecord {
    MeshView mesh;
    unsigned solid;
};
