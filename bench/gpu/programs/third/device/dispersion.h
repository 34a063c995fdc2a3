// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of dispersion.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

struct DispersionParams {
    float4* image;
    OptixTraversableHandle scene;
    Camera camera;
    float3 sun;
    unsigned wavelengths, maxDepth;
};

struct GemRecord {
    MeshView mesh;
    float index, dispersion; // of Cauchy, the second in square micrometres
    float3 absorption;       // at 620, 540 and 460 nm
};
