// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs, and the mask that both read.
#pragma once

#include "camera.h"

#include <optix.h>

// The mask of a leaf: one byte for each texel, 255 inside and 0 outside, lower row first.
struct Mask {
    const unsigned char* texels;
    unsigned size; // across and down

    // Without filtering, so that a single texel decides.
    SAMPLE_INLINE bool covers(float u, float v) const {
        const unsigned x = unsigned(clamp01(u) * float(size)),
                       y = unsigned(clamp01(v) * float(size));
        const unsigned last = size - 1;
        return texels[(y < last ? y : last) * size + (x < last ? x : last)] != 0;
    }
};

// A leaf is a square of two triangles: (0,0) (1,0) (1,1) and (0,0) (1,1) (0,1).
SAMPLE_INLINE float2 leafCoordinates(unsigned triangle, float2 barycentrics) {
    float2 uv;
    uv.x = triangle & 1 ? barycentrics.x : barycentrics.x + barycentrics.y;
    uv.y = triangle & 1 ? barycentrics.x + barycentrics.y : barycentrics.y;
    return uv;
}

enum Material : unsigned { kLeaf, kGround, kMaterialCount };
enum RayType : unsigned { kRadianceRay, kShadowRay, kRayTypeCount };
constexpr unsigned kMaxTraceDepth = 2;

struct Params {
    float4* image;         // width * height pixels, top row first; the fourth value counts any-hits
    const float3* normals; // for each pair of triangles
    Mask mask;
    Camera camera;
    float3 lightDirection; // unit length, towards the light
    OptixTraversableHandle scene;
    unsigned samplesPerAxis; // rays for each pixel: the square of this
};
