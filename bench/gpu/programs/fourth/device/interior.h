// SPDX-License-Identifier: Apache-2.0
// Launch parameters, records and hits of interior.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

// Light from outside, over azimuth and height, with distributions for sampling.
struct Surroundings {
    cudaTextureObject_t radiance; // its fourth channel: the density over the unit square
    cudaTextureObject_t rows;     // the cumulative distribution of rows, one texel high
    cudaTextureObject_t columns;  // of the columns in each row
    unsigned width, height;
};

struct InteriorParams {
    float4* image;
    OptixTraversableHandle room;
    Camera camera;
    Surroundings outside;
    unsigned samples, maxBounces;
};

// The parameters of a principled material, 0 to 1.
struct Principled {
    float3 base;
    float metallic, roughness, specular, sheen, coat, coatGloss;
};

struct InteriorRecord {
    MeshView mesh;
    Principled material;
    cudaTextureObject_t albedo, bumps; // 0: none
    float texturesPerUnit;
};

// The payload is the address of this.
struct InteriorHit {
    float distance; // negative: none
    float3 flat, normal;
    Principled material;
};
