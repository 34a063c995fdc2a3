// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of radar.cu.
#pragma once

#include "mesh.h"

#include <optix.h>

constexpr unsigned kAngles = 24;

struct RadarParams {
    unsigned long long* cells; // of the histogram, in units of kUnit
    float4* image;
    unsigned ranges, shifts; // cells across and down
    float maxRange, maxShift;
    OptixTraversableHandle world;
    float3 antenna, axis, velocity;
    float beam;                       // half of its angle
    unsigned maxBounces, chirp, rays; // rays of all chirps
};

struct RadarRecord {
    MeshView mesh;
    float3 velocity;
    float roughness;
    float horizontal[kAngles], vertical[kAngles]; // reflectivity by the cosine
};
