// SPDX-License-Identifier: Apache-2.0
// Data that the host of bench_programs shares with its device programs: launch parameters, records.
#pragma once

#include "camera.h"

#include <cuda_runtime.h>

// A photon, a sphere or a brick, by program.
struct Item {
    float3 at;
    float radius;
};

struct ProgramParams {
    float4* image;     // top row first
    float4* extra;     // a second layer: albedo of a G-buffer
    const Item* items; // custom primitives
    const float* grid; // densities of bricks
    unsigned long long scene;
    unsigned long long photons; // a structure over the items
    Camera camera;
    float3 light[3];      // a corner and two edges of the lamp; a direction to the sun in the first
    float3 emission;      // of the lamp or of the sun
    float epsilon, reach; // of offsets; of short rays
    unsigned samples, depth;
    unsigned width, height; // of the picture
    unsigned tile;          // of many small launches
};

enum Surface : unsigned { kMatt, kMirror, kGlass, kGlossy, kLamp };

constexpr unsigned kTextures = 3; // albedo, roughness, normal

// The data of a hit record.
struct Look {
    const float3* vertices; // null where the hit has no mesh
    const uint3* triangles;
    float3 color;
    float roughness;
    unsigned surface;
    unsigned callable;
    cudaTextureObject_t textures[kTextures];
};
