// SPDX-License-Identifier: Apache-2.0
// Data and functions that the three modules of the program fur share.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

struct FurLight {
    float3 direction, power;
};

struct FurParams {
    float4* image;
    OptixTraversableHandle world;
    Camera camera;
    FurLight lights[2];
    unsigned samples;
};

struct FurRecord {
    MeshView mesh; // of skin
    float3 color;
    float3 absorption; // of hair, for the width of a strand
    float roughness;
};

// Angles between the strand, the light and the eye, for a lobe.
struct FurAngles {
    float sinLight, sinEye; // to the plane across the strand
    float cosAround;        // between both in that plane
    float offset;           // of the strand, -1 to 1
    float roughness;
    float3 absorption;
};

#ifdef __CUDACC__
#include "tools.h"

extern "C" {
__constant__ FurParams params;
}

static __forceinline__ __device__ void setFurColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}
// The share of light that arrives between strands.
static __forceinline__ __device__ float veilTowards(float3 point, float3 direction) {
    unsigned share = __float_as_uint(1.0f), unused = 0;
    optixTrace(params.world, point, direction, 5e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT | OPTIX_RAY_FLAG_ENFORCE_ANYHIT, 1, 2, 1, share,
               unused, unused);
    return __uint_as_float(share);
}
#endif
