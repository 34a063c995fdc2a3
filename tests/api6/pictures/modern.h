// SPDX-License-Identifier: Apache-2.0
// What the host passes to the OptiX 7 programs.
#pragma once

#include <cuda_runtime.h>
#include <optix.h>

struct Params {
    float4* picture;
    const float3* vertices;
    const uint3* triangles;
    const float4* spheres;
    OptixTraversableHandle scene;
};
struct HitData {
    float3 albedo;
};
