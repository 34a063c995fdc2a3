// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of nested_glass.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

// Media, the one with the highest priority first. Where bodies overlap, the first counts.
enum Medium : unsigned { kBubble, kIce, kTumbler, kTea, kWine, kMedia };

struct MediumLook {
    float3 absorption; // per length
    float index;
};

struct NestedParams {
    float4* image;
    OptixTraversableHandle table;
    Camera camera;
    MediumLook media[kMedia + 1]; // the last: air
    float3 lamp[3];               // a corner and two edges
    float3 emission;
    unsigned samples, maxDepth;
};

struct NestedRecord {
    MeshView mesh;
    float3 color; // of solid things
    unsigned medium;
    unsigned isTiled;
};
