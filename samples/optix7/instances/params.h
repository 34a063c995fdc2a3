// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs.
#pragma once

#include "camera.h"

#include <optix.h>

// Rows of the shader binding table, added by the instances that refer to geometry.
enum Shape : unsigned { kCube, kGround, kShapeCount };

struct Params {
    float4* image; // width * height pixels, top row first
    Camera camera;
    float3 sunDirection; // unit length, towards the sun
    OptixTraversableHandle scene;
    unsigned samples; // paths for each pixel
    float epsilon;    // distance by which rays leave a surface
};
