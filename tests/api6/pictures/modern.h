// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of the OptiX 7 programs.
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
