// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs.
#pragma once

#include "camera.h"

#include <optix.h>

// Kinds of geometry: rows of the shader binding table for the programs of each.
enum Shape : unsigned { kMesh, kGround, kBall, kShapeCount };

// The centre of a ball at the motion keys of its structure.
constexpr unsigned kBallKeys = 5;

struct HitData {
    float3 color;
    float3 ball[kBallKeys]; // of kBall: centres at the keys
    float radius;
};

struct Params {
    float4* image; // width * height pixels, top row first
    Camera camera;
    float3 sunDirection; // unit length, towards the sun
    OptixTraversableHandle scene;
    unsigned samples; // paths for each pixel, each at its own time
    float epsilon;    // distance by which rays leave a surface
};
