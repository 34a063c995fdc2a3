// SPDX-License-Identifier: Apache-2.0
#pragma once
struct PathState {
    float3 origin, direction;
    float throughput;
    unsigned pixel, seed, bounce;
};
struct HitInfo {
    float3 position, normal;
    int material; // -1: the sky
};
struct TraceParams {
    OptixTraversableHandle scene;
    const PathState* paths;
    const unsigned* order; // the queue
    HitInfo* hits;
    unsigned* shadowed; // of shadow rays, else null
};
struct ShapeData {
    int material;
    float4 sphere;
};
