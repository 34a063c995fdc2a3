// SPDX-License-Identifier: Apache-2.0
// Data of rigid_bodies.cu and of its kernels.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

constexpr unsigned kBodyShapes = 8;

struct BodyMotion {
    OptixInstance* instances; // bodies, behind the first two
    OptixTraversableHandle shapes[kBodyShapes];
    float3* water; // vertices of the deforming sheet
    const float2* rest;
    unsigned bodies, waterVertices;
    float time;
};

struct BodyParams {
    float4* image;
    OptixTraversableHandle world;
    Camera camera;
    float3 sun;
    unsigned samples, bounces;
};

struct BodyRecord {
    MeshView mesh;
    float3 color;
    float roughness;
    unsigned material; // the number of a callable
};

// The state of a path, whose address is the payload.
struct BodyPath {
    float3 origin, direction, weight, light;
    unsigned random;
    unsigned isOver, isEntry;
};
