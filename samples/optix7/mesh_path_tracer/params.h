// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs at each launch.
#pragma once

#include "shading.h"

#include <optix.h>

// Guides for denoisers from the first surface, as sums over samples like the picture's; all null if
// not needed.
struct Guides {
    float4* albedo;
    float4* normal; // x to the right, y up, z to the camera
    float2* flow;   // pixels moved since previousCamera's picture; not a sum
};

struct Params {
    float4* sum; // of all samples so far; width * height pixels, top row first
    Guides guides;
    Camera camera, previousCamera;
    Scene scene;
    OptixTraversableHandle traversable;
    unsigned firstSample; // number of the launch's first sample: 0 starts a new picture
    unsigned sampleCount; // samples to add for each pixel
    unsigned seed;        // pictures with different ones have independent noise
};

enum RayType : unsigned { kRadianceRay, kShadowRay, kRayTypeCount };
