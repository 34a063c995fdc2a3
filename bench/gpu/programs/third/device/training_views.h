// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of training_views.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

struct ViewParams {
    float4* image; // the views in rows of `across`
    float* depths;
    unsigned* labels;
    OptixTraversableHandle world;
    const Camera* cameras;
    unsigned firstView, viewWidth, viewHeight, across;
    float3 sun;
};

struct ViewRecord {
    MeshView mesh;
};
