// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of gradients.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

// What light depends on: the place of the lamp, its power, how much walls scatter and mirrors
// reflect.
enum Unknown : unsigned { kLampX, kLampY, kLampZ, kLampPower, kScatter, kReflect, kUnknowns };

struct GradientParams {
    float4* image;
    OptixTraversableHandle room;
    Camera camera;
    float unknowns[kUnknowns];
    unsigned samples, maxDepth;
};

struct GradientRecord {
    MeshView mesh;
    float3 albedo;
    float mirror; // share of mirrored light
};
