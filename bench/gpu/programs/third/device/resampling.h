// SPDX-License-Identifier: Apache-2.0
// Launch parameters of resampling.cu, and what it keeps of a pixel.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

struct Lamp {
    float3 corner, u, v;
    float3 radiance; // downwards
};

struct PixelSurface {
    float3 point, normal, albedo;
    float distance; // negative: none
};

// A lamp, a place on it, and the weights of the candidates that it stands for.
struct Reservoir {
    unsigned lamp;
    float u, v;
    float sum, count;
    float weight; // of the place in the estimate, 0: none
};

struct ResamplingParams {
    float4* image;
    PixelSurface* surfaces;
    Reservoir* found; // of the sample
    Reservoir* kept;  // of the sample before
    unsigned width, height, sample;
    OptixTraversableHandle hall;
    MeshView mesh;
    const Lamp* lamps;
    unsigned lampCount, candidates, neighbours;
    float radius; // of neighbours, in pixels
    Camera camera;
};
