// SPDX-License-Identifier: Apache-2.0
// Data of mixed_shapes.cu and mixed_shapes_round.cu, two modules of one pipeline.
#pragma once

#include "camera.h"

#include <optix.h>

struct MixedParams {
    float4* image;
    OptixTraversableHandle handle;
    Camera camera;
    float3 sun;
    float reach; // of ambient occlusion
    unsigned occlusionRays;
};

struct MixedBox {
    float3 center, half;
};

// Each kind of shape uses its own members.
struct MixedRecord {
    float3 color;
    union {
        struct {
            const float3* vertices;
            const uint3* indices;
        } mesh;
        const float4* balls; // centre and radius
        const MixedBox* boxes;
    };
};

// The payload is the address of this.
struct MixedHit {
    float3 point, normal, color;
    float distance; // negative: none
};
