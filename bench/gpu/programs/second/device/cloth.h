// SPDX-License-Identifier: Apache-2.0
// Data of cloth.cu and of the kernels in cloth_kernels.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct ClothMotion {
    float3* vertices;
    float3* normals;
    unsigned across; // vertices along a side
    float time;
};

struct ClothParams {
    float4* image;
    OptixTraversableHandle scene;
    Camera camera;
    float3 sun;
};

struct ClothRecord {
    const float3* vertices;
    const float3* normals; // null: those of the triangles
    const uint3* indices;
    float3 color;
    float mirror; // share of reflected light
};
