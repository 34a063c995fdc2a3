// SPDX-License-Identifier: Apache-2.0
// Launch parameters, records and vertices of bidirectional.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

constexpr unsigned kLightVertices = 3;

struct AreaLamp {
    float3 corner, u, v;
    float3 normal;
    float area;
    float3 radiance;
};

// A matt vertex of a light path. `last` and `earlier` are the sums of weights of other techniques,
// dVCM and dVC of Georgiev 2012.
struct LightVertex {
    float3 point, normal, albedo, incoming;
    float3 throughput;
    float last, earlier;
};

struct BidirectionalParams {
    float4* image;
    LightVertex* lightVertices; // kLightVertices for each path
    unsigned* counts;
    unsigned width, height, paths, cameraVertices;
    OptixTraversableHandle room;
    AreaLamp lamp;
    Camera camera;
};

struct BidirectionalRecord {
    MeshView mesh;
    float3 albedo;
    bool isMirror;
};
