// SPDX-License-Identifier: Apache-2.0
// Data that materials_40.cu shares with the host.
#pragma once

#include "camera.h"

#include <optix.h>

constexpr unsigned kMaterials = 40, kMaterialTextures = 5;
// The order of the callables: samplers, evaluators, lights.
constexpr unsigned kEvaluators = kMaterials, kLightCallables = 2 * kMaterials;
constexpr unsigned kLightMaterial = kMaterials; // number of the lamps as a material

struct SurfaceMaterial {
    cudaTextureObject_t textures[kMaterialTextures];
    float3 base;
    float roughness;
};

enum LightKind : unsigned { kQuadLight, kBallLight, kSkyLight };

struct Light {
    unsigned kind;
    float3 corner, u, v; // a ball: its centre and, in u.x, its radius
    float3 emission;
};

struct SkyMap {
    cudaTextureObject_t texture;
    const float* rows;    // height + 1 sums of the rows' weights
    const float* columns; // width + 1 sums for each row
    unsigned width, height;
    float total; // of all weights
};

struct MeshRecord {
    const float3* vertices;
    const uint3* triangles;
    const unsigned char* materials;
    const SurfaceMaterial* table;
};

struct MaterialParams {
    float4* image;
    OptixTraversableHandle scene;
    Camera camera;
    const Light* lights;
    unsigned numLights;
    SkyMap sky;
    unsigned samples, maxDepth;
};
