// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs.
#pragma once

#include "camera.h"

#include <optix.h>

struct Sphere {
    float3 center;
    float radius;
    float3 color;
    float index; // glass: index of refraction
};

// The programs that shade a sphere: the row of the shader binding table.
enum Material : unsigned { kMatte, kCheckered, kMetal, kGlass, kCutout, kMaterialCount };

// Two kinds of rays, so two records for each material.
enum RayType : unsigned { kRadianceRay, kShadowRay, kRayTypeCount };

constexpr unsigned kMaxTraceDepth = 8;

struct Params {
    float4* image; // width * height pixels, top row first
    const Sphere* spheres;
    Camera camera;
    float3 lightDirection; // unit length, towards the light
    OptixTraversableHandle scene;
    unsigned samplesPerAxis; // rays for each pixel: the square of this
};
