// SPDX-License-Identifier: Apache-2.0
// What the host tells the device programs at each launch.
#pragma once

#include "shading.h"

#include <optix.h>

struct Params {
    float4* sum; // of all samples so far; width * height pixels, top row first
    Camera camera;
    Scene scene;
    OptixTraversableHandle traversable;
    unsigned firstSample; // number of the launch's first sample: 0 starts a new picture
    unsigned sampleCount; // samples to add for each pixel
};

enum RayType : unsigned { kRadianceRay, kShadowRay, kRayTypeCount };
