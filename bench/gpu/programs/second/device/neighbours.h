// SPDX-License-Identifier: Apache-2.0
// Launch parameters of neighbours.cu.
#pragma once

#include <cuda_runtime.h>

#include <optix.h>

constexpr unsigned kNeighbours = 8;

struct NeighbourParams {
    const float3* points;
    const float3* queries;
    unsigned* neighbours; // kNeighbours a query, nearest first, ~0 where there are fewer
    float4* summary;
    OptixTraversableHandle index;
    float radius;
    unsigned numQueries;
};
