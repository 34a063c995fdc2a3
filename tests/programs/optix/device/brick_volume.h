// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Brick { // of the volume: a texture of distances, and where it lies
    cudaTextureObject_t distances;
    cudaSurfaceObject_t visits; // how often a ray enters a column
    float3 low;
    float size;
    int texels;
};
struct Params {
    OptixTraversableHandle scene;
    float4* out; // normal and depth
    cudaTextureObject_t sky;
    int width, height;
};
