// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of probes.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

constexpr unsigned kProbeRays = 96, kHarmonics = 4, kLamps = 6;

struct PointLamp {
    float3 position, power;
};

struct ProbeParams {
    float4* image;
    OptixTraversableHandle hall;
    uint3 counts; // of probes
    float3 low, high;
    float3* radiance;     // kProbeRays for each probe
    const float3* before; // kHarmonics for each probe
    float3* after;
    unsigned update, slice;
    PointLamp lamps[kLamps];
    Camera camera;
};

struct ProbeRecord {
    MeshView mesh;
    const float3* normals;
    float3 albedo;
};
