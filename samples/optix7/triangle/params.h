// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs: launch parameters and shader-binding-table
// data.
#pragma once

#include "camera.h"

#include <optix.h>

struct Params {
    float4* image; // width * height pixels, top row first
    Camera camera;
    OptixTraversableHandle scene;
};

// Data of the miss record.
struct MissData {
    float3 color;
};

// Data of the hit-group record: one colour for each corner.
struct TriangleData {
    float3 corners[3];
};
