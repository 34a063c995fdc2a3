// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs.
#pragma once

#include "camera.h"

#include <optix.h>

// Rows of the shader binding table, and the order in the picture from left to right.
enum Basis : unsigned { kLinear, kQuadratic, kCubic, kCatmullRom, kBasisCount };

// Control points of a strand, equal for all bases.
constexpr unsigned kStrandPoints = 10;

// Of miss programs.
enum RayType : unsigned { kRadianceRay, kShadowRay };

struct HairData {
    float3 color;
    unsigned segmentsPerStrand;
};

struct Params {
    float4* image; // width * height pixels, top row first
    Camera camera;
    float3 lightDirection; // unit length, towards the light
    OptixTraversableHandle scene;
    unsigned samplesPerAxis; // rays for each pixel: the square of this
};
