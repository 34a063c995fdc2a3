// SPDX-License-Identifier: Apache-2.0
// Launch parameters of lightmap.cu.
#pragma once

#include <cuda_runtime.h>

#include <optix.h>

struct LightmapParams {
    float4* texels;
    const float4* positions;
    const float4* normals;
    const float4* leaving; // light of each triangle, from an earlier pass
    OptixTraversableHandle handle;
    int raysPerTexel; // bound when the module is compiled
    float bias;
    unsigned firstTexel;
    unsigned seed;
};
